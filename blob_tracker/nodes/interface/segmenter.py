"""What the segmenter node shows of itself."""

from blob_tracker.nodes.interface.channel import SEGMENTER_CHANNEL
from blob_tracker.nodes.interface.flash import FLASH
from blob_tracker.nodes.interface.line_time import LINE_TIME
from blob_tracker.nodes.interface.response import RESPONSE
from blob_tracker.nodes.interface.saturation import SATURATION
from blob_tracker.nodes.interface.topics import (
    CAMERA_IMAGE, CAMERA_INFO, COMPRESSED_IMAGE, DIAGNOSTICS, NOISE, SEGMENTER_PICTURE, TRACK,
    VISIBLE, WINDOW_IMAGE, WINDOW_INFO,
)
from blob_tracker.ros.interface import Interface, Parameter
from blob_tracker.segmentation import REGISTRATIONS, THRESHOLDS

PARAMETERS = (
    Parameter(
        'image_transport',
        'raw',
        'How the frames of another driver or a bag arrive, as image_transport names it. '
        'compressed: as JPEG or PNG on camera/image_raw/compressed; the rounding of a JPEG is in '
        'the covariance.',
        choices=('raw', 'compressed'),
    ),
    Parameter(
        'camera_info_url',
        '',
        "Calibration to use if another driver's or a bag's frames come without a camera_info, or "
        'with K 0: a path, file:// or package:// URL. Images must then have its size. The camera '
        'node in the same process reads its own.',
    ),
    *FLASH,
    Parameter(
        'flash.frames',
        16,
        'Frames over which the mode lock_in demodulates: more find a fainter light and give fewer '
        'windows. The light must stand still meanwhile.',
        least=4,
        most=256,
    ),
    LINE_TIME,
    SEGMENTER_CHANNEL,
    Parameter(
        'jpeg_quality',
        0,
        'Quality (libjpeg) of frames that came as JPEG; its rounding is then in the covariance. '
        '0: none did, or what the camera in this process says.',
        least=0,
        most=100,
    ),
    Parameter(
        'min_snr',
        7.0,
        'Least SNR of the target in a filter matched to its width. Below 6, noise alone reaches '
        'it somewhere in a frame; near the predicted position 0.85 of it is enough.',
        least=3.0,
        most=1000.0,
    ),
    Parameter(
        'max_pair_interval',
        0.0,
        'Longest time between the lit and the unlit frame; lower it if the camera moves fast. 0: '
        '0.1 s, or for a camera below 15 Hz one and a half of its frame intervals.',
        least=0.0,
        most=10.0,
        unit='s',
    ),
    Parameter(
        'registration',
        'none',
        'How the unlit frame is laid over the lit one in the mode alternate, for a camera that '
        'moves between the two: translation follows a shift, affine a rotation as well. Either '
        'costs milliseconds a frame, and needs a scene with texture.',
        choices=tuple(REGISTRATIONS),
    ),
    Parameter(
        'gate',
        24.0,
        'How far the target may move in the picture from one flash to the next while its motion '
        'is not known yet. In mode alternate it separates what flashes again from what is new.',
        least=1.0,
        most=1000.0,
        unit='px',
    ),
    Parameter(
        'follow_prediction',
        False,
        'Look for the light where the tracker expects it, however far it moved, and in the whole '
        'frame if it is not there. Useful in mode alternate, with a tracker that knows the '
        'platform. Off, a bag gives the same numbers each time.',
    ),
    Parameter(
        'rehearse',
        True,
        'Run search and fit once before a lit frame, which finds them in the caches. In the mode '
        'alternate, up to 200 Hz; a frame takes a third less time, and 1 % more of a core is used '
        'at 60 Hz.',
    ),
    Parameter(
        'threshold.method',
        'sigma_window',
        'How the window around the peak is found. The default follows the width of the blob; the '
        "others are the thesis' own, made for its location methods.",
        choices=tuple(THRESHOLDS),
    ),
    Parameter(
        'threshold.sigmas',
        3.0,
        "Half-width of sigma_window in sigmas of the blob. The thesis' optimum is 2.8; what lies "
        'further out adds noise to all methods but maximum likelihood.',
        least=1.0,
        most=10.0,
    ),
    Parameter(
        'threshold.extension',
        2,
        'Pixels that histogram_extended adds on each side, to take in the tails.',
        least=0,
        most=64,
        unit='px',
    ),
    Parameter(
        'max_blob',
        128,
        'Largest half-width of the window; anything wider is not a target.',
        least=4,
        most=1024,
        unit='px',
    ),
    Parameter(
        'looks',
        1,
        'Pairs of a still target to sum in one window; the thesis has 5. Give the locator the '
        'same number.',
        least=1,
        most=256,
    ),
    Parameter(
        'mask_url',
        '',
        'Image of 8 bits and of the size of the frames, white where the target may be: a path, '
        'file:// or package:// URL. Empty searches everywhere.',
    ),
    SATURATION,
    RESPONSE,
    Parameter(
        'noise.measure',
        False,
        'Measure gain and read noise from the unlit frames once a second, for target/noise. It '
        'needs a nearly still scene of more than one brightness, and raw pixels.',
    ),
    Parameter(
        'lost_after',
        0.2,
        'Time without a target, by the stamps, after which target/visible turns false. A coded '
        'light must be lit at some time in it; a block of mode lock_in is always waited for.',
        least=0.001,
        most=60.0,
        unit='s',
    ),
)
INTERFACE = Interface(
    'segmenter',
    'what flashes',
    'Finds the flash in the frames and cuts its pixels out, lit and unlit.',
    PARAMETERS,
    subscribed=(CAMERA_IMAGE, COMPRESSED_IMAGE, CAMERA_INFO, TRACK),
    published=(WINDOW_IMAGE, WINDOW_INFO, VISIBLE, NOISE, SEGMENTER_PICTURE, DIAGNOSTICS),
    each_light=(WINDOW_IMAGE, WINDOW_INFO, VISIBLE),
    examples=(
        'ros2 run blob_tracker segmenter --ros-args -p registration:=translation',
        'ros2 param set /segmenter min_snr 8.0',
        'ros2 run rqt_image_view rqt_image_view /segmenter/debug_image',
    ),
)

"""What the locator node shows of itself."""

from blob_tracker.location import METHODS
from blob_tracker.nodes.interface.line_time import LINE_TIME
from blob_tracker.nodes.interface.response import RESPONSE
from blob_tracker.nodes.interface.saturation import SATURATION
from blob_tracker.nodes.interface.topics import (
    BEARING, CENTROID, DIAGNOSTICS, NOISE, RANGE, RAY, WINDOW_IMAGE, WINDOW_INFO, WINDOW_PICTURE,
)
from blob_tracker.ros.interface import Interface, Parameter

DEFAULT_METHOD = 'maximum_likelihood'
PARAMETERS = (
    Parameter(
        'method',
        DEFAULT_METHOD,
        'How the blob is located in its window. The default reaches the limit that the noise '
        "sets; the others are the thesis' own, locale_table the look-up that it proposes.",
        choices=tuple(METHODS),
    ),
    Parameter(
        'elliptical',
        False,
        'Fit a width along x and one along y, for a lens or a light that does not make round '
        'blobs; only for methods that have both forms.',
    ),
    Parameter(
        'noise.gain',
        40.0,
        'Electrons per DN of the camera: the slope of its photon transfer curve. It sets the '
        'shot noise in the covariance.',
        least=1e-3,
        most=1e6,
        unit='e-/DN',
    ),
    Parameter(
        'noise.read_noise',
        0.7,
        'Standard deviation of a dark pixel before quantisation. It sets the covariance of faint '
        'targets.',
        least=0.0,
        most=1e4,
        unit='DN',
    ),
    Parameter(
        'noise.black_level',
        0.0,
        'Mean of a pixel without light, the pedestal: it has no shot noise.',
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    Parameter(
        'noise.online',
        False,
        'Take all three from target/noise as soon as they arrive; the segmenter measures them '
        '(noise.measure). Off, a bag gives the same numbers each time.',
    ),
    Parameter(
        'looks',
        1,
        "Frames summed in a window, as the segmenter's diagnostics say: the covariance counts the "
        'read noise as often.',
        least=1,
        most=256,
    ),
    SATURATION,
    RESPONSE,
    LINE_TIME,
    Parameter(
        'line_jitter_url',
        '',
        'Line offsets of an analogue grabber, as `calibrate jitter` writes them, to correct each '
        'location: path, file:// or package://. Empty for a digital camera.',
    ),
    Parameter(
        'pulse_url',
        '',
        'Shape of the blob, as `calibrate pulse` writes it, for maximum_likelihood to fit in '
        'place of the Gaussian: path, file:// or package://. If it does not fit, or belongs to '
        'another camera, the Gaussian is used.',
    ),
    Parameter(
        'pulse.learn',
        False,
        'Learn the shape of each light while it is tracked, and fit it once it has been shown to '
        'fit better. It is written to pulse_url if there is no such file yet. Off, a bag gives '
        'the same numbers wherever it starts.',
    ),
    Parameter(
        'lights',
        '',
        'Names of the lights to locate, as in flash.codes: port,starboard. Empty for a light '
        'without a name. The pipeline locates them all.',
    ),
    Parameter(
        'range.psf_sigma',
        0.0,
        'Width (sigma) of the image of a point: that of the blob in the diagnostics, for a light '
        'so far away that its size does not matter. Above 0 they show radius and flux too.',
        least=0.0,
        most=100.0,
        unit='px',
    ),
    Parameter(
        'range.diameter',
        0.0,
        'Diameter of the light, if it is an even disc or ball: target/range then follows from its '
        'size in the picture. 0: unknown.',
        least=0.0,
        most=1e4,
        unit='m',
    ),
    Parameter(
        'range.reference_distance',
        0.0,
        'Distance at which the flux was range.reference_flux: target/range then follows from the '
        'flux. 0: not measured.',
        least=0.0,
        most=1e6,
        unit='m',
    ),
    Parameter(
        'range.reference_flux',
        0.0,
        'Flux of the light at range.reference_distance, as the diagnostics show it. Exposure and '
        'gain must stay as they were then.',
        least=0.0,
        most=1e9,
        unit='DN',
    ),
    Parameter(
        'range.calibration_sigma',
        0.01,
        'How well these four are known, relative: it is in the variance of the range, and the '
        'same error in each.',
        least=0.0,
        most=1.0,
    ),
)
INTERFACE = Interface(
    'locator',
    'where it is',
    'Places the blob of each window far below a pixel and publishes the angle at which it is '
    'seen, with its covariance.',
    PARAMETERS,
    subscribed=(WINDOW_IMAGE, WINDOW_INFO, NOISE),
    published=(BEARING, CENTROID, RAY, RANGE, WINDOW_PICTURE, DIAGNOSTICS),
    each_light=(WINDOW_IMAGE, WINDOW_INFO, BEARING, CENTROID, RAY, RANGE),
    examples=(
        'ros2 run blob_tracker locator --ros-args --params-file noise.yaml',
        'ros2 param set /locator method gaussian_linear',
        'ros2 topic echo /target/bearing',
    ),
)

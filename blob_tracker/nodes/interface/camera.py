"""What the camera node shows of itself."""

from blob_tracker.capture import PIXEL_FORMATS
from blob_tracker.capture.fields import CHOICES
from blob_tracker.nodes.interface.channel import CAMERA_CHANNEL
from blob_tracker.nodes.interface.line_time import CAMERA_LINE_TIME
from blob_tracker.nodes.interface.topics import (
    CAMERA_IMAGE, CAMERA_INFO, DIAGNOSTICS, FRAME_PICTURE,
)
from blob_tracker.ros.interface import Interface, Parameter, Service
from blob_tracker.ros.parameters.url import DEFAULT_CALIBRATION_URL

PARAMETERS = (
    Parameter(
        'device',
        '/dev/video0',
        'The camera: its path, or a link in /dev/v4l/by-id or by-path, followed at each opening.',
    ),
    Parameter(
        'width', 0, "Width of the frames; 0 keeps the driver's.", 0, 16384, unit='px'
    ),
    Parameter(
        'height', 0, "Height of the frames; 0 keeps the driver's.", 0, 16384, unit='px'
    ),
    Parameter(
        'pixel_format',
        '',
        "FourCC of the pixels; empty keeps the camera's own if it can be read uncompressed.",
        choices=('', *PIXEL_FORMATS),
    ),
    CAMERA_CHANNEL,
    Parameter(
        'fields',
        '',
        'How interlaced pictures are asked for, as V4L2 names it; empty takes whole pictures if '
        'the driver has them. Each field is a frame. interlaced_tb or _bt also says which field '
        'is first, top or bottom, if the driver leaves that to the video standard.',
        choices=CHOICES,
    ),
    Parameter(
        'frame_rate',
        0.0,
        "Frames a second (of interlaced pictures, fields); 0 keeps the driver's.",
        least=0.0,
        most=10000.0,
        unit='Hz',
    ),
    Parameter(
        'buffers',
        4,
        'Buffers in the driver: more of them bridge longer pauses of this machine.',
        least=2,
        most=32,
    ),
    Parameter(
        'exposure_time',
        0.0,
        'Exposure, if the camera has no control that gives it: the stamp is put into its middle; '
        '0 is unknown.',
        least=0.0,
        most=100.0,
        unit='s',
    ),
    Parameter(
        'readout_time',
        0.0,
        'From the end of the exposure to the end of the transfer, if the driver stamps the '
        'latter; 0 is unknown.',
        least=0.0,
        most=100.0,
        unit='s',
    ),
    CAMERA_LINE_TIME,
    Parameter(
        'rolling_shutter',
        False,
        "If line_time is 0, take the line time from the sensor's controls hblank and pixel_rate. "
        'Sensors with a global shutter have them too: no control says which kind it is.',
    ),
    Parameter('frame_id', 'camera_optical_frame', 'Name of the optical frame.'),
    Parameter(
        'camera_name', 'camera', 'Name of the camera in its calibration, and ${NAME} in its URL.'
    ),
    Parameter(
        'camera_info_url',
        '',
        'Calibration: a path, file:// or package:// URL of an existing file. Empty is '
        f'{DEFAULT_CALIBRATION_URL}, which set_camera_info may write first. Without a '
        'calibration, and without field_of_view, K is 0 and no bearing can be computed.',
    ),
    Parameter(
        'field_of_view',
        0.0,
        'Horizontal field of view of the lens by its data sheet, for a camera that is not yet '
        'calibrated; 0 is unknown. Angles made with it are as good as the data sheet.',
        least=0.0,
        most=170.0,
        unit='degrees',
    ),
)
INTERFACE = Interface(
    'camera',
    'frames',
    'Streams a V4L2 camera. Every control of the camera (exposure, gain ...) is a parameter too, '
    'with its own range or menu, once the camera is open: `ros2 param list /camera`.',
    PARAMETERS,
    published=(CAMERA_IMAGE, CAMERA_INFO, FRAME_PICTURE, DIAGNOSTICS),
    services=(
        Service(
            'camera/set_camera_info',
            'sensor_msgs/SetCameraInfo',
            'store a calibration and use it from the next frame on',
        ),
        Service(
            'camera/find_exposure',
            'std_srvs/Trigger',
            'search once for the exposure and gain that put the lit peak, in the colour of the '
            'light, at 70 % of full scale',
        ),
    ),
    examples=(
        'ros2 run blob_tracker camera --ros-args -p device:=/dev/video0 '
        '-p camera_info_url:=camera.yaml',
        'ros2 param set /camera frame_rate 60.0',
        'ros2 service call /camera/find_exposure std_srvs/srv/Trigger',
    ),
)

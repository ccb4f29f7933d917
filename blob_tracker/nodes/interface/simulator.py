"""What the simulator node shows of itself."""

from blob_tracker.nodes.interface.flash import FLASH
from blob_tracker.nodes.interface.topics import (
    CAMERA_IMAGE, CAMERA_INFO, DIAGNOSTICS, FRAME_PICTURE, IMU, JOINT_COMMAND, JOINT_STATES,
    TRUE_BEARING, TRUE_CENTROID, TRUE_POSE,
)
from blob_tracker.ros.interface import Interface, Parameter
from blob_tracker.simulation import flashing_light, PROFILES
from blob_tracker.simulation.platform_motion import MOTIONS

STILL = 'still'
_SCENE = flashing_light()
_LIGHT, _SENSOR = _SCENE.truth(0), _SCENE.sensor
PARAMETERS = (
    Parameter('width', _SCENE.width, 'Width of the frames.', least=16, most=8192, unit='px'),
    Parameter('height', _SCENE.height, 'Height of the frames.', least=16, most=8192, unit='px'),
    Parameter('rate', _SCENE.rate, 'Frames a second.', least=0.1, most=1000.0, unit='Hz'),
    Parameter(
        'focal_length', 600.0, 'Focal length of the lens.', least=1.0, most=1e6, unit='px'
    ),
    Parameter(
        'profile',
        'gaussian',
        "Shape of the light's image: a Gaussian, the three of the thesis, or one with a tail.",
        choices=tuple(PROFILES),
    ),
    Parameter(
        'sigma',
        _LIGHT.sigma,
        "Standard deviation of the light's image, or of the narrowest Gaussian in it.",
        least=0.1,
        most=100.0,
        unit='px',
    ),
    Parameter(
        'amplitude',
        _LIGHT.amplitude,
        'Peak of the light above the background.',
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    *FLASH,
    Parameter(
        'clock_error',
        0.0,
        'How much too fast the clocks of free-running lights are, as a part of their rate.',
        least=-0.02,
        most=0.02,
    ),
    Parameter(
        'reach',
        0.7,
        "Largest distance of a light's path from the middle, as a part of half the picture.",
        least=0.0,
        most=2.0,
    ),
    Parameter(
        'period',
        9.0,
        'Time after which a light is at the same position again: a third of it takes it down the '
        'picture and back.',
        least=0.01,
        most=1e6,
        unit='s',
    ),
    Parameter(
        'background',
        _SCENE.background,
        'Mean level of the wall behind it.',
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    Parameter(
        'texture',
        _SCENE.texture,
        "Standard deviation of the wall's pattern.",
        least=0.0,
        most=65535.0,
        unit='DN',
    ),
    Parameter(
        'bits',
        _SENSOR.bits,
        'Bits of a pixel: full scale is 2^bits - 1 DN, and above 8 the frames are mono16.',
        least=1,
        most=16,
    ),
    Parameter(
        'row_time',
        _SENSOR.row_time,
        'Time from the exposure of a row to that of the next: 0 for a global shutter.',
        least=0.0,
        most=1e-3,
        unit='s',
    ),
    Parameter(
        'noise.gain',
        _SENSOR.noise.gain,
        'Electrons per DN of the sensor.',
        least=1e-3,
        most=1e6,
        unit='e-/DN',
    ),
    Parameter(
        'noise.read_noise',
        _SENSOR.noise.read_noise,
        'Noise of a dark pixel before quantisation.',
        least=0.0,
        most=1e4,
        unit='DN',
    ),
    Parameter(
        'seed',
        _SCENE.seed,
        'Seed of wall and noise: the same one gives the same pixels.',
        least=0,
        most=2**31 - 1,
    ),
    Parameter('frame_id', 'camera_optical_frame', 'Name of the optical frame.'),
    Parameter(
        'body_url',
        '',
        'Where the lights of flash.codes, or as many as flash.lights, are on a body that flies '
        'before the camera, as the node constellation takes it: path, file:// or package://. '
        'Empty: each light goes its own way.',
    ),
    Parameter(
        'platform',
        STILL,
        'What the camera rides on. On a vehicle the light is far off and stands still, and imu '
        'says how the vehicle turns.',
        choices=(STILL, *MOTIONS),
    ),
    Parameter(
        'pan_tilt',
        False,
        'Whether a pan/tilt is between the two: it obeys joint_command, joints pan and tilt, and '
        'publishes joint_states. Truth is what is left to turn.',
    ),
)
INTERFACE = Interface(
    'simulator',
    'a simulated camera and lights',
    'Publishes what a camera does that sees flashing lights move before a wall, and the truth. '
    'Several have theirs on simulator/truth/NAME/...',
    PARAMETERS,
    subscribed=(JOINT_COMMAND,),
    published=(
        CAMERA_IMAGE, CAMERA_INFO, TRUE_CENTROID, TRUE_BEARING, TRUE_POSE, IMU, JOINT_STATES,
        FRAME_PICTURE, DIAGNOSTICS,
    ),
    examples=(
        'ros2 run blob_tracker simulator --ros-args -p rate:=100.0 -p amplitude:=60.0',
        'ros2 run blob_tracker simulator --ros-args -p flash.mode:=periodic '
        '-p flash.frequency:=13.7',
        'ros2 run blob_tracker simulator --ros-args -p platform:=sea -p pan_tilt:=true',
        'ros2 param set /simulator amplitude 20.0',
    ),
)

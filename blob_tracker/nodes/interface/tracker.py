"""What the tracker node shows of itself."""

from inspect import signature
from math import pi

from blob_tracker.nodes.interface.optical_frame import PITCH, ROLL, YAW
from blob_tracker.nodes.interface.tf_patience import TF_PATIENCE
from blob_tracker.nodes.interface.topics import (
    DIAGNOSTICS, IMU, JOINT_STATES, PREDICTED, RAY, TF, TF_STATIC, TRACK, TRACKED,
)
from blob_tracker.ros.interface import Interface, Parameter
from blob_tracker.tracking import MODELS, Tracker

_DEFAULTS = {each.name: each.default for each in signature(Tracker).parameters.values()}
PARAMETERS = (
    Parameter(
        'lights',
        '',
        'Names of the lights to track, as in flash.codes: port,starboard. Empty for a light '
        'without a name. The pipeline tracks them all.',
    ),
    Parameter(
        'model',
        _DEFAULTS['model'],
        'What stays constant between two bearings: the rate of the angles, or their acceleration. '
        'The latter predicts further ahead if the motion is smooth, as on waves, and is noisier '
        'if it is not.',
        choices=tuple(MODELS),
    ),
    Parameter(
        'acceleration',
        _DEFAULTS['acceleration'],
        'How much the rate changes in a second, as the camera sees it: standard deviation, for '
        'constant_velocity. Too small, and the track lags; too large, and it follows the noise; '
        'the diagnostics say which.',
        least=1e-3,
        most=1e6,
        unit='mrad/s^2',
    ),
    Parameter(
        'jerk',
        _DEFAULTS['jerk'],
        'How much the acceleration changes in a second: the same for constant_acceleration.',
        least=1e-3,
        most=1e7,
        unit='mrad/s^3',
    ),
    Parameter(
        'max_innovation',  # not gate or rate: others in the pipeline have those
        _DEFAULTS['gate_sigma'],
        'How far a bearing may be from where it is expected, in standard deviations; at 5 one '
        'right bearing in 270,000 is refused. Anything further off is another light, or the '
        'target has jumped: three that agree are followed.',
        least=1.0,
        most=100.0,
    ),
    Parameter(
        'coast',
        _DEFAULTS['coast'],
        'Time without a bearing for which the target is predicted; then silence.',
        least=0.001,
        most=60.0,
        unit='s',
    ),
    Parameter(
        'max_sigma',
        _DEFAULTS['max_sigma'],
        'Standard deviation of the prediction above which there is silence.',
        least=1e-3,
        most=1000.0,
        unit='mrad',
    ),
    Parameter(
        'stamp_offset',
        0.0,
        "How far the clock of the stamps is ahead of this computer's; it is subtracted. The "
        'diagnostics have it: 37 for TAI.',
        least=-2e9,
        most=2e9,
        unit='s',
    ),
    Parameter(
        'stamp_offset_auto',
        False,
        'Measure the offset, and again when it changes: exactly for TAI, GPS time and the time '
        'since the computer was started; otherwise from the fastest bearings, as if they had no '
        'delay.',
    ),
    Parameter(
        'servo_delay',
        0.0,
        'From publishing a prediction to the servo arriving: its transport delay, and that of its '
        'bus.',
        least=0.0,
        most=1.0,
        unit='s',
    ),
    Parameter(
        'prediction_rate',
        100.0,
        'Predictions a second, besides the one with each bearing; 0: none.',
        least=0.0,
        most=1000.0,
        unit='Hz',
    ),
    Parameter(
        'imu.enabled',
        False,
        'Take the rotation of the platform from imu, so that the target is followed and not the '
        'boat. The IMU must not turn with the pan/tilt.',
    ),
    Parameter('imu.frame_id', 'imu_link', 'Frame of the IMU: messages of any other are refused.'),
    Parameter(
        'imu.roll',
        ROLL,
        "Orientation of the camera's optical frame in that of the IMU (with the pan/tilt at 0, 0, "
        'if the camera rides on one), as for static_transform_publisher. The default is an IMU '
        'with x forward, y left, z up.',
        least=-pi,
        most=pi,
        unit='rad',
    ),
    Parameter(
        'imu.pitch', PITCH, 'The second angle of that rotation.', least=-pi, most=pi, unit='rad'
    ),
    Parameter(
        'imu.yaw', YAW, 'The third angle of that rotation.', least=-pi, most=pi, unit='rad'
    ),
    Parameter(
        'imu.use_tf',
        False,
        'Take that orientation from TF: of the frame of the rays, or of joints.frame_id if the '
        'camera rides on a pan/tilt, in the frame of each message of the IMU; imu.frame_id is '
        'then unused. If imu.roll, imu.pitch or imu.yaw is given, they count, and the diagnostics '
        'say if TF differs by more than 10 mrad.',
    ),
    Parameter(
        'imu.stamp_offset',
        0.0,
        'How late the stamps of the IMU are against those of the bearings; it is subtracted. '
        '`calibrate imu` measures it.',
        least=-1.0,
        most=1.0,
        unit='s',
    ),
    *(
        Parameter(
            f'imu.bias_{axis}',
            0.0,
            f"The gyro's {axis} at rest, to subtract. `calibrate imu` measures it.",
            least=-1.0,
            most=1.0,
            unit='rad/s',
        )
        for axis in 'xyz'
    ),
    Parameter(
        'imu.acceleration',
        _DEFAULTS['stabilised_acceleration'],
        "In place of `acceleration` while the platform's rotation is known: what the target "
        'itself does.',
        least=1e-3,
        most=1e6,
        unit='mrad/s^2',
    ),
    Parameter(
        'imu.jerk',
        _DEFAULTS['stabilised_jerk'],
        "In place of `jerk` while the platform's rotation is known.",
        least=1e-3,
        most=1e7,
        unit='mrad/s^3',
    ),
    Parameter(
        'joints.pan',
        '',
        'Joint that turns the camera to the right. Empty: none.',
    ),
    Parameter(
        'joints.tilt',
        '',
        'Joint that turns the camera up, on top of pan. Empty: none.',
    ),
    Parameter('joints.pan_reversed', False, 'Whether a growing angle turns it to the left.'),
    Parameter('joints.tilt_reversed', False, 'Whether a growing angle turns it down.'),
    Parameter(
        'joints.use_tf',
        False,
        "Take the camera's orientation from TF in place of joint_states. It is looked up in "
        'joints.frame_id, by the frame and the stamp of each ray. If joints.pan or joints.tilt is '
        'given, they count, and the diagnostics say if TF differs by more than 10 mrad.',
    ),
    Parameter(
        'joints.sigma',
        0.03,
        "Standard deviation of the joints' angles, added to that of the bearings: the encoder's "
        'step over 3.5, and how far the angles stray from a straight line between two messages. '
        'The default is for 16 bits a turn.',
        least=0.0,
        most=100.0,
        unit='mrad',
    ),
    Parameter(
        'joints.frame_id',
        'base_optical_frame',
        'Frame of the predictions with a pan/tilt: the optical frame as it stands at pan = tilt '
        '= 0. By joint_states or by TF.',
    ),
    TF_PATIENCE,
)
INTERFACE = Interface(
    'tracker',
    'where it will be',
    'Filters the bearings over time and predicts the angle at which the target will be when the '
    'servo moves.',
    PARAMETERS,
    subscribed=(RAY, IMU, JOINT_STATES, TF, TF_STATIC),
    published=(PREDICTED, TRACK, TRACKED, DIAGNOSTICS),
    each_light=(RAY, PREDICTED, TRACK, TRACKED),
    examples=(
        'ros2 run blob_tracker tracker --ros-args -p servo_delay:=0.03',
        'ros2 run blob_tracker tracker --ros-args -p joints.use_tf:=true -p servo_delay:=0.03',
        'ros2 param set /tracker acceleration 500.0',
        'ros2 topic echo /target/bearing_predicted',
    ),
)

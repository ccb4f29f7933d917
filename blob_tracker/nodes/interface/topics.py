"""The topics of all nodes, each said once: who publishes and who reads it refer to these."""

from blob_tracker.ros.interface import Topic

CAMERA_IMAGE = Topic(
    'camera/image_raw',
    'sensor_msgs/Image',
    'frames, mono8 or mono16; stamp: the middle of the exposure of the first line, in ROS time',
)
COMPRESSED_IMAGE = Topic(
    'camera/image_raw/compressed',
    'sensor_msgs/CompressedImage',
    'with `image_transport` compressed: the frames as image_transport compresses them (JPEG, PNG)',
)
CAMERA_INFO = Topic(
    'camera/camera_info',
    'sensor_msgs/CameraInfo',
    'calibration, hardware crop and binning, same stamp',
)
WINDOW_IMAGE = Topic(
    'target/window/image_raw',
    'sensor_msgs/Image',
    "8UC2 or 16UC2: the target's pixels lit and unlit, raw; 16UC2 also for sums of frames and for "
    'linear DN (response_url); 1 channel for a steady light; a third one if not all pixels see '
    'the light, or JPEG added noise; a fourth one for a light that blinks and moves '
    '(docs/segmentation.md)',
)
WINDOW_INFO = Topic(
    'target/window/camera_info',
    'sensor_msgs/CameraInfo',
    "calibration; `roi` is the window's position",
)
VISIBLE = Topic('target/visible', 'std_msgs/Bool', 'transient local, on change')
NOISE = Topic(
    'target/noise',
    'geometry_msgs/Vector3Stamped',
    'with `noise.measure`: x gain in e-/DN, y read noise and z black level in DN; transient '
    'local, used by the locator with `noise.online`',
)
BEARING = Topic(
    'target/bearing',
    'geometry_msgs/Vector3Stamped',
    'x azimuth, y elevation, **mrad**, right and up positive',
)
CENTROID = Topic(
    'target/centroid', 'geometry_msgs/PointStamped', 'x, y in px of the full sensor'
)
RAY = Topic(
    'target/ray',
    'geometry_msgs/PoseWithCovarianceStamped',
    'the bearing as a rotation, with covariance in rad^2',
)
PREDICTED = Topic(
    'target/bearing_predicted',
    'geometry_msgs/Vector3Stamped',
    'as target/bearing, for the instant in the stamp, now + `servo_delay`; with `joints.pan` and '
    '`joints.tilt` x and y are the angles to command; silent while the target is not tracked',
)
RANGE = Topic(
    'target/range',
    'sensor_msgs/Range',
    'with `range.diameter` or `range.reference_flux`: how far away the light is, m, with its '
    'variance, m^2',
)
TRACK = Topic(
    'target/track',
    'nav_msgs/Odometry',
    'with each bearing: filtered angle as target/ray has it; in `twist.angular` x the rate of the '
    'elevation and y that of the azimuth, rad/s, each with covariance; `twist.linear` z is what '
    'was subtracted from the stamps (stamp_offset), s',
)
TRACKED = Topic(
    'target/tracked',
    'std_msgs/Bool',
    'transient local, on change: whether the target is predicted',
)
# Of the cameras that the parameter `cameras` names if nobody sets it.
RAYS = tuple(
    Topic(f'{camera}/target/ray', RAY.kind, 'of each camera in `cameras`')
    for camera in ('left', 'right')
)
POINT = Topic(
    'target/point', 'geometry_msgs/PointStamped', 'position of the light in `frame_id`, m'
)
POSE = Topic(
    'target/pose',
    'geometry_msgs/PoseWithCovarianceStamped',
    'position of the light, with covariance in m^2; the orientation is unknown, as its variance '
    'says',
)
# Of the lights in config/body.yaml.
BODY_RAYS = tuple(
    Topic(f'target/{light}/ray', RAY.kind, 'of each light in the file of `body_url`')
    for light in ('port', 'starboard', 'tail', 'mast')
)
BODY_POSE = Topic(
    'target/body/pose',
    'geometry_msgs/PoseWithCovarianceStamped',
    "position, m, and orientation of a body's frame in the optical frame, with covariance, m^2 "
    'and rad^2; see `body`',
)
BODY_TWIST = Topic(
    'target/body/twist',
    'geometry_msgs/TwistWithCovarianceStamped',
    'how it moves, m/s, and turns, rad/s, in the optical frame, with covariance',
)
IMU = Topic(
    'imu', 'sensor_msgs/Imu', 'with `imu.enabled`: how the platform turns; angular velocity, rad/s'
)
JOINT_STATES = Topic(
    'joint_states',
    'sensor_msgs/JointState',
    'with `joints.pan` or `joints.tilt`: where the pan/tilt under the camera stands, rad',
)
TF = Topic(
    '/tf',
    'tf2_msgs/TFMessage',
    'how frames move relative to each other; with `imu.use_tf`, `joints.use_tf` or `use_tf`; with '
    '`publish_tf` the body in the optical frame',
)
TF_STATIC = Topic(
    '/tf_static', TF.kind, 'how frames lie in each other, fixed; with the same parameters'
)
JOINT_COMMAND = Topic(
    'joint_command',
    'sensor_msgs/JointState',
    'with `pan_tilt`: where the simulated pan/tilt is to go, rad; examples/servo_client.py',
)
_PICTURE = '~/debug_image', 'sensor_msgs/Image'
_PICTURED = 'bgr8, while somebody subscribes, at most 10 Hz: '
FRAME_PICTURE = Topic(*_PICTURE, _PICTURED + 'the frame')
SEGMENTER_PICTURE = Topic(*_PICTURE, _PICTURED + 'frame, difference, candidates and window')
WINDOW_PICTURE = Topic(*_PICTURE, _PICTURED + 'the window, the fit and what it leaves')
TRUE_CENTROID = Topic(
    'simulator/truth/centroid',
    'geometry_msgs/PointStamped',
    'where the simulated light is, in px, while it is lit, at the instant at which it is seen',
)
TRUE_BEARING = Topic(
    'simulator/truth/bearing',
    'geometry_msgs/Vector3Stamped',
    'its azimuth and elevation, mrad, while it is lit',
)
TRUE_POSE = Topic(
    'simulator/truth/pose',
    'geometry_msgs/PoseStamped',
    'with `body_url`: where the simulated body is in the optical frame, m, and how it is turned, '
    'in each frame',
)
DIAGNOSTICS = Topic(
    '/diagnostics',
    'diagnostic_msgs/DiagnosticArray',
    'at 1 Hz: what the node does, or what is wrong',
)

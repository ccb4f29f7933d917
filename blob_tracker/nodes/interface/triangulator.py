"""What the triangulator node shows of itself."""

from collections.abc import Iterable, Iterator
from math import pi

from blob_tracker.nodes.interface.optical_frame import PITCH, ROLL, YAW
from blob_tracker.nodes.interface.tf_patience import TF_PATIENCE
from blob_tracker.nodes.interface.topics import DIAGNOSTICS, POINT, POSE, RAYS, TF, TF_STATIC
from blob_tracker.ros.interface import Interface, Parameter

CAMERAS = ['left', 'right']
AXES = ('x', 'y', 'z')
ANGLES = ('roll', 'pitch', 'yaw')
SUBSCRIBED = 'the topics are subscribed to at the start'


def pose_of(camera: str) -> str:
    """Return what the names of the parameters of a camera's pose begin with."""
    return f'poses.{camera.strip("/").replace("/", ".")}'


def pose_parameters(cameras: Iterable[str]) -> Iterator[Parameter]:
    """Yield the parameters of the poses of cameras."""
    for camera in cameras:
        for axis in AXES:
            yield Parameter(
                f'{pose_of(camera)}.{axis}',
                0.0,
                f'Where the optical centre of the camera {camera} is in frame_id, along {axis}.',
                least=-1e6,
                most=1e6,
                unit='m',
            )
        for angle, default in zip(ANGLES, (ROLL, PITCH, YAW), strict=True):
            text = f'Orientation of its optical frame in frame_id: {angle} of fixed-axis angles'
            if angle == 'roll':
                text += (
                    ', as static_transform_publisher has them. The defaults are those of a camera '
                    'that looks along x of a frame whose z is up'
                )
            yield Parameter(
                f'{pose_of(camera)}.{angle}', default, f'{text}.', least=-pi, most=pi, unit='rad'
            )
        yield Parameter(
            f'{pose_of(camera)}.position_sigma',
            0.0,
            'Standard deviation of x, y and z. It is in the covariance, and does not average out.',
            least=0.0,
            most=1e6,
            unit='m',
        )
        yield Parameter(
            f'{pose_of(camera)}.rotation_sigma',
            0.0,
            'Standard deviation of the rotation about each axis of the camera. It is in the '
            'covariance too, and does not average out.',
            least=0.0,
            most=1.0,
            unit='rad',
        )


# Of the node itself; each camera that is named has those of its pose.
OWN = (
    Parameter(
        'cameras',
        CAMERAS,
        'Namespaces of the locators of the cameras, as in left/target/ray, two or more; each has '
        'its pose under poses. A position has the stamp of the first of them that sees the light: '
        'name the one with the fewest rays first.',
        fixed=SUBSCRIBED,
    ),
    Parameter(
        'light',
        '',
        'Name of the coded light that the cameras see, as in flash.codes. Empty for a light '
        'without a name.',
        fixed=SUBSCRIBED,
    ),
    Parameter(
        'frame_id', 'map', 'Frame in which the poses of the cameras, and the position, are given.'
    ),
    Parameter(
        'use_tf',
        False,
        "Take the cameras' poses from TF. Each is looked up in frame_id, by the frame and the "
        'stamp of each of its rays, and may move. If one of x ... yaw is given for it, they '
        'count, and the diagnostics say if TF has it elsewhere by more than 10 mrad or 5 cm.',
    ),
    TF_PATIENCE,
    Parameter(
        'max_interval',
        0.1,
        'Longest gap between two rays of a camera that is interpolated; over a longer one it does '
        'not see the light. A camera that falls silent is waited for as long.',
        least=1e-4,
        most=10.0,
        unit='s',
    ),
    Parameter(
        'acceleration',
        300.0,
        'How much the angular rate of the light changes in a second, standard deviation: how far '
        'it may stray from the straight line between two rays is in the covariance.',
        least=0.0,
        most=1e6,
        unit='mrad/s^2',
    ),
    Parameter(
        'gate',
        5.0,
        'How far apart rays may pass and still count as meeting. A ray further off belongs to '
        'another light, or the pose of a camera is wrong.',
        least=1.0,
        most=1000.0,
        unit='standard deviations',
    ),
    Parameter(
        'pose_covariance',
        [0.0],
        'Covariance of all poses together, as calibrate rig writes it: its lower triangle, row by '
        'row, of the rotation of each camera about its own axes, rad, and its position, m, in the '
        'order of cameras. A single 0: the sigmas of the poses alone.',
    ),
)
PARAMETERS = (*OWN, *pose_parameters(CAMERAS))
INTERFACE = Interface(
    'triangulator',
    'where it is in space, from two or more cameras',
    'Finds the position in space, with its covariance, of a light that two or more cameras see.',
    PARAMETERS,
    subscribed=(*RAYS, TF, TF_STATIC),
    published=(POINT, POSE, DIAGNOSTICS),
    examples=(
        'ros2 run blob_tracker triangulator --ros-args -p poses.left.y:=0.5 '
        '-p poses.right.y:=-0.5',
        'ros2 run blob_tracker triangulator --ros-args --params-file rig.yaml -p light:=port',
        'ros2 run blob_tracker triangulator --ros-args -p use_tf:=true -p frame_id:=base_link',
        'ros2 topic echo /target/point',
    ),
)

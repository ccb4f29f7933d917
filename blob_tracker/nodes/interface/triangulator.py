"""What the triangulator node shows of itself."""

from collections.abc import Iterator
from math import pi

from blob_tracker.nodes.interface.optical_frame import PITCH, ROLL, YAW
from blob_tracker.nodes.interface.tf_patience import TF_PATIENCE
from blob_tracker.nodes.interface.topics import (
    DIAGNOSTICS, FIRST_RAY, POINT, POSE as POSE_TOPIC, SECOND_RAY, TF, TF_STATIC,
)
from blob_tracker.ros.interface import Interface, Parameter

CAMERAS = ('first', 'second')
POSE = ('x', 'y', 'z', 'roll', 'pitch', 'yaw')  # of each
SUBSCRIBED = 'the topics are subscribed to at the start'


def _camera(name: str, namespace: str, role: str) -> Iterator[Parameter]:
    """Yield the parameters of one camera."""
    yield Parameter(
        f'{name}.namespace',
        namespace,
        f'Namespace of the locator of the {name} camera, as in {namespace}/target/ray. {role}',
        fixed=SUBSCRIBED,
    )
    for axis in 'xyz':
        yield Parameter(
            f'{name}.{axis}',
            0.0,
            f'Where the optical centre of the {name} camera is in frame_id, along {axis}.',
            least=-1e6,
            most=1e6,
            unit='m',
        )
    for angle, default in (('roll', ROLL), ('pitch', PITCH), ('yaw', YAW)):
        text = f'How its optical frame is turned in frame_id: {angle} of the fixed-axis angles'
        if angle == 'roll':
            text += (
                ', as static_transform_publisher has them. The defaults are those of a camera '
                'that looks along x of a frame whose z is up'
            )
        yield Parameter(f'{name}.{angle}', default, f'{text}.', least=-pi, most=pi, unit='rad')
    yield Parameter(
        f'{name}.position_sigma',
        0.0,
        'Standard deviation of x, y and z. It is in the covariance, and does not average out.',
        least=0.0,
        most=1e6,
        unit='m',
    )
    yield Parameter(
        f'{name}.rotation_sigma',
        0.0,
        'Standard deviation of the turn about each axis of the camera; likewise.',
        least=0.0,
        most=1.0,
        unit='rad',
    )


PARAMETERS = (
    Parameter(
        'light',
        '',
        'Name of the coded light that both cameras see, as flash.codes has it. Empty for a light '
        'without a name.',
        fixed=SUBSCRIBED,
    ),
    Parameter(
        'frame_id', 'map', 'Frame in which the poses of the cameras, and the position, are given.'
    ),
    Parameter(
        'use_tf',
        False,
        'Take from TF where the cameras are. A camera is looked up in frame_id, by the frame and '
        'the stamp of each of its rays, and may move. If one of x ... yaw is given for it, they '
        'count, and the diagnostics say if TF has it elsewhere by more than 10 mrad or 5 cm.',
    ),
    TF_PATIENCE,
    *_camera(
        'first', 'left',
        'A position is for the stamp of its ray: the first camera is the one with fewer of them.',
    ),
    *_camera('second', 'right', 'Its rays are interpolated to the stamps of the first.'),
    Parameter(
        'max_interval',
        0.1,
        'Greatest time between two rays of the second camera that are interpolated; over a longer '
        'gap there is no position.',
        least=1e-4,
        most=10.0,
        unit='s',
    ),
    Parameter(
        'acceleration',
        300.0,
        'How much the angular rate of the light changes in a second, standard deviation: what it '
        'strays from the straight line between two rays is in the covariance.',
        least=0.0,
        most=1e6,
        unit='mrad/s^2',
    ),
    Parameter(
        'gate',
        5.0,
        'How far apart rays may pass that are said to meet. What is further off is of two lights, '
        'or the poses of the cameras are wrong.',
        least=1.0,
        most=1000.0,
        unit='standard deviations',
    ),
)
INTERFACE = Interface(
    'triangulator',
    'where it is in space, of two cameras',
    'Tells where in space a light is that two cameras see, with its covariance.',
    PARAMETERS,
    subscribed=(FIRST_RAY, SECOND_RAY, TF, TF_STATIC),
    published=(POINT, POSE_TOPIC, DIAGNOSTICS),
    examples=(
        'ros2 run blob_tracker triangulator --ros-args -p first.y:=0.5 -p second.y:=-0.5',
        'ros2 run blob_tracker triangulator --ros-args --params-file cameras.yaml -p light:=port',
        'ros2 run blob_tracker triangulator --ros-args -p use_tf:=true -p frame_id:=base_link',
        'ros2 topic echo /target/point',
    ),
)

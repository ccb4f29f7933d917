"""What the constellation node shows of itself."""

from blob_tracker.nodes.interface.topics import (
    BODY_POSE, BODY_RAYS, BODY_TWIST, DIAGNOSTICS, TF,
)
from blob_tracker.ros.interface import Interface, Parameter

PARAMETERS = (
    Parameter(
        'body_url',
        'package://blob_tracker/config/body.yaml',
        'Where the lights are on the body, docs/constellation.md: path, file:// or package://. '
        'The default is an example.',
        fixed='the topics are subscribed to at the start',
    ),
    Parameter(
        'body',
        'body',
        'Name of the body in target/body/pose; two bodies have two nodes.',
        fixed='the topics are announced at the start',
    ),
    Parameter(
        'publish_tf',
        False,
        'Publish each pose on /tf as well: the frame `body` in the frame of the rays. A frame has '
        'one parent: let one camera publish it.',
    ),
    Parameter(
        'unnamed',
        '',
        'Names of lights in target/<name>/ray, comma-separated, if it is not known which light of '
        'the body each is: light_1,light_2,... of flash.lights, or codes that were mounted in any '
        'order. Their positions decide; a body that looks the same from several sides has no '
        'pose. Empty: the lights have the names of the body file.',
        fixed='the topics are subscribed to at the start',
    ),
    Parameter(
        'max_interval',
        0.1,
        'Longest time between the first and the last ray of a pose. A hidden light is waited for '
        'as long; what the body may do meanwhile is in the covariance.',
        least=1e-4,
        most=10.0,
        unit='s',
    ),
    Parameter(
        'speed_sigma',
        3.0,
        'How fast the body moves along each axis, standard deviation; within 0.3 s it may '
        'change by as much.',
        least=1e-3,
        most=1e4,
        unit='m/s',
    ),
    Parameter(
        'rate_sigma',
        3.0,
        'How fast it turns about each axis, standard deviation; within 0.3 s it may change by as '
        'much.',
        least=1e-3,
        most=1e3,
        unit='rad/s',
    ),
    Parameter(
        'max_distance',
        200.0,
        'A body further away is published with a warning: its file may be in mm.',
        least=0.1,
        most=1e6,
        unit='m',
    ),
    Parameter(
        'gate',
        5.0,
        'How badly rays may fit a pose. If it is worse, the rays are of other lights, or the body '
        'file is wrong.',
        least=1.0,
        most=1000.0,
        unit='standard deviations',
    ),
)
INTERFACE = Interface(
    'constellation',
    'the pose of a body of several lights, from one camera',
    'Finds the pose of a body whose lights one camera sees, coded or alike.',
    PARAMETERS,
    subscribed=BODY_RAYS,
    published=(BODY_POSE, BODY_TWIST, TF, DIAGNOSTICS),
    examples=(
        'ros2 run blob_tracker constellation --ros-args -p body_url:=drone.yaml',
        'ros2 topic echo /target/body/pose',
    ),
)

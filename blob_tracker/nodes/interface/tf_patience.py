"""How long a ray waits for its transforms, for each node that reads TF."""

from blob_tracker.ros.interface import Parameter

TF_PATIENCE = Parameter(
    'tf_patience',
    0.1,
    'Longest time that a ray waits for its transforms. After that it is left out, and the '
    'diagnostics say why. The default is two intervals of robot_state_publisher, which publishes '
    'at 20 Hz if its publish_frequency is not set.',
    least=0.0,
    most=2.0,
    unit='s',
)

"""Quality of service of the topics; each can be overridden by the standard parameters."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

# A driver offers reliable images, a consumer asks for best effort (REP 2003): both match, and a
# recorder may ask for more. Ten frames ride out the pause of a garbage collection at 300 Hz.
IMAGE_OUT = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
IMAGE_IN = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
RESULT = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
STATE = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


def overridable() -> QoSOverridingOptions:
    """Return the option that lets qos_overrides.<topic>... parameters change a profile."""
    return QoSOverridingOptions.with_default_policies()

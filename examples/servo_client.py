"""
Turn a pan/tilt until the target is in the middle of the picture. Copy this file and change it.

The camera rides on the pan/tilt, so a bearing is what is left to turn. With `predicted` the angles
to command come from the tracker, which has to know the joints (its joints.pan and joints.tilt).
Angles are rad, pan to the right and tilt up. The first command is near 0, 0: drive the pan/tilt
there before.
"""

from contextlib import suppress

from geometry_msgs.msg import Vector3Stamped
import numpy as np
from numpy.typing import NDArray
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

PERIOD = 0.02  # s between two steps of the way home


class ServoClient(Node):
    """target/bearing and target/visible, or predicted and target/tracked -> joint_command."""

    def __init__(self) -> None:
        super().__init__('servo_client')
        # Part of each bearing that is turned, pan and tilt; negative for a joint that turns left
        # or down. Up to 4/27 = 0.148 nothing overshoots with two frames of delay.
        self.gain = np.array(self.declare_parameter('gain', [0.14, 0.14]).value)
        self.predicted = self.declare_parameter('predicted', False).value
        self.dead_band = self.declare_parameter('dead_band', 0.2).value  # mrad: the noise's peaks
        self.speed = self.declare_parameter('speed', 1.0).value  # rad/s, at most
        self.limit = np.array(self.declare_parameter('limit', [1.5, 0.7]).value)  # rad, each way
        self.lost_after = self.declare_parameter('lost_after', 0.2).value  # s: then hold still
        self.home_after = self.declare_parameter('home_after', 3.0).value  # s: then go to 0, 0
        self.angle = np.zeros(2)  # rad: pan, tilt
        self.visible = False
        self.stamp = -np.inf  # s, of the last bearing that was followed
        self.heard = -np.inf  # s: when the last bearing came, whatever its stamp is
        # A JointState names its joints, and drivers of pan/tilt units (flir_ptu) take it.
        self.commands = self.create_publisher(JointState, 'joint_command', 10)
        held = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        known, bearing = 'target/visible', 'target/bearing'
        if self.predicted:
            known, bearing = 'target/tracked', 'target/bearing_predicted'
            self.create_subscription(Vector3Stamped, 'target/bearing', self.hear, 10)
        self.create_subscription(Bool, known, self.see, held)
        self.create_subscription(Vector3Stamped, bearing, self.follow, 10)
        self.create_timer(PERIOD, self.go_home)

    def follow(self, bearing: Vector3Stamped) -> None:
        """Turn by a part of the bearing, or to what is predicted, unless old or no number."""
        self.hear(bearing)
        stamp = bearing.header.stamp.sec + 1e-9 * bearing.header.stamp.nanosec
        angle = np.array([bearing.vector.x, bearing.vector.y])  # mrad
        age = self.now() - stamp
        if not self.predicted:  # whose stamps are of the instant to come
            age = abs(age)
        if not (self.visible and age <= self.lost_after and np.isfinite(angle).all()):
            return
        elapsed = stamp - self.stamp
        self.stamp = stamp
        if 0.0 < elapsed <= self.lost_after:  # else it is the first after a loss: no speed yet
            step = np.where(np.abs(angle) > self.dead_band, 1e-3 * self.gain * angle, 0.0)
            if self.predicted:  # the angle itself: no gain, no overshoot, no delay to wait for
                step = np.sign(self.gain) * 1e-3 * angle - self.angle
            self.turn(step, elapsed)

    def hear(self, _: Vector3Stamped) -> None:
        """Know that the target is in view, even if its bearings cannot be followed."""
        self.heard = self.now()

    def see(self, visible: Bool) -> None:
        """Hold still from the moment that the target is lost: nothing but this flag changes."""
        self.visible = visible.data

    def go_home(self) -> None:
        """Go back to 0, 0 when the target has not been seen for long; else hold still."""
        if self.now() - self.heard > self.home_after:
            self.turn(-self.angle, PERIOD)

    def turn(self, step: NDArray[np.float64], elapsed: float) -> None:
        """Command the angles that the step leads to, within speed and limit."""
        step = np.clip(step, -self.speed * elapsed, self.speed * elapsed)
        angle = np.clip(self.angle + step, -self.limit, self.limit)
        if np.isfinite(angle).all() and (angle != self.angle).any():
            self.angle = angle
            command = JointState(name=['pan', 'tilt'], position=angle.tolist())
            command.header.stamp = self.get_clock().now().to_msg()
            self.commands.publish(command)

    def now(self) -> float:
        """Return the time on the clock of the stamps, s."""
        return 1e-9 * self.get_clock().now().nanoseconds


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    try:
        rclpy.spin(ServoClient())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        with suppress(RuntimeError):  # a signal's handler may be faster
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()

"""
Turn a pan/tilt until the target is in the middle of the picture. Copy this file and change it.

The camera rides on the pan/tilt, so a bearing is what is left to turn. With `predicted` the angles
to command come from the tracker, which has to know the joints (its joints.pan and joints.tilt).
Angles are rad, pan to the right and tilt up. The first command is near 0, 0: drive the pan/tilt
there before.

    python3 examples/servo_client.py --ros-args -p gain:=[0.1,-0.1] -r joint_command:=/ptu/cmd
"""

import argparse
from contextlib import suppress
from difflib import get_close_matches
import sys
from typing import Any

from geometry_msgs.msg import Vector3Stamped
import numpy as np
from numpy.typing import NDArray
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

PERIOD = 0.02  # s between two steps of the way home
# Default and meaning of each parameter.
PARAMETERS: dict[str, tuple[Any, str]] = {
    'gain': ([0.14, 0.14], 'part of each bearing that is turned, pan and tilt; negative for a '
             'joint that turns left or down'),
    'predicted': (False, 'take the angles to command from target/bearing_predicted'),
    'dead_band': (0.2, 'mrad below which nothing is turned'),
    'speed': (1.0, 'greatest, rad/s'),
    'limit': ([1.5, 0.7], 'of pan and tilt, each way, rad'),
    'lost_after': (0.2, 's; an older bearing is not followed'),
    'home_after': (3.0, 's without a bearing after which it goes to 0, 0'),
}


class ServoClient(Node):
    """target/bearing and target/visible, or predicted and target/tracked -> joint_command."""

    def __init__(self) -> None:
        super().__init__('servo_client')
        value = {
            name: self.declare_parameter(name, default).value
            for name, (default, _) in PARAMETERS.items()
        }
        # Up to 4/27 = 0.148 nothing overshoots with two frames of delay.
        self.gain = np.array(value['gain'])
        self.predicted = value['predicted']
        self.dead_band = value['dead_band']  # mrad: the noise's peaks
        self.speed = value['speed']  # rad/s, at most
        self.limit = np.array(value['limit'])  # rad, each way
        self.lost_after = value['lost_after']  # s: then hold still
        self.home_after = value['home_after']  # s: then go to 0, 0
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


def misspelt(node: Node) -> str:
    """Say which parameter of the command line there is none of; '' if all are known."""
    for name in node._parameter_overrides:  # rclpy says nowhere else what it was given
        if not node.has_parameter(name) and not name.startswith('qos_overrides.'):
            near = get_close_matches(name, PARAMETERS, n=1) or PARAMETERS
            return f"no parameter '{name}'; there is {', '.join(near)}"
    return ''


def main() -> None:
    """Run until Ctrl-C."""
    parser = argparse.ArgumentParser(
        formatter_class=argparse.RawDescriptionHelpFormatter, description=__doc__,
        epilog='parameters:\n' + '\n'.join(
            f'  {name:10} {meaning} ({default})' for name, (default, meaning) in PARAMETERS.items()
        ),
    )
    parser.parse_args(remove_ros_args(sys.argv)[1:])
    rclpy.init()
    try:
        node = ServoClient()
        if wrong := misspelt(node):
            print(wrong, file=sys.stderr)
            sys.exit(2)
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        with suppress(RuntimeError):  # a signal's handler may be faster
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()

"""What the tracker hears of its platform: how it turns, and where the pan/tilt on it stands."""

from __future__ import annotations

from collections.abc import Callable, Collection
from threading import Lock
from typing import Any

from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.endpoints.qos import SAMPLES_IN, subscription
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.imu import to_rate, turn_of
from blob_tracker.ros.messages.joint_states import to_angle
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.tracking import (
    PanTiltAngles, PlatformRates, StampJump, TrackingError, update_or_restart,
)
from blob_tracker.units import MRAD
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import Imu, JointState

TURN = 'imu.roll', 'imu.pitch', 'imu.yaw'
JOINTS = 'joints.pan', 'joints.tilt', 'joints.pan_reversed', 'joints.tilt_reversed'
MINE = (
    'imu.enabled', 'imu.frame_id', *TURN, *JOINTS, 'joints.sigma', 'joints.frame_id',
)
SILENCE = 1_000_000_000  # ns of ROS time without angles that are worth a word


class Platform:
    """
    Take imu and joint_states, once they are asked for.

    Parameters
    ----------
    node : Node
        Subscribes.
    health : Health
        Hears of messages that cannot be used, and of joints that say nothing.
    lock : Lock
        Of all that is done with the rates and angles.
    moved : callable
        Called with the lock held when there are newer angles.

    Attributes
    ----------
    rates : PlatformRates or None
        How the platform turns; None where the IMU is not asked for.
    angles : PanTiltAngles or None
        Where the pan/tilt stands; None where there is none.
    frame_id : str
        Name of the frame that the joints do not turn; empty where it is the camera's.

    """

    def __init__(
        self, node: Node, health: Health, lock: Lock, moved: Callable[[], None]
    ) -> None:
        self.rates: PlatformRates | None = None
        self.angles: PanTiltAngles | None = None
        self.frame_id = ''
        self._node, self._health, self._lock, self._moved = node, health, lock, moved
        self._asked: dict[str, Any] = {}
        self._turn = turn_of(0.0, 0.0, 0.0)
        self._imu: Subscription | None = None
        self._joint_states: Subscription | None = None
        self._came_ns = self._now_ns()
        self._names: Collection[str] = ()

    def change(self, values: dict[str, Any]) -> Callable[[], bool]:
        """
        Build what these parameters ask for.

        Returns
        -------
        callable
            Puts it into effect, with the lock held, and tells whether there are other rates or
            angles now, of which no sample has come: what was tracked by the former means nothing.

        Raises
        ------
        ParameterError
            Where one joint is to do both.

        """
        asked = {name: values[name] for name in MINE}
        pan, tilt = asked['joints.pan'], asked['joints.tilt']
        if pan and pan == tilt:
            raise ParameterError(
                f"parameters 'joints.pan' and 'joints.tilt' are both {pan!r:.60}; they must be "
                'two joints, or one of them empty'
            )
        turn = turn_of(*(asked[name] for name in TURN))

        def use() -> bool:
            other_rates = (self.rates is not None) != asked['imu.enabled'] or (
                asked['imu.enabled'] and self._differs(asked, TURN)
            )
            other_angles = self._differs(asked, JOINTS)
            self._asked, self._turn = asked, turn
            if other_rates:
                self.rates = PlatformRates() if asked['imu.enabled'] else None
            if other_angles:
                self.angles = PanTiltAngles() if pan or tilt else None
                self._came_ns = self._now_ns()
            self.frame_id = ''
            if self.angles is not None:
                self.angles.sigma = MRAD * asked['joints.sigma']
                self.frame_id = asked['joints.frame_id']
            # They stay when they are no longer asked for, see `process.run`.
            if self.rates is not None and self._imu is None:
                self._imu = subscription(self._node, Imu, 'imu', self._take_imu, SAMPLES_IN)
            if self.angles is not None and self._joint_states is None:
                self._joint_states = subscription(
                    self._node, JointState, 'joint_states', self._take_joints, SAMPLES_IN
                )
            return other_rates or other_angles

        return use

    def awaits(self, stamp_ns: int) -> bool:
        """Tell whether the angles at a stamp, ns, are still to come."""
        if self.angles is None:
            return False
        newest_ns = self.angles.newest_ns
        return newest_ns is None or newest_ns < stamp_ns

    def reset(self) -> None:
        """Forget all samples: what follows is of another time."""
        for samples in (self.rates, self.angles):
            if samples is not None:
                samples.reset()
        self._came_ns = self._now_ns()

    def describe(self) -> None:
        """Report joints that say nothing."""
        if self.angles is None:
            return
        self._came_ns = self._came_ns or self._now_ns()  # simulated time began at 0 and leapt
        if self._health.starting or self._now_ns() - self._came_ns <= SILENCE:
            return
        names = [each for each in self._wanted() if each]
        hint = 'start the driver of the pan/tilt, or remap joint_states'
        if self._names:
            hint = f'it has {", ".join(self._names):.200}: set joints.pan and joints.tilt to those'
        self._health.fault(
            ERROR,
            f'no angle of {" and ".join(names)} arrives on joint_states, without which nothing '
            f'can be predicted; {hint}',
        )

    def _take_imu(self, message: Imu) -> None:
        """Take a sample of the gyro."""
        with self._lock:
            if self.rates is None:
                return
            try:
                rate, variance = to_rate(message, self._asked['imu.frame_id'], self._turn)
                self._push('imu', self.rates, message, rate, variance)
            except (MessageError, TrackingError) as error:
                self._health.fault(ERROR, f'imu: {error}')

    def _take_joints(self, message: JointState) -> None:
        """Take the angles of the pan/tilt."""
        with self._lock:
            if self.angles is None:
                return
            self._names = message.name or self._names
            try:
                pan, tilt = (
                    to_angle(message, name, self._asked[f'joints.{which}_reversed'])
                    for which, name in zip(('pan', 'tilt'), self._wanted())
                )
                if pan is None or tilt is None:  # of another part of the robot
                    return
                self._push('joint_states', self.angles, message, pan, tilt)
            except (MessageError, TrackingError) as error:
                self._health.fault(ERROR, f'joint_states: {error}')
                return
            self._came_ns = self._now_ns()
            self._moved()

    def _differs(self, asked: dict[str, Any], names: Collection[str]) -> bool:
        """Tell whether one of these parameters is another than before."""
        return any(asked[name] != self._asked.get(name) for name in names)

    def _push(
        self,
        topic: str,
        samples: PlatformRates | PanTiltAngles,
        message: Imu | JointState,
        *values: Any,
    ) -> None:
        """Keep a sample; restart where the stamps jumped back."""
        def restart(jump: StampJump) -> None:
            self._health.fault(WARN, f'{topic}: {jump}; starting afresh')
            samples.reset()

        stamp_ns = to_ns(message.header.stamp)
        update_or_restart(lambda: samples.push(stamp_ns, *values), restart)

    def _wanted(self) -> tuple[str, str]:
        """Return the names of the joints that pan and tilt."""
        return self._asked['joints.pan'], self._asked['joints.tilt']

    def _now_ns(self) -> int:
        return self._node.get_clock().now().nanoseconds

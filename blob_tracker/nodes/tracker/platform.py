"""What the tracker hears of its platform: how it turns, and where the pan/tilt on it stands."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from math import isnan
from threading import Lock
import time
from typing import Any

from blob_tracker.nodes.interface.tracker import PARAMETERS
from blob_tracker.nodes.tracker.camera_turns import CameraTurns
from blob_tracker.ros.diagnostics.connections import full_name
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.diagnostics.joint_news import JointNews
from blob_tracker.ros.diagnostics.stamp_clock import SampleClock
from blob_tracker.ros.endpoints.qos import SAMPLES_IN, subscription
from blob_tracker.ros.endpoints.transforms import AGREED_RAD, angle_between, Transforms
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.imu import angles_of, to_rate, turn_of
from blob_tracker.ros.messages.joint_states import to_angles
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.tracking import (
    GyroFault, GyroWatch, PanTiltAngles, PlatformGap, PlatformRates, StampJump, TrackingError,
    update_or_restart,
)
from blob_tracker.transforms import NoTransform, Transform
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD, MRAD_PER_RAD
import numpy as np
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import Imu, JointState

BIAS = 'imu.bias_x', 'imu.bias_y', 'imu.bias_z'
TURN = 'imu.roll', 'imu.pitch', 'imu.yaw'
TURNED = 1e-3  # of a trace: axes that are off by 2 degrees
NAMES = 'joints.pan', 'joints.tilt'
JOINTS = *NAMES, 'joints.pan_reversed', 'joints.tilt_reversed'
BY_TF = 'imu.use_tf', 'joints.use_tf'
MINE = (
    'imu.enabled', 'imu.frame_id', 'imu.stamp_offset', *BIAS, *TURN, *JOINTS, *BY_TF,
    'joints.sigma', 'joints.frame_id', 'tf_patience',
)
DEFAULTS = {each.name: each.default for each in PARAMETERS}
HOLD = 0.2  # s between two transforms that are interpolated, as between two angles of a joint
# ns of wall time that a bearing waits for the joints' angles at its stamp: an interval of
# joint_states at 50 Hz. By angles that are extrapolated over the half of it, a pan/tilt that
# accelerates is worse known than by the bearing; later than this, the news is worth less.
PATIENCE = 20_000_000


class Platform:
    """
    Take imu, joint_states and TF, once they are asked for.

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
        How the platform turns; None if the IMU is not asked for.
    angles : PanTiltAngles or None
        Where the pan/tilt stands by its joints; None if they are not read.
    turns : CameraTurns or None
        How the camera is turned by TF; None if TF is not asked.
    patience_ns : int
        For how long, ns of wall time, a bearing waits for what `awaits` tells of.
    frame_id : str
        Name of the frame that the pan/tilt does not turn; empty if it is the camera's.

    """

    def __init__(
        self, node: Node, health: Health, lock: Lock, moved: Callable[[], None]
    ) -> None:
        self.rates: PlatformRates | None = None
        self.angles: PanTiltAngles | None = None
        self.turns: CameraTurns | None = None
        self.patience_ns = PATIENCE
        self.frame_id = ''
        self._node, self._health, self._lock, self._moved = node, health, lock, moved
        self._asked: dict[str, Any] = {}
        self._turn = turn_of(0.0, 0.0, 0.0)
        self._mount: Transform | None = None  # of which the turn is, where TF has it
        self._imu_frame = ''  # of the last sample
        self._camera = ''  # frame of the last bearing
        self._seen_ns = 0  # its stamp, ns
        self._transforms: Transforms | None = None
        self._watch = GyroWatch()
        self._imu: Subscription | None = None
        self._joint_states: Subscription | None = None
        self._joints: dict[str, str] = {}
        self._news = JointNews({}, self._now_ns())
        self._clocks = {each: SampleClock(HOLD) for each in ('imu', 'joint_states')}

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
            If one joint is to do both, or TF is asked for and its messages are not installed.

        """
        asked = {name: values[name] for name in MINE}
        pan, tilt = asked['joints.pan'], asked['joints.tilt']
        if pan and pan == tilt:
            raise ParameterError(
                f"parameters 'joints.pan' and 'joints.tilt' are both {pan!r:.60}; they must be "
                'two joints, or one of them empty'
            )
        turn = turn_of(*(asked[name] for name in TURN))
        asking = [name for name in BY_TF if asked[name]]
        if asking and self._transforms is None:
            self._transforms = Transforms(
                self._node, self._health, self._moved, self._lock, hold=HOLD, asked_by=asking[0]
            )

        def use() -> bool:
            other_rates = (self.rates is not None) != asked['imu.enabled'] or (
                asked['imu.enabled']
                and self._differs(asked, (*TURN, *BIAS, 'imu.stamp_offset', 'imu.use_tf'))
            )
            joints = bool(pan or tilt)
            by_tf = asked['joints.use_tf'] and not joints
            other_angles = (
                self._differs(asked, JOINTS)
                or by_tf is not (self.turns is not None)
                or (by_tf and self._differs(asked, ['joints.frame_id']))
            )
            if other_rates or self._differs(asked, ['imu.use_tf']):
                self._turn, self._mount = turn, None
            self._asked = asked
            if other_rates:
                self.rates = PlatformRates() if asked['imu.enabled'] else None
                self._watch = GyroWatch()
            if other_angles:
                self.angles = PanTiltAngles() if joints else None
                self.turns = None
                if by_tf:
                    assert self._transforms is not None
                    self.turns = CameraTurns(self._transforms, asked['joints.frame_id'])
                self._joints = {name: asked[name] for name in NAMES if asked[name]}
                self._news = JointNews(self._joints, self._now_ns())
            self.frame_id = ''
            for each in (self.angles, self.turns):
                if each is not None:
                    each.sigma = MRAD * asked['joints.sigma']
                    self.frame_id = asked['joints.frame_id']
            self.patience_ns = PATIENCE if joints else round(1e9 * asked['tf_patience'])
            # They stay when they are no longer asked for, see `process.run`.
            if self.rates is not None and self._imu is None:
                self._imu = subscription(self._node, Imu, 'imu', self._take_imu, SAMPLES_IN)
            if self.angles is not None and self._joint_states is None:
                self._joint_states = subscription(
                    self._node, JointState, 'joint_states', self._take_joints, SAMPLES_IN,
                    informed=True,
                )
            return other_rates or other_angles

        return use

    @property
    def pan_tilt(self) -> PanTiltAngles | CameraTurns | None:
        """How the camera is turned against the platform; None if it is not."""
        return self.angles or self.turns

    def looks_through(self, camera: str, stamp_ns: int) -> None:
        """Be told of which camera the next bearing is, by its frame, and of its stamp, ns."""
        self._camera, self._seen_ns = camera, stamp_ns
        if self.turns is not None:
            self.turns.camera = camera

    def awaits(self, stamp_ns: int) -> bool:
        """Tell whether it is still to come how the camera is turned at a stamp, ns."""
        if self.turns is not None:
            return self.turns.awaits(stamp_ns)
        if self.angles is None:
            return False
        newest_ns = self.angles.newest_ns
        return newest_ns is None or newest_ns < stamp_ns

    def reset(self) -> None:
        """Forget all samples: what follows is of another time."""
        for samples in (self.rates, self.angles):
            if samples is not None:
                samples.reset()
        if self._transforms is not None:
            self._transforms.forget(-1)
        self._watch.reset()
        self._news.restart(self._now_ns())
        self._clocks = {each: SampleClock(HOLD) for each in self._clocks}

    def saw(self, light: str, bearing: Bearing) -> None:
        """Take a bearing, of which the gyro ought to know how the platform turned."""
        if self.rates is not None:
            self._watch.saw(light, bearing, self.pan_tilt)

    def describe(self) -> None:
        """Report a gyro that says other than the picture, and joints that are not as they must."""
        self._judge_gyro()
        self._describe_joints()
        self._compare_with_tf()

    def _judge_gyro(self) -> None:
        """Do without a gyro that says other than the picture, and say what is wrong with it."""
        if self.rates is None:
            return
        self._watch.judge()
        fault = self._watch.fault
        self.rates.distrusted = fault.words if fault is not None else ''
        if fault is not None:
            self._health.fault(
                WARN,
                f'imu: by what the lights do in the picture, {fault.words}; it is not used: '
                f'{self._remedy(fault)}',
            )

    def _remedy(self, fault: GyroFault) -> str:
        """Return what to do about a gyro."""
        if fault.turn is None:
            return (
                'is it the IMU of this platform, and are its stamps of the clock of the images?'
            )
        remedies = []
        if fault.scale != 1.0 or np.linalg.det(fault.turn) < 0.0:
            remedies.append('have its driver publish rad/s about right-handed axes, as ROS has it')
        elif np.trace(fault.turn) < 3.0 - TURNED:
            angles = angles_of(self._turn @ fault.turn.T)
            values = ', '.join(
                f'{name} to {angle:.3f}' for name, angle in zip(TURN, angles, strict=True)
            )
            remedies.append(f'set {values}')
        if fault.offset:
            late = self._asked['imu.stamp_offset'] + fault.offset
            remedies.append(f'set imu.stamp_offset to {late:.3f}')
        return f'{", and ".join(remedies)}, or take what `calibrate imu` measures'

    def _describe_joints(self) -> None:
        """Report joints that say nothing, and those of which several nodes speak."""
        if self.angles is None:
            return
        silent = self._news.silent(self._now_ns())
        if silent and not self._health.starting:
            self._health.fault(ERROR, silent)
        assert self._joint_states is not None
        topic = self._joint_states.topic_name
        for name in self._news.mixed:
            publishers = self._node.get_publishers_info_by_topic(topic)
            names = ', '.join(sorted({full_name(each) for each in publishers}))
            self._health.fault(
                WARN,
                f"several nodes publish the joint '{name}' on {topic}, and the camera is taken to "
                f'leap between them: of {names} let one do so',
            )

    def _compare_with_tf(self) -> None:
        """Say where TF has another turn than the parameters or the joints, which are used."""
        transforms = self._transforms
        if transforms is None:
            return
        try:
            if self._asked['imu.use_tf'] and self._is_mount_given and self._imu_frame:
                mount = transforms.fixed(self._base, self._imu_frame)
                self._tell_apart(
                    angle_between(mount.matrix, self._turn),
                    f"{', '.join(TURN)} have '{self._base}' in '{self._imu_frame}'",
                    'leave them at their defaults',
                )
            if self._asked['joints.use_tf'] and self.angles is not None:
                turn = transforms.lookup(self._camera, self._base, self._seen_ns).transform
                self._tell_apart(
                    angle_between(turn.matrix, self.angles.at(self._seen_ns)),
                    f"joint_states has '{self._camera}' in '{self._base}'",
                    'leave joints.pan and joints.tilt empty',
                )
        except (NoTransform, PlatformGap):
            return  # what is used is there

    def _tell_apart(self, angle: float, what: str, remedy: str) -> None:
        """Say that TF has another turn, if it has, and what to do to have it used."""
        if angle > AGREED_RAD:
            self._health.fault(
                WARN,
                f'{what} {MRAD_PER_RAD * angle:.1f} mrad from where TF has it, and is used: '
                f'correct one of the two, or {remedy}, and TF is used',
            )

    @property
    def _is_mount_given(self) -> bool:
        """Tell whether parameters say how the IMU is turned."""
        return any(self._asked[name] != DEFAULTS[name] for name in TURN)

    @property
    def _base(self) -> str:
        """Return the frame of the bearings, or that which the pan/tilt does not turn."""
        return self.frame_id or self._camera

    def _find_mount(self, imu: str) -> None:
        """Take the turn of the IMU from TF; what it said by another one means nothing."""
        assert self._transforms is not None and self.rates is not None
        mount = self._transforms.fixed(self._base, imu)
        if mount != self._mount:
            if self._mount is not None:
                self.rates.reset()
                self._watch.reset()
            self._mount, self._turn = mount, mount.matrix

    def _take_imu(self, message: Imu) -> None:
        """Take a sample of the gyro."""
        with self._lock:
            if self.rates is None:
                return
            own = self._imu_frame = message.header.frame_id
            try:
                if self._asked['imu.use_tf'] and not self._is_mount_given:
                    if not self._base:  # no ray has told yet what the camera's frame is
                        return
                    self._find_mount(own)
                else:
                    own = self._asked['imu.frame_id']
                rate, variance = to_rate(
                    message, own, self._turn, [self._asked[name] for name in BIAS]
                )
                self._watch.push(self._push('imu', self.rates, message, rate, variance), rate)
            except NoTransform as gap:
                assert self._transforms is not None
                self._health.fault(
                    WARN, f'imu is not used: {self._transforms.explain(gap)}'
                )
            except (MessageError, TrackingError) as error:
                self._health.fault(ERROR, f'imu: {error}')

    def _take_joints(self, message: JointState, information: Mapping[str, int | None]) -> None:
        """Take the angles of the pan/tilt that are in a message, of one joint or of both."""
        with self._lock:
            if self.angles is None:
                return
            self._news.heard(message.name)
            try:
                angles = to_angles(message, self._joints.values())
                pan, tilt = (self._angle_of(name, angles) for name in NAMES)
                if angles:
                    self._push('joint_states', self.angles, message, pan, tilt)
            except (MessageError, TrackingError) as error:
                self._health.fault(ERROR, f'joint_states: {error}')
                return
            number, sent_ns = (
                information[each] for each in ('publication_sequence_number', 'source_timestamp')
            )
            if number is not None and sent_ns is not None:  # not every middleware numbers them
                self._news.numbered(angles, number, sent_ns)
            self._news.took(angles, self._now_ns())
            self._moved()

    def _angle_of(self, name: str, angles: Mapping[str, float]) -> float | None:
        """Return the angle of pan or tilt, rad; 0 of one that there is not, None without news."""
        if name not in self._joints:
            return 0.0
        angle = angles.get(self._joints[name])
        if angle is None or isnan(angle):  # a driver does not know it until it has homed
            return None
        return -angle if self._asked[f'{name}_reversed'] else angle

    def _differs(self, asked: dict[str, Any], names: Collection[str]) -> bool:
        """Tell whether one of these parameters is another than before."""
        return any(asked[name] != self._asked.get(name) for name in names)

    def _push(
        self,
        topic: str,
        samples: PlatformRates | PanTiltAngles,
        message: Imu | JointState,
        *values: Any,
    ) -> int:
        """Keep a sample, and return its stamp, ns; restart where the stamps jumped back."""
        def restart(jump: StampJump) -> None:
            self._health.fault(WARN, f'{topic}: {jump}; starting again')
            samples.reset()
            self._watch.reset()

        stamp_ns = to_ns(message.header.stamp)
        if not stamp_ns:  # its driver sets none: the next best is when it came
            self._health.count(f'{topic} without a stamp')
            stamp_ns = self._now_ns()
        elif samples is self.rates:
            stamp_ns -= round(1e9 * self._asked['imu.stamp_offset'])
        self._clocks[topic].took(stamp_ns, time.time_ns())
        update_or_restart(lambda: samples.push(stamp_ns, *values), restart)
        return stamp_ns

    def began_after(self, stamp_ns: int) -> bool:
        """Tell whether a stamp, ns, is from before the joints, as that of the first bearings."""
        newest_ns = None if self.angles is None else self.angles.newest_ns
        return self._health.starting and newest_ns is not None and stamp_ns < newest_ns

    @property
    def joints_beyond_a_turn(self) -> str:
        """Say which joints are likely to be in degrees; '' where none is."""
        return self._news.beyond_a_turn

    def clock_of(self, topic: str) -> str:
        """Say by which clock the stamps of imu or joint_states are; '' where by the right one."""
        if self._node.get_clock().ros_time_is_active:  # which is that of the stamps
            return ''
        fault = self._clocks[topic].fault
        return f'{topic}: {fault}' if fault else ''

    def _now_ns(self) -> int:
        return self._node.get_clock().now().nanoseconds

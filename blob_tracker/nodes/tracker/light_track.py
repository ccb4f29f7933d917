"""One light: its tracker, what is published of it, and how well its bearings fit."""

from __future__ import annotations

from collections import deque
import time
from typing import NamedTuple

from blob_tracker.nodes.tracker.platform import Platform
from blob_tracker.nodes.tracker.track_topics import TrackTopics
from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.ros.endpoints.names import target_topic
from blob_tracker.tracking import (
    MODELS, PlatformGap, StampJump, Track, Tracker, TrackingError, update_or_restart,
)
from blob_tracker.types import Bearing
import numpy as np
from rclpy.node import Node

JUDGED = 100  # bearings: their mean normalised innovation squared is known to 0.2
FEWEST = 30  # of them that are worth a word
# Where that should be 2, the degrees of freedom: five standard errors above it, with the fewest.
SUSPICIOUS = 4.0
MOST = 50.0  # that one bearing counts in it: a target that leaps says nothing of the filter
MISSED = 2.5  # usual times between two bearings, after which one is missing
MOST_HELD = 100  # bearings that wait: 5 kHz


class Held(NamedTuple):
    """A bearing that waits, and when it came, ns of a monotonic clock."""

    delivery: Delivery[Bearing]
    came_ns: int


class LightTrack:
    """
    Follow one light and publish where it will be.

    Parameters
    ----------
    node : Node
        Publishes it.
    health : Health
        Hears of each bearing, tracked or refused.
    light : str
        Name of the light; empty for the only one.
    platform : Platform
        Knows how the camera is turned.

    Attributes
    ----------
    stamp_offset : float
        What is taken off the stamps of the bearings, s.

    """

    def __init__(self, node: Node, health: Health, light: str, platform: Platform) -> None:
        self.stamp_offset = 0.0
        self._node, self._health, self._platform = node, health, platform
        self._topic = target_topic(light)
        self._topics = TrackTopics(node, self._topic)
        self._name = f'{light}: ' if light else ''
        self._frame_id = ''
        self._tracker: Tracker
        self._held: deque[Held] = deque()
        self._innovations: deque[float] = deque(maxlen=JUDGED)
        self._interval_ns = self._taken_ns = 0
        self._resets = self._early = 0
        self._prediction: Track | None = None

    def use(self, tracker: Tracker) -> None:
        """Restart with another tracker; bearings that wait are for this one."""
        self._tracker = tracker
        self._innovations.clear()

    def limit(self, limits: dict[str, float]) -> None:
        """Go on with other limits, by the name that `Tracker.set_limits` has for each."""
        self._tracker.set_limits(**limits)

    def reset(self) -> None:
        """Forget where the light was: what follows is of another time."""
        self._tracker.reset()
        self._resets += 1

    def forget(self, after_ns: int) -> None:
        """Forget where the light was if that has a later stamp, ns, and what waits with one."""
        self._held = deque(each for each in self._held if each.delivery.item.stamp_ns <= after_ns)
        newest_ns = self._tracker.stamp_ns
        if newest_ns is not None and newest_ns > after_ns:
            self.reset()

    def take(self, delivery: Delivery[Bearing], ahead_ns: int) -> None:
        """Take a bearing, once it need not wait: see `release`."""
        self._held.append(Held(delivery, time.monotonic_ns()))
        self.release(ahead_ns)

    def release(self, ahead_ns: int) -> None:
        """
        Filter the bearings that need not wait any longer, in the order in which they came.

        A bearing waits until it is known how the camera is turned at its stamp, for so long as
        the platform's patience lasts; then it is used with the angles that the former ones of the
        joints lead to, and their variance, or, where TF tells them, refused. Who is at the head of
        the line decides for those behind. With each that became part of the track it is published
        where the light will be in so many ns.
        """
        while self._held:
            delivery, came_ns = self._held[0]
            self._platform.looks_through(delivery.frame_id, delivery.item.stamp_ns)
            early = self._platform.awaits(delivery.item.stamp_ns)
            waited_ns = time.monotonic_ns() - came_ns
            if early and waited_ns < self._platform.patience_ns and len(self._held) <= MOST_HELD:
                return
            self._held.popleft()
            self._early += early
            self._filter(delivery.item, delivery.frame_id, ahead_ns)

    def _filter(self, bearing: Bearing, frame_id: str, ahead_ns: int) -> None:
        """Filter a bearing; publish track and prediction, or tell `health` why it is refused."""
        self._platform.saw(self._topic, bearing)
        before_ns, refused = self._tracker.stamp_ns, self._tracker.refused
        try:
            update_or_restart(lambda: self._tracker.update(bearing), self._restart)
        except TrackingError as error:
            why = str(error)
            gap = isinstance(error.__cause__, PlatformGap)
            if gap and self._platform.angles is not None:
                why = '; '.join(filter(None, [why, self._platform.clock_of('joint_states')]))
            if not (gap and self._platform.began_after(bearing.stamp_ns)):
                self._health.fault(WARN, f'{self._topic}/ray: {why}')
            self._health.count(f'{self._name}bearings refused')
            if self._tracker.refused > refused:
                self._remember_innovation()
            return
        self._remember_innovation()
        newest_ns = self._tracker.stamp_ns
        assert newest_ns is not None
        if before_ns is not None and newest_ns > before_ns:
            self._interval_ns = newest_ns - before_ns
        self._taken_ns = self._now_ns()
        self._frame_id = frame_id
        track = self._tracker.seen_at(newest_ns)
        if track is not None:
            self._topics.publish(track, frame_id, self.stamp_offset)
        self.predict(ahead_ns)
        self._health.left(bearing.stamp_ns)
        tracked = self._prediction is not None
        self._health.ok('target tracked' if tracked else f'no prediction: {self._tracker.reason}')

    def predict(self, ahead_ns: int) -> None:
        """Publish where the light will be in so many ns, or that this is not known."""
        self._prediction = self._tracker.at(self._now_ns() + ahead_ns)
        if self._prediction is None:
            self._topics.lose()
        else:
            self._topics.predict(self._prediction, self._platform.frame_id or self._frame_id)

    def seen_at(self, stamp_ns: int) -> Track | None:
        """Return where the camera sees the light at a stamp, ns; None if this is not known."""
        return self._tracker.seen_at(stamp_ns)

    def check(self, ahead_ns: int) -> None:
        """Say that the light is not tracked where it could not be predicted."""
        if self._tracker.at(self._now_ns() + ahead_ns) is None:
            self.lose()

    def lose(self) -> None:
        """Say that the light is not tracked."""
        self._prediction = None
        self._topics.lose()

    def stop(self) -> None:
        """Speak of the light no more."""
        self._held.clear()
        self.lose()

    def describe(self) -> None:
        """Show how the light is tracked, and report what does not fit."""
        tracker = self._tracker
        state = f'lost: {tracker.reason or "ROS time stands still"}'
        sigma = 'unknown: nothing is predicted'
        if self._prediction is not None:
            waited = self._now_ns() - self._taken_ns
            state = 'coasting' if waited > MISSED * self._interval_ns else 'tracking'
            sigma = f'{self._prediction.sigma:.4f}'
        newest_ns = tracker.stamp_ns
        age = 'unknown: none has come'
        if newest_ns is not None:
            age = f'{1e-9 * (self._now_ns() - newest_ns):.3f}'
        for key, value in (
            ('state', state),
            ('predicted sigma (mrad)', sigma),
            ('last bearing (s)', age),
            ('bearings', tracker.bearings),
            ('late', tracker.late),
            ('outside the gate', tracker.refused),
            ('tracks begun', tracker.begun),
            ('resets', self._resets),
        ):
            self._health.show(self._name + key, value)
        if tracker.platform is not None:
            stabilised = f'no: {tracker.platform_gap}' if tracker.platform_gap else 'yes'
            self._health.show(f'{self._name}stabilised', stabilised)
            if tracker.platform_gap and not tracker.platform.distrusted:
                clock = self._platform.clock_of('imu')
                self._health.fault(
                    WARN,
                    f'{self._name}tracked without the rotation of the platform, as if there were '
                    f'no IMU: {tracker.platform_gap}; '
                    + (clock or 'is imu published, with stamps of the clock of the images?'),
                )
        if tracker.pan_tilt is not None:
            ahead = 'ahead of the joints' if self._platform.angles else 'ahead of TF'
            self._health.show(f'{self._name}{ahead}', self._early)
        self._judge_innovations()

    def _judge_innovations(self) -> None:
        """Show how large the innovations are, and say what to change where they are too large."""
        count = len(self._innovations)
        if count < FEWEST:
            return
        mean = float(np.mean(self._innovations))
        self._health.show(f'{self._name}innovation squared', f'{mean:.2f}')
        if mean <= SUSPICIOUS:
            return
        parameter = MODELS[self._tracker.model].noise
        if self._tracker.platform is not None and not self._tracker.platform_gap:
            parameter = f'imu.{parameter}'
        joints = ''
        if self._tracker.pan_tilt is not None:
            source = 'joint_states' if self._platform.angles else 'TF'
            joints = (
                f'the joints are elsewhere than {source} says, see to it that their stamps are '
                'the instants at which they were read, by the clock of the images, and raise '
                'joints.sigma to their error; '
            )
            if far := self._platform.joints_beyond_a_turn:
                joints = f'{far} joint_states has rad; {joints}'
        self._health.fault(
            WARN,
            f'{self._name}the mean normalised innovation squared is {mean:.1f} where 2 is right: '
            f'the target moves more than is expected of it, raise {parameter}; {joints}or the '
            'bearings scatter more than their covariance says, then scatter / sigma of the '
            'locator is above 1 as well',
        )

    def _restart(self, jump: StampJump) -> None:
        """Forget where the light was, and say that its stamps jumped back."""
        self._health.fault(WARN, f'{self._topic}/ray: {jump}; starting again')
        self.reset()

    def _remember_innovation(self) -> None:
        """Keep the innovation of the last bearing; the first one of a track has none."""
        innovation = self._tracker.innovation
        if innovation is not None:
            self._innovations.append(min(MOST, innovation.squared))  # the former where it is NaN

    def _now_ns(self) -> int:
        return self._node.get_clock().now().nanoseconds

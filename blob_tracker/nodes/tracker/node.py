"""target/ray -> target/bearing_predicted, target/track and target/tracked."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial
import sys
from threading import Lock
import time
from typing import Any

from blob_tracker.nodes.interface.tracker import PARAMETERS
from blob_tracker.nodes.tracker.light_track import LightTrack
from blob_tracker.nodes.tracker.platform import Platform
from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.diagnostics.stamp_clock import StampClock
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.ros.endpoints.names import lights_from_text, target_topic
from blob_tracker.ros.endpoints.qos import RESULT, subscription
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.process import run
from blob_tracker.tracking import compile_ahead, Track, Tracker
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.subscription import Subscription

CHECK = 0.05  # s of wall time between two looks at whether the lights are still tracked
STANDSTILL = 1.0  # s of wall time in which ROS time did not go on: it says nothing of the lights
LOOK = 0.005  # s of wall time between two looks at whether a bearing has waited long enough
# What makes another filter of them, by the name that `Tracker` has for it; all else leaves a light
# that is followed as it is.
FILTER = {
    'model': 'model',
    'acceleration': 'acceleration',
    'jerk': 'jerk',
    'imu.acceleration': 'stabilised_acceleration',
    'imu.jerk': 'stabilised_jerk',
}
STAMP_CLOCK = 'stamp_offset', 'stamp_offset_auto'
LIMITS = {'max_innovation': 'gate_sigma', 'coast': 'coast', 'max_sigma': 'max_sigma'}
# A rate of 0 is a timer that is cancelled, of any period.
SLOWEST = 1.0  # Hz


class TrackerNode(Node):
    """
    See the module's first line; the work is `blob_tracker.tracking.Tracker`'s.

    Parameters
    ----------
    listen : bool
        Whether bearings come from target/ray; else whoever has them calls `track`.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    """

    def __init__(self, *, listen: bool = True, elsewhere: Collection[str] = ()) -> None:
        super().__init__('tracker')
        values = declare(self, PARAMETERS, elsewhere)
        self._listen = listen
        self._lock = Lock()  # bearings may come from a thread of the camera's
        self._health = Health(
            self, 'no bearing arrives; is the locator running, and the target in view?'
        )
        self._connections = Connections(self, self._health)
        self._platform = Platform(self, self._health, self._lock, self._release)
        self._topics: dict[str, LightTrack] = {}  # of all lights that there ever were
        self._lights: dict[str, LightTrack] = {}
        self._rays: dict[str, Subscription] = {}
        self._filter: dict[str, Any] = {}
        self._new_tracker: Callable[[], Tracker]
        self._asked_of_stamps: tuple[Any, ...] = ()
        self._stamp_clock: StampClock
        self._judged = True  # whether it is said what is wrong with the stamps that came
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        # Of the ROS clock: where time is simulated and pauses, no prediction is due.
        self._timer = self.create_timer(1.0 / SLOWEST, self._predict)
        # Not begun with each bearing that waits: a thread of the camera's would have to.
        self._looks = self.create_timer(LOOK, self._look, clock=self._steady)
        self._time = self._steady.now(), self.get_clock().now()
        self._change(values)()
        on_change(self, PARAMETERS, self._change)
        self._health.watch(self._describe)
        self._clock_jumps = on_clock_jump(self, self._health, self._forget)
        self.create_timer(CHECK, self._check, clock=self._steady)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build what these parameters ask for; return what puts it into effect."""
        lights = lights_from_text(values['lights'])
        if self._listen:
            self._make_topics(lights)
        change_platform = self._platform.change(values)
        asked = {theirs: values[ours] for ours, theirs in FILTER.items()}
        limits = {theirs: values[ours] for ours, theirs in LIMITS.items()}

        def use() -> None:
            with self._lock:
                restart = change_platform() or asked != self._filter
                self._filter = asked
                self._new_tracker = partial(
                    Tracker,
                    **asked,
                    **limits,
                    platform=self._platform.rates,
                    pan_tilt=self._platform.pan_tilt,
                )
                for light in self._lights.values():
                    if restart:
                        light.use(self._new_tracker())
                    else:
                        light.limit(limits)
                if self._listen:
                    self._follow(lights)
                self._ahead_ns = int(1e9 * values['servo_delay'])
                self._use_stamp_clock(values)
                self._set_rate(values['prediction_rate'])
                if self._platform.angles is None:
                    self._looks.cancel()
                else:
                    self._looks.reset()
                self._release()  # if there are no joints any more, nothing waits for them

        return use

    def _use_stamp_clock(self, values: dict[str, Any]) -> None:
        """Have the offset of the stamps that is asked for; one that was measured stays."""
        offset, auto = asked = tuple(values[name] for name in STAMP_CLOCK)
        latest = max(values['coast'] - values['servo_delay'], 0.0)
        if asked != self._asked_of_stamps:
            self._stamp_clock = StampClock(offset, auto=auto, latest=latest)
            self._asked_of_stamps = asked
        self._stamp_clock.latest = latest

    def _set_rate(self, rate: float) -> None:
        """Predict so often by the timer."""
        if rate == 0.0:
            self._timer.cancel()
        else:
            self._timer.timer_period_ns = round(1e9 / rate)
            self._timer.reset()

    def set_lights(self, lights: Collection[str]) -> None:
        """Be told in this process which lights will be handed over."""
        self._make_topics(lights)
        with self._lock:
            self._follow(lights)

    def _make_topics(self, lights: Collection[str]) -> None:
        """Have the topics of these lights; those of others stay, see `process.run`."""
        for name in lights:
            if name not in self._topics:
                self._topics[name] = LightTrack(self, self._health, name, self._platform)
            if self._listen and name not in self._rays:
                self._rays[name] = subscription(
                    self, PoseWithCovarianceStamped, f'{target_topic(name)}/ray',
                    partial(self._take, name), RESULT,
                )

    def _follow(self, lights: Collection[str]) -> None:
        """Track these lights and speak of no other."""
        for name, light in self._lights.items():
            if name not in lights:
                light.stop()
        for name in lights:
            if name not in self._lights:
                self._topics[name].use(self._new_tracker())
        self._lights = {name: self._topics[name] for name in lights}

    def _take(self, light: str, message: PoseWithCovarianceStamped) -> None:
        """Take a ray from the topics."""
        try:
            bearing = to_bearing(message)
        except MessageError as error:
            self._health.fault(ERROR, f'{target_topic(light)}/ray: {error}')
            return
        self.track(Delivery(bearing, message.header.frame_id, light))

    def track(self, delivery: Delivery[Bearing]) -> None:
        """
        Take the next bearing of a light; publish its track and where it will be.

        With a pan/tilt, once it is known how that stood at its stamp, see `LightTrack.release`.
        """
        came_ns = time.monotonic_ns()
        with self._lock:
            stamp_ns = self._by_this_clock(delivery.item.stamp_ns)
            if stamp_ns != delivery.item.stamp_ns:
                delivery = replace(delivery, item=replace(delivery.item, stamp_ns=stamp_ns))
            self._judged = False
            if delivery.light in self._lights:
                light = self._lights[delivery.light]
                light.stamp_offset = self._offset
                light.take(delivery, self._ahead_ns)
        self._health.arrived(stamp_ns, came_ns)

    @property
    def _offset(self) -> float:
        """Return what is taken off the stamps, s; simulated time is that of the stamps."""
        return 0.0 if self.get_clock().ros_time_is_active else self._stamp_clock.taken

    def _by_this_clock(self, stamp_ns: int) -> int:
        """Return a stamp without the offset of its clock."""
        if self.get_clock().ros_time_is_active:
            return stamp_ns
        return self._stamp_clock.corrected(stamp_ns, time.time_ns())

    def _release(self) -> None:
        """Filter the bearings that need not wait any longer; the lock is held."""
        for light in self._lights.values():
            light.release(self._ahead_ns)

    def _look(self) -> None:
        """Filter the bearings that have waited long enough."""
        with self._lock:
            self._release()

    def seen_at(self, light: str, stamp_ns: int) -> Track | None:
        """Return where the camera sees a light at a stamp, ns; None if this is not known."""
        with self._lock:
            here_ns = stamp_ns - round(1e9 * self._offset)
            return self._lights[light].seen_at(here_ns) if light in self._lights else None

    def _predict(self) -> None:
        """Publish where the lights will be."""
        with self._lock:
            for light in self._lights.values():
                light.predict(self._ahead_ns)

    def _check(self) -> None:
        """Say which lights are no longer tracked."""
        steady, now = self._steady.now(), self.get_clock().now()
        if now < self._time[1]:
            # A step of the system's clock is told to nobody. Of bearings and samples nobody knows
            # on which side of it they were stamped, and the timer would wait until then.
            back = 1e-9 * (self._time[1] - now).nanoseconds
            self._health.fault(
                WARN, f'the clock was set back by some {back:.3f} s; starting again'
            )
            self._forget(-1)
            if not self._timer.is_canceled():
                self._timer.reset()
        if now != self._time[1]:
            self._time = steady, now
        stands_still = (steady - self._time[0]).nanoseconds > 1e9 * STANDSTILL
        with self._lock:
            self._release()
            for light in self._lights.values():
                if stands_still:
                    light.lose()
                else:
                    light.check(self._ahead_ns)

    def _forget(self, after_ns: int) -> None:
        """Forget what has a later stamp, ns."""
        self._time = self._steady.now(), self.get_clock().now()  # `_check` need not see it as well
        with self._lock:
            self._platform.reset()
            for light in self._lights.values():
                light.forget(after_ns)

    def _describe(self) -> None:
        """Show in the diagnostics how the lights are tracked."""
        with self._lock:
            self._health.show('stamp offset (s)', f'{self._stamp_clock.taken:.3f}')
            if not self._judged and self._stamp_clock.fault:
                self._health.fault(WARN, self._stamp_clock.fault)
            self._judged = True
            self._platform.describe()
            for light in self._lights.values():
                light.describe()


def compile_filter() -> None:
    """Compile the filter, before the first bearing could wait for it."""
    compile_ahead()


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [TrackerNode()], compile_filter))

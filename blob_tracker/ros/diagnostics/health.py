"""What a node says of itself: /diagnostics at 1 Hz and a log that does not repeat itself."""

from __future__ import annotations

from collections.abc import Callable
import math
import os
import re
from threading import Lock
import time

from blob_tracker.ros.diagnostics.load import Load
from blob_tracker.ros.diagnostics.stamp_clock import name_clock
from blob_tracker.ros.diagnostics.timing import Figures, plausible, Timing, UsualRate
from blob_tracker.ros.endpoints.qos import publisher, RESULT
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.logging import get_logging_directory
from rclpy.node import Node

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR
PERIOD_S = 1.0  # s
PATIENCE = 3  # periods of silence at the start: the others are starting as well
MOST_AT_ONCE = 4  # messages in a second: whatever a node is fed, this stays readable
MOST_LOGGED = 20  # kinds of them in the log within REPEAT_S
REPEAT_S = 5.0  # s: the same sentence is logged again after this long, while it holds


class Tally:
    """
    What is counted with each frame; shown in the diagnostics once there is any.

    Attributes
    ----------
    count : int
        To be raised by one thread at a time.

    """

    def __init__(self) -> None:
        self.count = 0


class Health:
    """
    Collect what goes well and ill, and publish the worst of each second: all that is as bad.

    With it go the rate of what arrives, its age, the latency of the results and the load of the
    process.

    Parameters
    ----------
    node : Node
        Whose health it is.
    idle : str
        What to say of a second in which nothing was reported.
    slowed : str
        What may be the cause where the rate falls by half; empty if it may well do so.
    describe : callable, optional
        Called before each publication for a second in which something was reported, to show and
        report what is known once a second.

    Attributes
    ----------
    rate : float
        Of the last second, Hz.

    """

    def __init__(
        self,
        node: Node,
        idle: str,
        slowed: str = '',
        describe: Callable[[], None] = lambda: None,
    ) -> None:
        self.rate = 0.0
        self._values: dict[str, object] = {}
        self._tallies: dict[str, Tally] = {}
        self._node = node
        self._idle = idle
        self._slowed = slowed
        self._describe = describe
        self._reasons: list[Callable[[], str]] = []
        self._checks: list[Callable[[], None]] = [self._check_log]
        self._timing = Timing()
        self._usual_rate = UsualRate()
        self._load = Load()
        self._level = OK
        self._messages: dict[str, str] = {}  # of that level, by kind
        self._logged: dict[str, float] = {}
        self._lock = Lock()  # a capture thread reports while the executor publishes
        self._ros_clock = node.get_clock()
        self._simulated = self._ros_clock.ros_time_is_active
        self._seconds = 0  # that were published
        # Wall time that never jumps: with use_sim_time a paused bag must not silence a node.
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._publisher = publisher(node, DiagnosticArray, '/diagnostics', RESULT)
        self._timer = node.create_timer(PERIOD_S, self._publish, clock=self._clock)

    def watch(self, check: Callable[[], None]) -> None:
        """Have a check report what it finds at the end of each second: what lasts is in each."""
        self._checks.append(check)

    def explain_silence(self, reason: Callable[[], str]) -> None:
        """Have a better word than `idle` where there is one, in a second without a report."""
        self._reasons.append(reason)

    @property
    def starting(self) -> bool:
        """Whether it is too early to miss anything: the others may be starting as well."""
        return self._seconds < PATIENCE

    def arrived(self, stamp_ns: int, came_ns: int | None = None) -> None:
        """
        Take note of a frame or window that came in, by its stamp in ns.

        So that this need not keep what came waiting, it may be told later that it came at a
        monotonic time, ns.
        """
        now_ns = time.monotonic_ns()
        age = self._ros_time_ns() - stamp_ns
        came_ns = now_ns if came_ns is None else came_ns
        with self._lock:
            self._timing.arrived(came_ns, age - (now_ns - came_ns))

    def left(self, stamp_ns: int) -> None:
        """Take note of a result that was published, by its stamp in ns."""
        age = self._ros_time_ns() - stamp_ns
        with self._lock:
            self._timing.left(time.monotonic_ns(), age)

    def _ros_time_ns(self) -> int:
        """Return the node's time, ns: that of the system unless it is simulated."""
        # The objects that rclpy makes of it take longer than all else that is noted of a frame.
        return self._ros_clock.now().nanoseconds if self._simulated else time.time_ns()

    def ok(self, message: str) -> None:
        """Report that something went well; the last such word of a second is published."""
        if self._messages.get('') == message:
            return  # as it most often was by the frame before
        with self._lock:
            if self._level == OK:
                self._messages = {'': message}

    def fault(self, level: bytes, message: str) -> None:
        """
        Report a fault: it is logged once, and again every 5 s while it lasts.

        Parameters
        ----------
        level : bytes
            WARN or ERROR of this module.
        message : str
            What is wrong and what would be right.

        """
        now = time.monotonic()
        # The same sentence with other numbers is the same fault.
        kind = re.sub(r'[0-9.]+', '#', message)
        with self._lock:
            if level > self._level:
                self._level, self._messages = level, {}
            if level == self._level:
                if kind in self._messages or len(self._messages) < MOST_AT_ONCE:
                    self._messages[kind] = message
            silent = now - self._logged.get(kind, -REPEAT_S) < REPEAT_S
            if not silent and len(self._logged) >= MOST_LOGGED:
                # What is fed to a node may make a new sentence of each message.
                self._logged = {k: at for k, at in self._logged.items() if now - at < REPEAT_S}
                silent = len(self._logged) >= MOST_LOGGED
            if not silent:
                self._logged[kind] = now
        # After a signal rcl cannot publish it on /rosout, and complains of that instead.
        if not silent and self._node.context.ok():
            # Two statements: rclpy binds the severity to the line that logs.
            if level == ERROR:
                self._node.get_logger().error(message)
            else:
                self._node.get_logger().warning(message)

    def tally(self, name: str) -> Tally:
        """Return a counter of what comes with each frame: `count` takes ten times as long."""
        return self._tallies.setdefault(name, Tally())

    def count(self, name: str, by: int = 1) -> None:
        """Add to a counter that is shown in the diagnostics."""
        with self._lock:
            self._values[name] = int(self._values.get(name, 0)) + by  # type: ignore[call-overload]

    def show(self, name: str, value: object) -> None:
        """Set a value that is shown in the diagnostics."""
        with self._lock:
            self._values[name] = value

    def _publish(self) -> None:
        """Publish the last second and begin the next."""
        self._simulated = self._ros_clock.ros_time_is_active  # to ask for each frame takes longer
        with self._lock:
            figures = self._timing.figures(time.monotonic_ns())
        self._show(figures)
        silent = not self._messages
        for check in self._checks:
            check()
        if not silent:
            self._watch(figures)
            self._describe()
        elif self.starting:
            self.ok('waiting')
        else:
            reasons = [found for reason in self._reasons if (found := reason())]
            self.fault(WARN, '; '.join(reasons) or self._idle)
        with self._lock:
            level, messages = self._level, self._messages
            values = self._values | {
                name: each.count for name, each in self._tallies.items() if each.count
            }
            self._level, self._messages = OK, {}
        self._seconds += 1
        status = DiagnosticStatus(
            level=level,
            name=f'{self._node.get_fully_qualified_name()}: tracking',
            message='; '.join(messages.values()),
            hardware_id='',
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._ros_clock.now().to_msg()
        self._publisher.publish(array)

    def _check_log(self) -> None:
        """Report a full disk: the log goes on without a word of what it loses."""
        folder = get_logging_directory()
        try:
            full = os.statvfs(folder).f_bavail == 0
        except OSError:  # there are no log files, which was said at the start
            return
        if full:
            self.fault(
                WARN,
                f'the disk of the log files is full ({folder}), and what is logged is lost; free '
                'some of it, or set ROS_LOG_DIR to a folder on another one',
            )

    def _show(self, figures: Figures) -> None:
        """Show rate, age, latency and load."""
        self.rate = figures.rate
        self.show('rate (Hz)', f'{figures.rate:.2f}')
        for name, value in (
            ('age p50 (ms)', figures.age),
            ('latency p50 (ms)', figures.latency),
            ('latency p99 (ms)', figures.latency_p99),
        ):
            self.show(name, self._in_words(value))
        self.show('CPU (%)', f'{self._load.cpu():.1f}')
        self.show('memory (MB)', f'{self._load.memory():.0f}')

    def _in_words(self, age: float) -> str:
        """Return an age in ms, or why there is none."""
        if self._simulated:
            return 'unknown: simulated time stands still between two ticks'
        if math.isnan(age):
            return 'unknown: there was nothing in the last 10 s'
        if plausible(age):
            return f'{age:.2f}'
        name, _ = name_clock(-1e-3 * age)
        return f'unknown: the stamps are of another clock ({name})'

    def _watch(self, figures: Figures) -> None:
        """Warn where the rate fell, and of results that come in fits and starts."""
        usual = self._usual_rate.fell(figures.rate)
        if self._slowed and usual is not None:
            self.fault(
                WARN,
                f'{figures.rate:.1f} Hz arrive where {usual:.1f} Hz were usual in the last '
                f'minute: {self._slowed}',
            )
        if figures.uneven and not self._simulated:
            self.fault(
                WARN,
                f'one result in a hundred is {figures.latency_p99:.0f} ms old and the median '
                f'{figures.latency:.0f} ms: the processor, the network or a disk is busy with '
                'something else at times; look for it with top, and give this process a higher '
                'priority',
            )

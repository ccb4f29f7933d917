"""The example servo as a real process, on a pan/tilt that does what it is told."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import math
from pathlib import Path
import re
import subprocess
import sys

from blob_tracker.ros.endpoints.qos import RESULT, STATE
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from geometry_msgs.msg import Vector3Stamped
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from support.processes import Probe, probe, Process

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'servo_client.py'
FRAME_NS = 33_000_000  # between two bearings
DEAD_BAND = 0.2  # mrad, and the others below: the defaults of the example
GAIN = 0.14
FRAME = 1.0 * FRAME_NS * 1e-6  # mrad that it may turn from one bearing to the next, at 1 rad/s
LOST_AFTER_NS = 200_000_000
HOME_AFTER_NS = 3_000_000_000
DELAY = 2  # bearings from a command to the first one that shows it


class PanTilt:
    """A pan/tilt with the camera on it, in simulated time, so that no test depends on the pace."""

    def __init__(self, node: Probe, bearing: str, visible: str) -> None:
        self._node = node
        self._bearings = node.create_publisher(Vector3Stamped, f'target/{bearing}', RESULT)
        self._located = (
            self._bearings if bearing == 'bearing'
            else node.create_publisher(Vector3Stamped, 'target/bearing', RESULT)
        )
        self._visible = node.create_publisher(Bool, f'target/{visible}', STATE)
        self._clock = node.create_publisher(Clock, '/clock', RESULT)
        self._events = node.record(ParameterEvent, '/parameter_events')
        self.commands: list[JointState] = node.record(JointState, 'joint_command')
        self.now_ns = 1_700_000_000_000_000_000
        node.spin_until(lambda: all(
            publisher.get_subscription_count()
            for publisher in (self._bearings, self._located, self._visible, self._clock)
        ))
        node.spin_until(lambda: node.count_publishers('joint_command'))
        node.spin_until(self._has_the_time)

    @property
    def angles(self) -> np.ndarray:
        """Return the (N, 2) angles, pan and tilt, after 0 to N - 1 commands, mrad."""
        return 1e3 * np.array([[0.0, 0.0], *(command.position for command in self.commands)])

    def wait(self, nanoseconds: int) -> None:
        """Let simulated time pass in steps of a frame, and the servo take notice."""
        end_ns = self.now_ns + nanoseconds
        while self.now_ns < end_ns:
            self.now_ns = min(self.now_ns + FRAME_NS, end_ns)
            self._publish_time()
            self._node.spin(0.01)
        self._node.spin_until(self._has_the_time)

    def show(self, visible: bool) -> None:
        """Say whether the target is in view."""
        self._visible.publish(Bool(data=visible))
        self._node.settle(0.1)

    def bearing(self, x: float, y: float, age_ns: int = 0) -> None:
        """Say in mrad where the target is, one frame later than before."""
        self.now_ns += FRAME_NS
        self._publish_time()
        message = Vector3Stamped()
        message.header.stamp = from_ns(self.now_ns - age_ns)
        message.vector.x, message.vector.y = x, y
        self._bearings.publish(message)

    def in_view(self, ahead_ns: int) -> None:
        """Let a frame pass with a bearing on target/bearing whose stamp is ahead."""
        message = Vector3Stamped()
        message.header.stamp = from_ns(self.now_ns + ahead_ns)
        self._located.publish(message)
        self.wait(FRAME_NS)

    def turned(self, count: int) -> None:
        """Wait for that many commands in all."""
        self._node.spin_until(lambda: len(self.commands) >= count)

    def _publish_time(self) -> None:
        self._clock.publish(Clock(clock=from_ns(self.now_ns)))

    def _has_the_time(self) -> bool:
        """Tell whether the servo's clock is ours: /clock is best effort, it may have missed it."""
        self._publish_time()
        request = SetParameters.Request(
            parameters=[Parameter('use_sim_time', value=True).to_parameter_msg()]
        )
        self._node.call(SetParameters, 'servo_client/set_parameters', request)
        return any(to_ns(event.stamp) == self.now_ns for event in self._events)

    def quiet(self) -> None:
        """Give a command that should not come the time to come."""
        self._node.settle(0.2)

    def lock(self, x: float, y: float) -> None:
        """Show a target twice: the first bearing after a loss turns nothing."""
        self.show(True)
        count = len(self.commands)
        self.bearing(x, y)
        self.bearing(x, y)
        self.turned(count + 1)


@contextmanager
def servo(domain: int, *parameters: str) -> Iterator[PanTilt]:
    """Start the example in simulated time."""
    command = [sys.executable, str(EXAMPLE), '--ros-args', '-p', 'use_sim_time:=true']
    for parameter in parameters:
        command += ['-p', parameter]
    with probe(domain) as node, Process(command, domain) as process:
        names = 'bearing', 'visible'
        if 'predicted:=true' in parameters:
            names = 'bearing_predicted', 'tracked'
        yield PanTilt(node, *names)
        assert process.running
        assert process.end() == 0, process.output
    assert 'Traceback' not in process.output


@pytest.mark.parametrize('gain', [GAIN, -GAIN])
def test_it_turns_to_the_target_without_overshoot(gain: float, domain: int) -> None:
    """Right is positive pan, up is positive tilt; a negative gain is for joints the other way."""
    target = np.array([300.0, -120.0])  # mrad
    sense = math.copysign(1.0, gain)
    with servo(domain, f'gain:=[{gain}, {gain}]') as pan_tilt:
        pan_tilt.show(True)
        for count in range(100):
            error = target - sense * pan_tilt.angles[max(len(pan_tilt.angles) - 1 - DELAY, 0)]
            if (np.abs(error) <= DEAD_BAND).all():
                break
            pan_tilt.bearing(*error)
            if count:  # the first one starts the clock of the speed limit
                pan_tilt.turned(count)
        pan_tilt.quiet()
        angles = sense * pan_tilt.angles
    steps = np.diff(angles, axis=0)
    # Each angle goes one way only: no oscillation, and none past the target.
    assert (np.sign(target) * steps >= 0.0).all()
    assert np.abs(target - angles[-1]).max() <= DEAD_BAND
    # At the speed limit at first, then by the gain: the same recursion by hand takes 29 steps.
    assert np.abs(steps).max() == pytest.approx(FRAME)
    assert len(steps) < 35


def test_it_holds_still_while_the_target_is_lost_and_then_goes_home(domain: int) -> None:
    """Not visible, old bearings, no bearings: no command; after home_after s back to 0, 0."""
    with servo(domain) as pan_tilt:
        pan_tilt.bearing(50.0, 20.0)  # before anybody said that it is visible
        pan_tilt.bearing(50.0, 20.0)
        pan_tilt.quiet()
        assert not pan_tilt.commands
        pan_tilt.lock(50.0, 20.0)
        assert pan_tilt.angles[-1] == pytest.approx([50.0 * GAIN, 20.0 * GAIN])

        pan_tilt.show(False)
        pan_tilt.bearing(50.0, 20.0)
        pan_tilt.quiet()
        assert len(pan_tilt.commands) == 1

        pan_tilt.show(True)
        pan_tilt.wait(2 * LOST_AFTER_NS)
        for age_ns in (LOST_AFTER_NS + 1_000_000, 10 * LOST_AFTER_NS, -2 * LOST_AFTER_NS):
            pan_tilt.bearing(50.0, 20.0, age_ns)
            pan_tilt.bearing(50.0, 20.0, age_ns)  # the first one after a loss turns nothing
        pan_tilt.quiet()
        assert len(pan_tilt.commands) == 1

        pan_tilt.lock(-300.0, 20.0)  # it is back
        away = pan_tilt.angles[-1]
        assert away == pytest.approx([50.0 * GAIN - FRAME, 40.0 * GAIN])
        pan_tilt.wait(HOME_AFTER_NS - 2 * FRAME_NS)
        assert len(pan_tilt.commands) == 2
        pan_tilt.wait(5 * FRAME_NS)
        # At the speed limit, a step each 20 ms: then there, and nothing more to say.
        home = [[away[0] + 20.0, 0.0], [0.0, 0.0]]
        assert pan_tilt.angles[3:] == pytest.approx(np.array(home))


@pytest.mark.parametrize('predicted', [False, True])
def test_it_holds_still_while_bearings_of_another_clock_come(
    predicted: bool, domain: int
) -> None:
    """Stamps of TAI, 37 s ahead: the target is in view, and going home would lose it."""
    with servo(domain, f'predicted:={str(predicted).lower()}') as pan_tilt:
        pan_tilt.lock(20.0, 10.0)
        if predicted:
            pan_tilt.show(False)  # by the tracker, which predicts nothing then
        for _ in range(HOME_AFTER_NS // FRAME_NS + 10):
            pan_tilt.in_view(37_000_000_000)
        pan_tilt.quiet()
        assert len(pan_tilt.commands) == 1
        pan_tilt.wait(HOME_AFTER_NS + 5 * FRAME_NS)
        assert pan_tilt.angles[-1] == pytest.approx([0.0, 0.0])


def test_what_is_no_number_never_moves_it(domain: int) -> None:
    """Neither NaN nor infinity does anything or leaves a trace; what is huge meets the limits."""
    with servo(domain, 'limit:=[0.1, 0.05]') as pan_tilt:
        pan_tilt.show(True)
        for x, y in ((math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (5.0, -math.inf)):
            pan_tilt.bearing(x, y)
            pan_tilt.bearing(x, y)
        pan_tilt.quiet()
        assert not pan_tilt.commands
        pan_tilt.lock(100.0, 10.0)
        assert pan_tilt.angles[-1] == pytest.approx([100.0 * GAIN, 10.0 * GAIN])
        for _ in range(10):
            pan_tilt.bearing(1e300, 1e300)
        pan_tilt.quiet()
        assert pan_tilt.angles[-1] == pytest.approx([100.0, 50.0])
    with servo(domain, 'gain:=[.nan, .nan]') as pan_tilt:
        pan_tilt.show(True)
        for _ in range(3):
            pan_tilt.bearing(50.0, 20.0)
        pan_tilt.quiet()
        assert not pan_tilt.commands


def test_predictions_for_a_slow_servo_are_commands_as_well(domain: int) -> None:
    """Their stamps are further ahead than lost_after; as old, they would be none."""
    with servo(domain, 'predicted:=true') as pan_tilt:
        pan_tilt.show(True)
        for _ in range(2):
            pan_tilt.bearing(20.0, -10.0, -2 * LOST_AFTER_NS)
        pan_tilt.turned(1)
        assert pan_tilt.angles[-1] == pytest.approx([20.0, -10.0])
        pan_tilt.wait(4 * LOST_AFTER_NS)
        for _ in range(2):
            pan_tilt.bearing(0.0, 0.0, 2 * LOST_AFTER_NS)
        pan_tilt.quiet()
        assert len(pan_tilt.commands) == 1


@pytest.mark.parametrize('sense', [1.0, -1.0])
def test_with_predictions_it_goes_where_they_say(sense: float, domain: int) -> None:
    """As fast as it may, to the angles themselves and no further; silence and loss hold it."""
    gain = f'gain:=[{sense}, {sense}]'
    with servo(domain, 'predicted:=true', gain, 'limit:=[0.15, 0.7]') as pan_tilt:
        pan_tilt.bearing(100.0, -20.0)  # nobody has said that it is tracked
        pan_tilt.bearing(100.0, -20.0)
        pan_tilt.quiet()
        assert not pan_tilt.commands
        pan_tilt.lock(100.0, -20.0)
        for count in (2, 3, 4):
            pan_tilt.bearing(100.0, -20.0)
            pan_tilt.turned(count)
        pan_tilt.bearing(100.0, -20.0)  # it is there: nothing more to say
        pan_tilt.quiet()
        way = [[0.0, 0.0], [FRAME, -20.0], [2 * FRAME, -20.0], [3 * FRAME, -20.0], [100.0, -20.0]]
        assert sense * pan_tilt.angles == pytest.approx(np.array(way))

        pan_tilt.show(False)
        pan_tilt.bearing(0.0, 0.0)
        pan_tilt.quiet()
        assert len(pan_tilt.commands) == 4
        pan_tilt.show(True)
        pan_tilt.wait(2 * LOST_AFTER_NS)
        pan_tilt.bearing(0.0, 0.0, 2 * LOST_AFTER_NS)  # old
        pan_tilt.bearing(math.nan, 0.0)
        pan_tilt.quiet()
        assert len(pan_tilt.commands) == 4

        pan_tilt.lock(400.0, -20.0)  # beyond the limit of the joint
        for _ in range(4):
            pan_tilt.bearing(400.0, -20.0)
        pan_tilt.turned(6)
        pan_tilt.quiet()
        assert sense * pan_tilt.angles[-1] == pytest.approx([150.0, -20.0])


def test_its_help_is_whole_and_starts_nothing() -> None:
    """Each parameter with its default, as the page on prediction has them."""
    page = (EXAMPLE.parents[1] / 'docs' / 'prediction.md').read_text()
    command = [sys.executable, str(EXAMPLE), '--help']
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    rows = re.findall(r'^  (\w+) +.* \((.*)\)$', told.partition('parameters:')[2], re.M)
    assert len(rows) == 7
    for name, default in rows:
        assert f'| `{name}` | `{default.lower()}` |' in page


@pytest.mark.parametrize(('words', 'said'), [
    (('-p', 'gian:=[0.1, 0.1]'), "no parameter 'gian'; there is gain\n"),
    (('-p', 'kp:=0.1'), "no parameter 'kp'; there is gain, predicted, dead_band, speed, limit"),
])
def test_a_misspelt_parameter_is_refused(words: tuple[str, ...], said: str, domain: int) -> None:
    """With the one that is meant, or all that there are."""
    with Process([sys.executable, str(EXAMPLE), '--ros-args', *words], domain) as process:
        assert process.wait() == 2
    assert said in process.output
    assert 'Traceback' not in process.output

"""The simulator's stamps: at equal intervals, whenever its process wakes."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker.nodes.simulator import SimulatorNode
from blob_tracker.types import Frame
import numpy as np
import pytest
import rclpy
from rclpy.clock import ClockType
from rclpy.time import Time

RATE, MS = 50.0, 1_000_000


class SetClock:
    """A clock that the test sets."""

    ros_time_is_active = False
    now_ns = 10**18

    def now(self) -> Time:
        """Return the time."""
        return Time(nanoseconds=self.now_ns, clock_type=ClockType.ROS_TIME)


class Woken:
    """A simulator that the test wakes."""

    def __init__(self, node: SimulatorNode, clock: SetClock, frames: list[Frame]) -> None:
        self._node, self._clock, self._frames = node, clock, frames
        self._begin_ns = node._stamp_ns

    def at(self, milliseconds: float) -> tuple[int, bool]:
        """Return the stamp, ms, and whether the light is on, of the frame of a time."""
        self._clock.now_ns = self._begin_ns + round(MS * milliseconds)
        self._node._publish()
        frame = self._frames[-1]
        since_ns = frame.stamp_ns + self._node._scene.before_middle_ns - self._begin_ns
        return since_ns // MS, bool(frame.image.max() > 100)


@pytest.fixture
def woken(
    domain: int, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> Iterator[Woken]:
    """Give one of a light in step, or of the mode that is asked for."""
    mode = getattr(request, 'param', 'alternate')
    given = {'flash.mode': mode, 'rate': RATE, 'width': 64, 'height': 48}
    rclpy.init(
        args=['--ros-args', *(w for k, v in given.items() for w in ('-p', f'{k}:={v}'))],
        domain_id=domain,
    )
    frames: list[Frame] = []
    node = SimulatorNode(deliver=lambda delivery: frames.append(delivery.item[0]))
    clock = SetClock()
    clock.now_ns = node._stamp_ns
    monkeypatch.setattr(node, 'get_clock', lambda: clock)
    yield Woken(node, clock, frames)
    node.destroy_node()
    rclpy.shutdown()


def test_a_process_that_wakes_late_stamps_in_time(woken: Woken) -> None:
    """Each frame is as far from the last as the light has moved."""
    late = np.random.default_rng(1).uniform(0.0, 19.0, 50)
    stamps = [woken.at(20.0 * number + each)[0] for number, each in enumerate(late, 1)]
    assert stamps == [20 * number for number in range(1, 51)]


def test_frames_whose_time_is_over_are_left_out_by_two(woken: Woken) -> None:
    """So that a light in step is on in every other frame that comes."""
    seen = [woken.at(each) for each in (20, 40, 85, 100, 120, 225, 240)]
    assert [stamp for stamp, _ in seen] == [20, 40, 60, 80, 100, 200, 220]
    lit = [on for _, on in seen]
    assert lit == [lit[0], not lit[0]] * 3 + [lit[0]]


@pytest.mark.parametrize('woken', ['periodic'], indirect=True)
def test_a_light_on_its_own_clock_is_shown_as_it_is_now(woken: Woken) -> None:
    """As many frames are left out as are over."""
    assert [woken.at(each)[0] for each in (20, 40, 85, 100)] == [20, 40, 80, 100]


def test_a_clock_that_is_set_is_followed(woken: Woken) -> None:
    """At once, in either direction."""
    assert [woken.at(each)[0] for each in (20, 5020, 5040, 1000)] == [20, 5020, 5040, 1000]

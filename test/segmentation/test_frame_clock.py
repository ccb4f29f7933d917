"""Frames are counted by their stamps, so that even and odd are told through losses."""

from __future__ import annotations

from blob_tracker.segmentation.frame_clock import (
    age_of, FrameClock, in_step, is_complete, is_due, is_phase_unknown, tick,
)
import pytest

FRAME_NS = 16_666_667


def clock_after(*stamps: float) -> FrameClock:
    """Return a clock that has had these stamps, frames."""
    clock = FrameClock()
    for stamp in stamps:
        tick(clock.values, stamp_of(clock, stamp))
    return clock


def stamp_of(clock: FrameClock, frames: float) -> float:
    """Return a stamp, frames, as the kernels have it."""
    return clock.since_first(10**18 + round(frames * FRAME_NS))


def test_a_lost_frame_is_counted() -> None:
    """The number goes on by two, and what was lit before the gap is told even from odd."""
    clock = clock_after(0, 1, 2, 3, 5)
    assert clock.frame == 5
    assert clock.interval == pytest.approx(FRAME_NS / 1e9)
    assert age_of(clock.values, stamp_of(clock, 3)) == pytest.approx(2.0)
    assert in_step(clock.values, stamp_of(clock, 3)) and is_due(clock.values, stamp_of(clock, 3))
    assert not in_step(clock.values, stamp_of(clock, 2))
    assert not is_due(clock.values, stamp_of(clock, 4))


@pytest.mark.parametrize('frames, complete', [((0, 1, 2, 3, 4), True), ((0, 1, 3, 4), False)])
def test_a_lost_frame_is_noticed(frames: tuple[int, ...], complete: bool) -> None:
    """By the intervals since a stamp."""
    clock = clock_after(*frames)
    assert is_complete(clock.values, stamp_of(clock, 0)) is complete
    assert is_complete(clock.values, stamp_of(clock, 3))


@pytest.mark.parametrize('late, can_be_on', [(0.2, False), (0.3, True)])
def test_a_stamp_that_tells_nothing_speaks_against_nothing(late: float, can_be_on: bool) -> None:
    """Up to a quarter of a frame off it tells even from odd; beyond it either may be."""
    clock = clock_after(0, 1, 2, 3, 4 + late)
    assert in_step(clock.values, stamp_of(clock, 3)) is can_be_on


def test_after_a_frame_that_came_twice_the_phase_is_unknown() -> None:
    """A light seen before it may be on in any frame from the next flash on; not one seen later."""
    clock = clock_after(0, 1, 2)
    clock.skip(10**18 + round(2.5 * FRAME_NS))
    tick(clock.values, stamp_of(clock, 3))
    tick(clock.values, stamp_of(clock, 4))
    first, third = stamp_of(clock, 1), stamp_of(clock, 3)
    assert is_phase_unknown(clock.values, first) and in_step(clock.values, first)
    assert not is_phase_unknown(clock.values, third) and not in_step(clock.values, third)


def test_before_two_stamps_nothing_is_old() -> None:
    """There is no unit to count in."""
    clock = clock_after(7)
    assert age_of(clock.values, stamp_of(clock, 2)) == 0.0


def test_nanoseconds_are_kept_for_months() -> None:
    """Stamps of ROS have 19 digits, and a float 16."""
    clock = FrameClock()
    clock.since_first(1_790_000_000_123_456_789)
    month = 30 * 86_400 * 10**9
    assert clock.since_first(1_790_000_000_123_456_789 + month + 1) == month + 1

"""Frames are counted by their stamps, so that even and odd are told through losses."""

from __future__ import annotations

from blob_tracker.segmentation.flash_track import FlashTrack
from blob_tracker.segmentation.frame_clock import FrameClock
import pytest

FRAME_NS = 16_666_667


def clock_after(*stamps: float) -> FrameClock:
    """Return a clock that has had these stamps, frames."""
    clock = FrameClock()
    for stamp in stamps:
        clock.push(round(stamp * FRAME_NS))
    return clock


def track(seen: float) -> FlashTrack:
    """Return a track last seen at that stamp, frames."""
    return FlashTrack(0.0, 0.0, 1.5, 100.0, round(seen * FRAME_NS))


def test_a_lost_frame_is_counted() -> None:
    """The number goes on by two, and what was lit before the gap is told even from odd."""
    clock = clock_after(0, 1, 2, 3, 5)
    assert clock.frame == 5
    assert clock.age(track(3)) == pytest.approx(2.0)
    assert clock.in_step(track(3)) and clock.is_due(track(3))
    assert not clock.in_step(track(2))
    assert not clock.is_due(track(4))


@pytest.mark.parametrize('late, in_step', [(0.2, False), (0.3, True)])
def test_a_stamp_that_tells_nothing_speaks_against_nothing(late: float, in_step: bool) -> None:
    """Up to a quarter of a frame off it tells even from odd; beyond it either may be."""
    assert clock_after(0, 1, 2, 3, 4 + late).in_step(track(3)) is in_step


def test_after_a_frame_that_came_twice_the_phase_is_unknown() -> None:
    """A light seen before it may be on in any frame from the next flash on; not one seen later."""
    clock = clock_after(0, 1, 2)
    clock.skip(round(2.5 * FRAME_NS))
    clock.push(3 * FRAME_NS)
    clock.push(4 * FRAME_NS)
    assert clock.is_phase_unknown(track(1)) and clock.in_step(track(1))
    assert not clock.is_phase_unknown(track(3)) and not clock.in_step(track(3))


def test_before_two_stamps_nothing_is_old() -> None:
    """There is no unit to count in."""
    assert clock_after(7).age(track(2)) == 0.0

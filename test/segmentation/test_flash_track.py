"""Where the track of a light may go on, and which light goes on with it."""

from __future__ import annotations

from blob_tracker.segmentation.flash_track import (
    FLANK_SIGMA, FlashTrack, gate_radius, lights_in, offset_of, place_of, reach_of, rows_of,
)
from blob_tracker.segmentation.frame_clock import FrameClock, tick
import numpy as np
import pytest
from support.contrasts import candidate_at

GATE = 24.0
NOWHERE = np.full(3, -1.0)


def clock_at(frame: int) -> np.ndarray:
    """Return a clock whose frames are 10 ns apart, in this one."""
    clock = FrameClock()
    for index in range(frame + 1):
        tick(clock.values, 10.0 * index)
    return clock.values


def track(**changes: float) -> np.ndarray:
    """Return a track that was seen in frame 4, 2 px wide and 100 DN high."""
    return np.array(FlashTrack(100.0, 50.0, 2.0, 100.0, 40.0)._replace(**changes))


def test_it_goes_on_at_its_speed() -> None:
    """Two frames later it is two of its ways further; from elsewhere it may be told better."""
    moving = track(velocity_x=3.0, velocity_y=-1.0)
    assert place_of(moving, clock_at(6), NOWHERE) == pytest.approx((106.0, 48.0))
    told = np.array([120.0, 60.0, 5.0])
    assert reach_of(moving, clock_at(6), told, GATE) == (120.0, 60.0, 5.0 + 2.0 * FLANK_SIGMA)


def test_what_is_known_of_its_motion_leaves_less_room() -> None:
    """The gate at first, and a part of it from the second flash on; more with each one missed."""
    first, second = track(), track(flashes=2.0)
    assert gate_radius(first, GATE, 2.0) == pytest.approx(8.0 + GATE)
    assert gate_radius(second, GATE, 2.0) == pytest.approx(8.0 + 0.3 * GATE)
    assert gate_radius(second, GATE, 4.0) == pytest.approx(8.0 + 0.6 * GATE)


@pytest.mark.parametrize('column, height, away', [
    (103.0, 100.0, 3.0), (103.0, 41.0, 3.0), (103.0, 39.0, np.inf), (103.0, 251.0, np.inf),
    (131.0, 100.0, 31.0), (133.0, 100.0, np.inf),
])
def test_another_light_is_too_far_or_too_bright(
    column: float, height: float, away: float
) -> None:
    """Beyond 32 px, or 2.5 times as bright or as faint."""
    light, = lights_in(rows_of([candidate_at(0, 0, x=column, y=50.0, height=height)]))
    reach = reach_of(track(), clock_at(6), NOWHERE, GATE)
    assert offset_of(track(), reach, light) == pytest.approx(away)


def test_a_row_has_what_a_track_takes_of_a_candidate() -> None:
    """The sigma is that of both axes, and one that is rejected is there, but not allowed."""
    seen = candidate_at(30, 20, sigma_x=1.0, sigma_y=7.0, snr=12.0)
    rows = rows_of([seen, seen._replace(rejected='a lamp')])
    assert lights_in(rows).tolist() == [
        [30.0, 20.0, pytest.approx(5.0), 100.0, 1.0, 12.0],
        [30.0, 20.0, pytest.approx(5.0), 100.0, 0.0, 12.0],
    ]
    assert lights_in(rows_of([])).shape == (0, 6)

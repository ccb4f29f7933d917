"""The table of tracks: which lights go on with them, what ends, and what is kept of a crowd."""

from __future__ import annotations

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.flash_track import DOUBTED, FIELDS, FLASHES, HEIGHT, rows_of, X
from blob_tracker.segmentation.flash_tracks import (
    keep, LIGHT, LOCKED, MAX_AGE_FRAMES, MOST_LIGHTS, MOST_TRACKS, next_frame, no_tracks, NUMBER,
    region_about, take,
)
from blob_tracker.segmentation.frame_clock import FrameClock
import numpy as np
import pytest
from support.contrasts import candidate_at

GATE = 24.0


class Table:
    """Frames 10 ns apart, in which this or that lights up."""

    def __init__(self) -> None:
        self.clock = FrameClock().values
        self.tracks, self.counts = no_tracks()
        self.target, self.expected = np.zeros(FIELDS), np.full(3, -1.0)

    def see(self, index: int, *lights: Candidate, best: int = -1) -> np.ndarray:
        """Take a frame; follow one of what is returned, or none."""
        next_frame(self.clock, self.tracks, self.counts, self.target, 10.0 * index)
        seen = take(
            self.clock, self.tracks, self.counts, self.target, self.expected, np.empty((0, 3)),
            rows_of(lights), GATE, False,
        )
        keep(self.tracks, self.counts, self.target, seen, best)
        return seen

    @property
    def kept(self) -> np.ndarray:
        """Return the tracks that there are."""
        return self.tracks[:self.counts[NUMBER]]


@pytest.mark.parametrize('index, flashes, out_of_step', [
    (2, 2.0, 0.0), (4, 1.0, 0.0), (3, 1.0, 1.0), (1, 1.0, 1.0),
])
def test_what_lights_up_again_goes_on_in_step(
    index: int, flashes: float, out_of_step: float
) -> None:
    """Two frames later; after four it is as new, after one or three marked; one track is left."""
    table = Table()
    table.see(0, candidate_at(100, 50))
    for empty in range(1, index):
        table.see(empty)
    seen, = table.see(index, candidate_at(103, 50))
    assert (seen[FLASHES], seen[DOUBTED]) == (flashes, out_of_step)
    assert table.kept.tolist() == [seen[:FIELDS].tolist()]


def test_a_flash_whose_frame_was_lost_is_not_missed() -> None:
    """It may have flashed there: what lights up four frames later is its second flash."""
    table = Table()
    for index in range(4):
        table.see(index)
    table.see(4, candidate_at(100, 50))
    table.see(5)
    table.see(7)
    seen, = table.see(8, candidate_at(103, 50))
    assert seen[FLASHES] == 2.0


def test_the_nearest_pairs_come_first() -> None:
    """Two lights within reach of each other, given in the other order."""
    table = Table()
    table.see(0, candidate_at(100, 50), candidate_at(110, 50))
    table.see(1)
    seen = table.see(2, candidate_at(111, 50), candidate_at(101, 50), candidate_at(119, 50))
    assert seen[:, FLASHES].tolist() == [2.0, 2.0, 1.0]
    assert seen[:, LIGHT].tolist() == [0.0, 1.0, 2.0]


def test_old_tracks_end_and_the_rest_stay_in_their_order() -> None:
    """The one that is followed among them, whose row is another one then."""
    table = Table()
    table.see(0, candidate_at(20, 20))
    for index in range(1, MAX_AGE_FRAMES - 1):
        table.see(index)
    table.see(MAX_AGE_FRAMES - 1, candidate_at(300, 300))
    table.see(MAX_AGE_FRAMES, candidate_at(500, 100), best=0)
    assert table.kept[:, X].tolist() == [20.0, 300.0, 500.0]
    table.see(MAX_AGE_FRAMES + 1)
    assert table.kept[:, X].tolist() == [300.0, 500.0] and table.counts[LOCKED] == 1
    for index in range(MAX_AGE_FRAMES + 2, 2 * MAX_AGE_FRAMES + 2):
        table.see(index)
    assert table.counts[NUMBER] == 0 and table.counts[LOCKED] == -1


def test_of_a_crowd_the_highest_are_kept() -> None:
    """Of a frame, and of all; the one that is followed stays however faint it is."""
    random = np.random.default_rng(4)
    table = Table()
    table.see(0, candidate_at(5, 5, height=1.0), best=0)
    for index in range(1, 7):
        places = random.integers((100, 100), (4000, 3000), (200, 2))
        crowd = [
            candidate_at(int(x), int(y), height=float(height))
            for (x, y), height in zip(places, random.uniform(50.0, 90.0, 200))
        ]
        seen = table.see(index, *crowd)
        assert len(seen) == MOST_LIGHTS
        assert seen[:, HEIGHT].min() >= sorted(each.height for each in crowd)[-MOST_LIGHTS]
    assert table.counts[NUMBER] == MOST_TRACKS
    assert table.tracks[table.counts[LOCKED], HEIGHT] == 1.0


def test_the_region_is_the_frame_until_the_motion_is_known() -> None:
    """And then a square about where the light is due, within the frame."""
    table = Table()
    for index in (0, 2, 4):
        table.see(index, candidate_at(100 + 3 * index, 50), best=0)
        table.see(index + 1)
        region = region_about(
            table.clock, table.tracks, table.counts, table.expected, GATE, 480, 640
        )
        assert (region == (0, 0, 640, 480)) == (index == 0)
    x0, y0, x1, y1 = region
    assert (x0 + x1 - 1) / 2 == 115 and y0 == 50 - (x1 - x0) // 2 and x1 - x0 == y1 - y0

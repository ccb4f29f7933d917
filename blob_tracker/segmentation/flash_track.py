"""What lights up, frame by frame: the track of a light, and which candidate continues it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
import math
from typing import NamedTuple

from blob_tracker.segmentation.candidate import Candidate

PERIOD_FRAMES = 2  # frames from one flash to the next
FOLLOWED_GATE_FRACTION = 0.3  # of the gate: what is left to chance once the motion is known
FLANK_SIGMA = 4.0  # sigma: a wide blob's peak wanders so far
MAX_BRIGHTNESS_RATIO = 2.5  # times brighter or fainter than before, and still the same light


@dataclass(slots=True)
class FlashTrack:
    """A light that may be the target, as it was last seen."""

    x: float
    y: float
    sigma: float
    height: float
    stamp_ns: int
    flashes: int = 1
    run: int = 1  # of them since one was missed
    velocity_x: float = 0.0  # px a frame
    velocity_y: float = 0.0
    out_of_step: bool = False
    trusted: bool = False

    def position_at(self, age: float) -> tuple[float, float]:
        """Return where it is expected so many frames later, px."""
        return self.x + self.velocity_x * age, self.y + self.velocity_y * age

    def gate_radius_px(self, gate_px: float, age: float) -> float:
        """Return how far from there it may be, px."""
        moved = gate_px if self.flashes == 1 else FOLLOWED_GATE_FRACTION * gate_px
        return FLANK_SIGMA * self.sigma + moved * max(age, 1.0) / PERIOD_FRAMES


class Reach(NamedTuple):
    """Where a track is expected in a frame, and how far from there it may be, px."""

    track: FlashTrack
    x: float
    y: float
    radius: float


def partners_of(
    candidates: Sequence[Candidate],
    reaches: Mapping[int, Reach],
    beside: Set[int],
    target: int,
) -> dict[int, FlashTrack]:
    """
    Return the tracks that candidates belong to, by their index; the nearest pairs first.

    The candidates `beside` the target do not belong to its track, whose key is `target`.
    """
    pairs = []
    for index, candidate in enumerate(candidates):
        x, y = candidate.x, candidate.y
        for key, reach in reaches.items():
            _, there_x, there_y, radius = reach
            # Most of a crowd is far away: told by the first of these.
            if -radius < x - there_x < radius and -radius < y - there_y < radius:
                offset_px = offset_px_of(reach, candidate)
                if offset_px < math.inf and not (key == target and index in beside):
                    pairs.append((offset_px, index, key))
    pairs.sort()
    partners: dict[int, FlashTrack] = {}
    taken: set[int] = set()
    for _, index, key in pairs:
        if index not in partners and key not in taken:
            partners[index] = reaches[key].track
            taken.add(key)
    return partners


def offset_px_of(reach: Reach, candidate: Candidate) -> float:
    """Return how far a candidate is from where a track is expected; infinity for another light."""
    track, x, y, radius = reach
    offset_px = math.hypot(candidate.x - x, candidate.y - y)
    alike = (
        track.height < MAX_BRIGHTNESS_RATIO * candidate.height
        and candidate.height < MAX_BRIGHTNESS_RATIO * track.height
    )
    return offset_px if offset_px < radius and alike else math.inf

"""The target as it was last seen, and the lights that flash in step beside it."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.companions import Companion, Companions
from blob_tracker.segmentation.flash_track import (
    FLANK_SIGMA, FlashTrack, offset_px_of, PERIOD_FRAMES, Reach,
)
from blob_tracker.segmentation.flash_tracks import FlashTracks, MAX_AGE_FRAMES
from blob_tracker.segmentation.frame_clock import FrameClock

# Frames without the target (1 s at 60 a second) after which another light in step is taken for it,
# and for which it is remembered from then on.
PATIENCE_FRAMES, MEMORY_FRAMES = 60, 7200


class TargetMemory:
    """
    Know the target from the lights that flash in step beside it, as its reflections do.

    They are known by where they are from it. Where it is hidden none of them is taken for it, for
    a second; and the one that is taken then is left for the target once that flashes again.

    Parameters
    ----------
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.
    clock : FrameClock
        Of the frames that are taken.
    tracks : FlashTracks
        Of all that lights up in them.

    Attributes
    ----------
    stands_in : bool
        Whether another light is followed in place of the target.
    companions : Companions
        Those that are known.

    """

    def __init__(self, gate_px: float, clock: FrameClock, tracks: FlashTracks) -> None:
        self.stands_in = False
        self.companions = Companions()
        self._gate_px, self._clock, self._tracks = gate_px, clock, tracks
        self._target: FlashTrack | None = None  # as it was last seen, also when it is lost

    def end_old(self) -> None:
        """Forget a target that was not seen for two minutes."""
        target = self._target
        if target is not None and target.stamp_ns < self._clock.stamp_before(MEMORY_FRAMES):
            self._target, self.stands_in = None, False

    def forget(self) -> None:
        """Know of no target, and of nothing beside it."""
        self._target = None
        self.companions.forget()

    def follow(self, track: FlashTrack) -> None:
        """Take the track that is followed from this frame on for the target, or its stand-in."""
        target = self._target
        if self._tracks.locked is None and target is not None:
            gone = self._clock.age(target) > MAX_AGE_FRAMES
            if gone and self.beside(track) is not None:
                self.stands_in = True
            elif not self.stands_in and math.hypot(
                track.x - target.x, track.y - target.y
            ) > 2.0 * self._gate_px:
                self.companions.forget()
        self._tracks.locked = track
        if not self.stands_in:
            self._target = track

    def exchange(self, brighter: FlashTrack) -> None:
        """Take a brighter light for the target: what was followed is a reflection of it."""
        self._tracks.locked = self._target = brighter
        self.stands_in = False

    def learn(self, others: Sequence[FlashTrack]) -> None:
        """Take these lights, at least one, for all that flash beside the target."""
        if not self.stands_in:
            assert self._tracks.locked is not None
            self.companions.learn(self._tracks.locked, others)

    def beside(self, light: Candidate | FlashTrack) -> Companion | None:
        """Return which of the lights that flash beside the target this is; None for none."""
        target = self._target
        if target is None or self.stands_in:
            return None
        # Where it was, and where its last speed would have it: that is not known to a pixel.
        places = [(target.x, target.y)]
        if target is self._tracks.locked:
            places.append(self._tracks.predicted_position(target))
        for x, y in places:
            found = self.companions.like(light.x - x, light.y - y, light.height, self._gate_px)
            if found is not None:
                return found
        return None

    def why_to_wait(self, candidate: Candidate) -> str:
        """Say why a light is not taken: the target, beside which it flashes, may come back."""
        target = self._target
        if target is None or not self.companions:
            return ''
        age = self._clock.age(target)
        if age > PATIENCE_FRAMES:
            return ''
        companion = self.beside(candidate)
        if companion is not None:
            away = math.hypot(companion.dx, companion.dy)
        elif not self.stands_in and not self._is_in_reach(target, candidate):
            away = math.hypot(candidate.x - target.x, candidate.y - target.y)
        else:
            return ''
        return (
            f'another light flashes in step, {away:.0f} px from the target, which was last seen '
            f'{age:.0f} frames ago; a reflection? It is taken after {PATIENCE_FRAMES} frames'
        )

    def _is_in_reach(self, target: FlashTrack, candidate: Candidate) -> bool:
        """Tell whether the target can be this light, by where it was and how bright."""
        if target is self._tracks.locked:
            reach = self._tracks.reach(target)
        else:
            radius = FLANK_SIGMA * target.sigma
            radius += self._gate_px * max(self._clock.age(target) / PERIOD_FRAMES, 1.0)
            reach = Reach(target, target.x, target.y, radius)
        return offset_px_of(reach, candidate) < math.inf

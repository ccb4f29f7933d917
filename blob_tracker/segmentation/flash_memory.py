"""What is remembered of lights from frame to frame: tracks, the target, what is beside it."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.kernel import Array
from blob_tracker.segmentation.at_once import (
    Asked, pair_at_once, QUIET, SEARCHED, Shown, Watched,
)
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.companions import companion_at, Companions
from blob_tracker.segmentation.expectation import Expectation, GATE_SIGMA
from blob_tracker.segmentation.flash_track import (
    DOUBTED, FIELDS, FLANK_SIGMA, FLASHES, FlashTrack, lights_in, offset_of, reach_of, rows_of,
    RUN, SEEN,
)
from blob_tracker.segmentation.flash_tracks import (
    ASK, confirm, follow, half_side, IN_SEEN, is_missed, is_open, IS_TARGET, keep, KNOWN, LOCKED,
    LOCKED_FRAMES, MAX_AGE_FRAMES, next_frame, no_tracks, NUMBER, region_about, see, STANDS_IN,
    take, way_from_one_alike,
)
from blob_tracker.segmentation.frame_clock import age_of, FrameClock, PERIOD_FRAMES
from blob_tracker.types import Pixels
import numpy as np

# Frames without the target (1 s at 60 a second) after which another light in step is taken for it
PATIENCE_FRAMES = 60
PAUSE_FRAMES = 15  # that are not taken at once after one that was searched in vain


class FlashMemory:
    """
    Keep the tracks of lights, and know the target from the lights that flash in step beside it.

    These, as its reflections, are known by where they are from it. Where it is hidden none of them
    is taken for it, for a second; and the one that is taken then is left for the target once that
    flashes again.

    Parameters
    ----------
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.

    Attributes
    ----------
    clock : FrameClock
        Of the frames that were taken.
    is_due : bool
        Whether the light that was followed before this frame may flash again in it.
    expected : Expectation or None
        Where the light that is followed is in this frame, where a tracker tells.
    companions : Companions
        The lights beside the target that are known.

    """

    def __init__(self, gate_px: float) -> None:
        self.clock = FrameClock()
        self.expected: Expectation | None = None
        self.is_due = False
        self.companions = Companions()
        self._gate_px = gate_px
        self._tracks, self._counts = no_tracks()
        self._target = np.zeros(FIELDS)  # as it was last seen, also when it is lost
        self._expected = np.full(3, -1.0)  # as the kernels take it
        self._wait = 0  # frames until one is taken at once again

    @property
    def locked(self) -> bool:
        """Whether a light is followed."""
        return self._counts.item(LOCKED) >= 0

    @property
    def locked_frames(self) -> int:
        """For how many frames one has been followed."""
        return self._counts.item(LOCKED_FRAMES)

    @property
    def stands_in(self) -> bool:
        """Whether what is followed is another light in place of the target."""
        return self._counts.item(STANDS_IN) > 0

    @property
    def followed(self) -> FlashTrack | None:
        """Return the track of the light that is followed."""
        k = self._counts.item(LOCKED)
        return None if k < 0 else FlashTrack(*self._tracks[k].tolist())

    @property
    def moves(self) -> bool:
        """Whether a light is followed whose motion is known."""
        k = self._counts.item(LOCKED)
        return k >= 0 and self._tracks.item(k, FLASHES) >= 2.0

    @property
    def is_seen(self) -> bool:
        """Whether the light that is followed was seen in this frame."""
        k = self._counts.item(LOCKED)
        return k >= 0 and self._tracks.item(k, SEEN) == self.clock.stamp

    def next_frame(self, stamp_ns: int) -> None:
        """Take the stamp of the next frame, ns; what was not seen for too long ends."""
        self.is_due = next_frame(
            self.clock.values, self._tracks, self._counts, self._target,
            self.clock.since_first(stamp_ns),
        )
        if self.expected is not None:
            self.expect(None)

    def at_once(
        self, stamp_ns: int, lit: Pixels, unlit: Pixels, asked: Asked, saturation: int,
        crowd: Array, watched: Watched, *, alone: bool,
    ) -> Shown | None:
        """
        Take a frame where nothing is odd about it, see `at_once.pair_at_once`; None of any other.

        Parameters
        ----------
        stamp_ns : int
            Its stamp, ns.
        lit, unlit : (h, w) arrays
            The frame and the one before it, DN.
        asked : Asked
            What is asked of the light.
        saturation : int
            The DN at which a pixel is clipped.
        crowd : (6,) array
            See `Crowd`.
        watched : Watched
            What was seen of it before.
        alone : bool
            Whether nothing else speaks against a light that is the only one.

        """
        if self.expected is not None:
            return None
        if self._wait > 0:
            self._wait -= 1
            return None
        stamp = self.clock.since_first(stamp_ns)
        found = Shown(*pair_at_once(
            lit, unlit, asked.mask, self.clock.values, self._tracks, self._counts, self._target,
            self._expected, self.companions.lights, crowd, *watched.memory,
            (stamp, stamp_ns / 1e9, watched.since, watched.exposure), watched.place,
            (self._gate_px, asked.min_snr, asked.gated_snr, asked.sigmas), asked.largest,
            saturation, alone,
        ))
        if found.outcome < QUIET:
            if found.outcome == SEARCHED:
                self._wait = PAUSE_FRAMES
            return None
        self.is_due = watched.since > 0.0 and found.shown
        return found

    def expect(self, place: Expectation | None) -> None:
        """Take the word of a tracker for where the light that is followed is in this frame."""
        self.expected = place
        self._expected[:] = -1.0 if place is None else (place.x, place.y, place.gate_radius_px)

    def expect_turned(self) -> None:
        """Expect the light that is followed as far from its last place as any light may go."""
        followed = self.followed
        assert followed is not None
        self.expect(Expectation(
            followed.x, followed.y, (self._gate_px / GATE_SIGMA) ** 2 * np.eye(2)))

    def region(self, shape: tuple[int, int]) -> Box:
        """Return where in a frame of (h, w) the target can be."""
        return Box(*region_about(
            self.clock.values, self._tracks, self._counts, self._expected, self._gate_px, *shape
        ))

    def half_side(self) -> float:
        """Return half the side of that region, px."""
        track = self._tracks[self._counts.item(LOCKED)]
        return half_side(self.clock.values, track, self._expected, self._gate_px)

    def is_missed(self, everything: Sequence[Candidate]) -> bool:
        """Tell whether the light that is followed is due and not among what lit up."""
        return is_missed(
            self.clock.values, self._tracks[self._counts.item(LOCKED)], rows_of(everything),
            self._expected, self._gate_px,
        )

    def see(
        self, everything: Sequence[Candidate], crowd: Array, shape: tuple[int, int], *,
        alone: bool, agreed: bool,
    ) -> tuple[Array, int, int]:
        """Take what lit up, see `flash_tracks.see`; nothing is told before it is agreed on."""
        state = (
            self.clock.values, self._tracks, self._counts, self._target, self._expected,
            self.companions.lights,
        )
        rows = rows_of(everything)
        if agreed:
            return take(*state, rows, self._gate_px, False), -1, ASK
        return see(*state, crowd, rows, self._gate_px, shape[0] * shape[1], alone)

    def confirm(self, seen: Array, crowd: Array, shape: tuple[int, int], *, alone: bool) -> int:
        """Note which of the lights that were seen are confirmed, see `flash_tracks.confirm`."""
        return confirm(
            self.clock.values, self._counts, crowd, seen, self._gate_px, shape[0] * shape[1], alone
        )

    def keep(self, seen: Array, best: int) -> None:
        """Keep the tracks of what was seen, and follow one of them, or none for -1."""
        if best >= 0 and self._counts.item(KNOWN) and not self.locked:
            self._meet(FlashTrack(*seen[best, :FIELDS].tolist()))
        keep(self._tracks, self._counts, self._target, seen, best)

    def keep_alone(self, track: FlashTrack | None) -> None:
        """Follow a track, and forget all others; or forget all of them."""
        if track is None:
            self._counts[NUMBER], self._counts[LOCKED], self._counts[IS_TARGET] = 0, -1, 0
            return
        if self._counts.item(KNOWN) and not self.locked:
            self._meet(track)
        self._tracks[0], self._counts[NUMBER] = track, 1
        follow(self._tracks, self._counts, self._target, 0)

    def among(self, seen: Array) -> tuple[int, bool]:
        """Return which of what was seen is followed, or -1; whether another may be the target."""
        return max(self._counts.item(LOCKED) - IN_SEEN, -1), is_open(
            self.clock.values, self._tracks, self._counts, seen
        )

    def lose(self) -> None:
        """Follow nothing, and know of no target and nothing beside it."""
        self._counts[LOCKED], self._counts[KNOWN], self._counts[IS_TARGET] = -1, 0, 0
        self.companions.forget()

    def _meet(self, track: FlashTrack) -> None:
        """See what a light is to the target that was lost, before it is followed."""
        target = FlashTrack(*self._target.tolist())
        gone = age_of(self.clock.values, target.stamp) > MAX_AGE_FRAMES
        if gone and self.beside(track) >= 0:
            self._counts[STANDS_IN] = 1
        elif not self.stands_in and math.hypot(
            track.x - target.x, track.y - target.y
        ) > 2.0 * self._gate_px:
            self.companions.forget()

    def survey(self, everything: Sequence[Candidate]) -> None:
        """Take what lit up beside the light that is followed."""
        seen = take(
            self.clock.values, self._tracks, self._counts, self._target, self._expected,
            self.companions.lights, rows_of(everything), self._gate_px, True,
        )
        keep(self._tracks, self._counts, self._target, seen, -1)

    def in_run(self, least: int) -> list[FlashTrack]:
        """Return those in step that flash in this frame, but for the one that is followed."""
        tracks = self._tracks[:self._counts.item(NUMBER)]
        those = (
            (tracks[:, SEEN] == self.clock.stamp) & (tracks[:, RUN] >= least)
            & (tracks[:, DOUBTED] == 0.0)
        )
        those[self._counts.item(LOCKED)] = False
        return [FlashTrack(*row) for row in tracks[those].tolist()]

    def exchange(self, brighter: FlashTrack) -> None:
        """Take a brighter light for the target: what was followed is a reflection of it."""
        rows = self._tracks[:self._counts.item(NUMBER)]
        self._counts[STANDS_IN] = 0
        k = int(np.flatnonzero((rows == brighter).all(axis=1))[0])
        follow(self._tracks, self._counts, self._target, k)

    def learn(self, others: Sequence[FlashTrack]) -> None:
        """Take these lights, at least one, for all that flash beside the target."""
        followed = self.followed
        if followed is not None and not self.stands_in:
            self.companions.learn(followed, others)

    def beside(self, light: Candidate | FlashTrack) -> int:
        """Return which of the lights that flash beside the target this is; -1 for none."""
        counts = self._counts
        if not counts.item(KNOWN) or counts.item(STANDS_IN):
            return -1
        return companion_at(
            self.companions.lights, self._target, counts.item(IS_TARGET) > 0, self.clock.values,
            self._expected, light.x, light.y, light.height, self._gate_px,
        )

    def why_to_wait(self, candidate: Candidate) -> str:
        """Say why a light is not taken: the target, beside which it flashes, may come back."""
        if not (self._counts.item(KNOWN) and len(self.companions.lights)):
            return ''
        target = FlashTrack(*self._target.tolist())
        age = age_of(self.clock.values, target.stamp)
        if age > PATIENCE_FRAMES:
            return ''
        k = self.beside(candidate)
        if k >= 0:
            away = math.hypot(*self.companions.lights[k, :2].tolist())
        elif not self.stands_in and not self._is_in_reach(target, age, candidate):
            away = math.hypot(candidate.x - target.x, candidate.y - target.y)
        else:
            return ''
        return (
            f'another light flashes in step, {away:.0f} px from the target, which was last seen '
            f'{age:.0f} frames ago; a reflection? It is taken after {PATIENCE_FRAMES} frames'
        )

    def why_another(self, candidate: Candidate) -> str:
        """Say how far a light is from where one like it flashed last; empty within the gate."""
        away = way_from_one_alike(
            self.clock.values, self._tracks, self._counts, candidate.x, candidate.y,
            candidate.height,
        )
        if not self._gate_px < away < math.inf:
            return ''
        return (
            f'what lit up is {away:.0f} px from where a light like it flashed {PERIOD_FRAMES} '
            f'frames ago, and the target goes {self._gate_px:g} px at most (gate): if it is the '
            'same, set more'
        )

    def _is_in_reach(self, target: FlashTrack, age: float, candidate: Candidate) -> bool:
        """Tell whether the target can be this light, by where it was and how bright."""
        if self._counts.item(IS_TARGET):
            reach = reach_of(self._target, self.clock.values, self._expected, self._gate_px)
        else:
            radius = FLANK_SIGMA * target.sigma
            reach = target.x, target.y, radius + self._gate_px * max(age / PERIOD_FRAMES, 1.0)
        return offset_of(self._target, reach, lights_in(rows_of([candidate]))[0]) < math.inf

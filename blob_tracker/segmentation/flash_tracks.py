"""The tracks of all that lights up: which candidates go on with them, and which is followed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from heapq import nlargest
import math

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.crowd import MOST_FLASHES
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_track import (
    FLANK_SIGMA, FlashTrack, MAX_BRIGHTNESS_RATIO, offset_px_of, partners_of, PERIOD_FRAMES, Reach,
)
from blob_tracker.segmentation.frame_clock import FrameClock

MAX_AGE_FRAMES = 8  # frames without a flash after which a track ends
# What is kept of a crowd, the strongest of it, so that its frames take a bounded time. Each of the
# glints of a frame is on a track for 8 frames.
MOST_LIGHTS, MOST_TRACKS = 128, 512
# Flashes of the target after which one that comes a frame late is still it
ESTABLISHED_FLASHES = 3
ROOT_2 = math.sqrt(2.0)


class FlashTracks:
    """
    Carry the tracks on from frame to frame.

    Everything that lights up begins a track. A track goes on where something of like brightness
    lights up two frames later, by the stamps, within the gate; what lights up one or three frames
    later is out of step: a lamp on the mains.

    Parameters
    ----------
    gate_px : float
        Greatest way of a light in the picture from one flash to the next, px.
    clock : FrameClock
        Of the frames that are taken.

    Attributes
    ----------
    locked : FlashTrack or None
        The one that is followed.
    expected : Expectation or None
        Where that is expected in this frame, where somebody tells.

    """

    def __init__(self, gate_px: float, clock: FrameClock) -> None:
        self.locked: FlashTrack | None = None
        self.expected: Expectation | None = None
        self._gate_px = gate_px
        self._clock = clock
        self._tracks: dict[int, FlashTrack] = {}  # by their identity

    def end_old(self) -> None:
        """End those that have not been seen for too long, in this frame."""
        oldest_ns = self._clock.stamp_before(MAX_AGE_FRAMES)
        tracks = self._tracks
        for track in tracks.values():
            if track.stamp_ns < oldest_ns:
                self._tracks = {
                    key: each for key, each in tracks.items() if each.stamp_ns >= oldest_ns
                }
                break
        if self.locked is not None and self.locked.stamp_ns < oldest_ns:
            self.locked = None

    def predicted_position(self, track: FlashTrack) -> tuple[float, float]:
        """Return where a track is expected in this frame, px."""
        if track is self.locked and self.expected is not None:
            return self.expected.x, self.expected.y
        return track.position_at(self._clock.age(track))

    def reach(self, track: FlashTrack) -> Reach:
        """Return where a track may go on in this frame."""
        if track is self.locked and self.expected is not None:
            expected = self.expected
            radius = FLANK_SIGMA * track.sigma + expected.gate_radius_px
            return Reach(track, expected.x, expected.y, radius)
        age = self._clock.age(track)
        x, y = track.position_at(age)
        return Reach(track, x, y, track.gate_radius_px(self._gate_px, age))

    def reaches(self, but: FlashTrack | None = None) -> dict[int, Reach]:
        """Return where the tracks of earlier frames may go on, but for one of them."""
        now_ns = self._clock.stamp_ns
        found = {}
        for key, track in self._tracks.items():
            if track.stamp_ns != now_ns and track is not but:
                found[key] = self.reach(track)
        return found

    def take(
        self,
        everything: Sequence[Candidate],
        reaches: dict[int, Reach],
        is_beside: Callable[[Candidate], object] | None = None,
    ) -> list[tuple[FlashTrack, Candidate]]:
        """
        Return each of the strongest candidates with its track, brought up to date or new.

        A new one is among the tracks from `keep` on. A rejected candidate ends the tracks that it
        is out of step with.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up.
        reaches : dict of int to Reach
            Where tracks may go on, as `reaches` returns them.
        is_beside : callable, optional
            Tells whether a candidate is a light beside the one that is followed, and so is not
            that.

        """
        candidates = []
        for each in everything:
            if not each.rejected:
                candidates.append(each)
            elif reaches:
                self._mark_out_of_step(each, reaches)
        if len(candidates) > MOST_LIGHTS:
            candidates = self._strongest(candidates)
        if not reaches:
            return [(self._new(each), each) for each in candidates]
        beside = set() if is_beside is None else {
            index for index, each in enumerate(candidates) if is_beside(each)
        }
        partners = partners_of(candidates, reaches, beside, id(self.locked))
        return [
            (self._continued(each, partners.get(index)), each)
            for index, each in enumerate(candidates)
        ]

    def keep(self, seen: Iterable[tuple[FlashTrack, Candidate]]) -> None:
        """Keep the tracks of what was seen; forget those that are beyond the number kept."""
        tracks = self._tracks
        for track, _ in seen:
            tracks[id(track)] = track
        if len(tracks) > MOST_TRACKS:
            kept = nlargest(
                MOST_TRACKS, tracks.values(),
                key=lambda each: (each is self.locked, each.flashes, each.height),
            )
            self._tracks = {id(each): each for each in kept}

    def keep_alone(self, *tracks: FlashTrack) -> None:
        """Forget all other tracks."""
        self._tracks = {id(each): each for each in tracks}

    def in_run(self, least: int) -> list[FlashTrack]:
        """Return those in step that flash in this frame, but for the one that is followed."""
        now_ns = self._clock.stamp_ns
        return [
            each for each in self._tracks.values()
            if each is not self.locked
            and each.stamp_ns == now_ns
            and each.run >= least
            and not each.out_of_step
        ]

    def _strongest(self, candidates: list[Candidate]) -> list[Candidate]:
        """Return the highest of a crowd, and what may be the target that is followed."""
        reach = None if self.locked is None else self.reach(self.locked)
        ordered = sorted(candidates, key=lambda each: -each.height)
        return ordered[:MOST_LIGHTS] + [
            each for each in ordered[MOST_LIGHTS:]
            if reach is not None and offset_px_of(reach, each) < math.inf
        ]

    def _new(self, candidate: Candidate) -> FlashTrack:
        """Return the track that begins with a candidate."""
        stamp_ns = self._clock.stamp_ns
        assert stamp_ns is not None
        sigma = math.hypot(candidate.sigma_x, candidate.sigma_y) / ROOT_2
        return FlashTrack(candidate.x, candidate.y, sigma, candidate.height, stamp_ns)

    def _continued(self, candidate: Candidate, nearest: FlashTrack | None) -> FlashTrack:
        """Return a track brought up to date by the candidate that belongs to it; or a new one."""
        new = self._new(candidate)
        if nearest is None:
            return new
        clock = self._clock
        age, unknown = clock.age(nearest), clock.is_phase_unknown(nearest)
        if not clock.in_step(nearest):
            if nearest.flashes >= MOST_FLASHES and age < PERIOD_FRAMES:
                return new  # right after a flash that was expected: something else
            established = nearest.flashes >= ESTABLISHED_FLASHES
            if nearest is self.locked and established and age > PERIOD_FRAMES:
                # It missed its flash and comes a frame late: the light slipped.
                new.trusted = True
                self._replace(nearest, new)
                return new
            new.out_of_step = True
            self._replace(nearest, None)
            return new
        new.velocity_x = (new.x - nearest.x) / age
        new.velocity_y = (new.y - nearest.y) / age
        new.flashes = nearest.flashes + 1
        new.run = 1 if round(age) > PERIOD_FRAMES + unknown else nearest.run + 1
        new.out_of_step = nearest.out_of_step
        new.trusted = nearest.trusted
        self._replace(nearest, new)
        return new

    def _replace(self, track: FlashTrack, by: FlashTrack | None) -> None:
        """End a track; where it was the one that is followed, another is from now on, or none."""
        if track is self.locked:
            self.locked = by
        del self._tracks[id(track)]

    def _mark_out_of_step(self, candidate: Candidate, reaches: dict[int, Reach]) -> None:
        """Mark the young track that is followed, and end all others, where it is out of step."""
        for track, x, y, _ in list(reaches.values()):
            if (
                math.hypot(candidate.x - x, candidate.y - y) < FLANK_SIGMA * (track.sigma + 1.0)
                and track.flashes < MOST_FLASHES
                and not self._clock.in_step(track)
                and track.height < MAX_BRIGHTNESS_RATIO * candidate.height
            ):
                track.out_of_step = True
                if track is not self.locked:
                    self._replace(track, None)
                    del reaches[id(track)]

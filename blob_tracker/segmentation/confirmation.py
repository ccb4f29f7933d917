"""Which of the things that light up flashes in step with the camera: confirmation and lock."""

from __future__ import annotations

from collections.abc import Sequence
from heapq import nlargest
import math

from blob_tracker.segmentation.box import Box, box_about, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.companions import Companion, Companions
from blob_tracker.segmentation.crowd import MOST_FLASHES
from blob_tracker.segmentation.crowded_scene import CrowdedScene
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_track import (
    FLANK_SIGMA, FlashTrack, MAX_BRIGHTNESS_RATIO, offset_px_of, partners_of, PERIOD_FRAMES, Reach,
)
from blob_tracker.segmentation.frame_clock import FrameClock, STAMP_TOLERANCE_FRAMES

MAX_AGE_FRAMES = 8  # frames without a flash after which a track ends
# What is kept of a crowd, the strongest of it, so that its frames take a bounded time. Each of the
# glints of a frame is on a track for 8 frames.
MOST_LIGHTS, MOST_TRACKS = 128, 512
FIRST_PAIRS = 3  # pairs of frames in which a single light is taken for the target at once
REGION_MARGIN_PX = 16  # px about the prediction, and as many sigma as FLANK_SIGMA says
# Flashes of the target after which one that comes a frame late is still it
ESTABLISHED_FLASHES = 3
# Other lights in step are looked for in the whole frame: in the first of so many frames of a lock,
# and from then on in a few frames of as many.
SURVEY_FRAMES, SURVEY_PART = 128, 8
BESIDE_RUN = 3  # flashes that another light has together with the target, before it is known
BRIGHTER_RATIO = 1.25  # times brighter: what a light of the first frames was a reflection of
# Frames without the target (1 s at 60 a second) after which another light in step is taken for it,
# and for which it is remembered from then on.
PATIENCE_FRAMES, MEMORY_FRAMES = 60, 7200
OUT_OF_STEP_FLASHES = 2  # more flashes are asked of a light that was once seen out of step
CERTAIN_FLASHES = MOST_FLASHES + OUT_OF_STEP_FLASHES  # are always enough, also of such a light
SETTLED_FRAMES = 32  # of a lock, after which it is known whether it is in a crowd
FEW_LIGHTS = 8  # in a frame, beyond which it may become a crowd


class Confirmation:
    """
    Confirm the light that is on in every other frame, and follow it.

    Everything that lights up begins a track. A track goes on where something of like brightness
    lights up two frames later, by the stamps, within the gate; what lights up one or three frames
    later is out of step: a lamp on the mains. A track is confirmed after two flashes, and after
    more in a scene in which other things light up so often that chance would confirm them. Where
    they do so all over the frame `Glitter` tells what cannot be chance. The confirmed track is
    followed in a region about its predicted place, which grows with every flash that is missed,
    until the whole frame is searched again.

    Where a tracker tells where it expects the target, the region lies about that place, and what
    lights up there is the target, however it moved. Where nothing does when a flash is due, the
    expectation is as if it had not been, in the same frame.

    Other lights that flash in step, as the target's reflections do, are known by where they are
    from it. In the first two seconds the target is the brightest of them. Where it is hidden none
    of them is taken for it, for a second; and the one that is taken then is left for the target
    once that flashes again.

    Where another view of the scene is told to follow its target at a place, as the other field of
    interlaced pictures does, what lights up elsewhere is not taken, and not followed any more.

    A single light in the first frames, with nothing else, is trusted from its first flash on:
    nothing is known that speaks against it.

    Parameters
    ----------
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.

    Attributes
    ----------
    reason : str
        Why a light that flashes in step was not taken in the last frame; empty where none was.

    """

    def __init__(self, gate_px: float) -> None:
        self.gate_px = gate_px
        self.reason = ''
        self._target: FlashTrack | None = None  # as it was last seen, also when it is lost
        self._companions = Companions()
        self._locked_frames = 0
        self._stands_in = False  # whether another light is followed in place of the target
        self._tracks: dict[int, FlashTrack] = {}  # by their identity
        self._locked: FlashTrack | None = None
        self._expected: Expectation | None = None
        self._agreed: Expectation | None = None
        self._clock = FrameClock()
        self._frames = 0
        self._scene = CrowdedScene(gate_px, self._clock)

    @property
    def locked(self) -> bool:
        """Whether a confirmed light is followed."""
        return self._locked is not None

    @property
    def interval(self) -> float:
        """Return the time from frame to frame, see `FrameClock`."""
        return self._clock.interval

    @property
    def warning(self) -> str:
        """Name the other lights that flash in step with the target."""
        return self._companions.warning

    def push(
        self,
        stamp_ns: int,
        expected: Expectation | None = None,
        shape: tuple[int, int] = (0, 0),
        agreed: Expectation | None = None,
    ) -> None:
        """
        Take the next frame; tracks that are too old end.

        Parameters
        ----------
        stamp_ns : int
            Its stamp, ns.
        expected : Expectation, optional
            Where in it the target is expected, px of the frame. One that is outside, not finite,
            or as wide as the frame is left aside, and any while no target is followed.
        shape : (int, int)
            Height and width of the frame, px.
        agreed : Expectation, optional
            Where another view of the scene follows its target, px of the frame: the same is taken
            here, and none that is elsewhere.

        """
        self._clock.push(stamp_ns)
        self._agreed = agreed
        self._frames += 1
        age = self._clock.age
        ended = [key for key, each in self._tracks.items() if age(each) > MAX_AGE_FRAMES]
        for key in ended:
            del self._tracks[key]
        if self._locked is not None and age(self._locked) > MAX_AGE_FRAMES:
            self._locked = None
        self._locked_frames = self._locked_frames + 1 if self._locked is not None else 0
        if self._target is not None and age(self._target) > MEMORY_FRAMES:
            self._target, self._stands_in = None, False
        self._expected = None
        if expected is not None and self._followed and expected.inside(shape):
            self._expected = expected
            if 2.0 * self._half() > min(shape):
                self._expected = None

    def skip(self, stamp_ns: int) -> None:
        """Take note of a frame that showed the one before it once more, by its stamp, ns."""
        self._clock.skip(stamp_ns)
        self._scene.forget()

    @property
    def _followed(self) -> bool:
        """Whether a target is followed whose motion is known."""
        return self._locked is not None and self._locked.flashes >= 2

    def region(self, shape: tuple[int, int]) -> Box:
        """Return where in a frame of (h, w) the target can be."""
        if not self._followed:
            return whole(shape)
        half = self._half()
        if 2.0 * half > min(shape):
            return whole(shape)
        assert self._locked is not None
        x, y = self._predicted_position(self._locked)
        column = min(max(round(x), 0), shape[1] - 1)
        row = min(max(round(y), 0), shape[0] - 1)
        return box_about(column, row, round(half), round(half), shape)

    def _half(self) -> float:
        """Return half the side of the region about the target that is followed, px."""
        assert self._locked is not None
        if self._expected is not None:
            return REGION_MARGIN_PX + self._reach(self._locked).radius
        age = self._clock.age(self._locked)
        half = REGION_MARGIN_PX + self._locked.gate_radius_px(self.gate_px, PERIOD_FRAMES)
        return half * 2.0 ** max(math.ceil(age / PERIOD_FRAMES - STAMP_TOLERANCE_FRAMES) - 1, 0)

    def widened(self, everything: Sequence[Candidate]) -> bool:
        """
        Give up an expectation that was wrong, before anything is chosen; tell whether it was.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up in the region about it.

        """
        track = self._locked
        if self._expected is None or track is None or self._scene.dense:
            return False
        reach = self._reach(track)
        if not self._clock.is_due(track) or any(
            not each.rejected and offset_px_of(reach, each) < math.inf for each in everything
        ):
            return False
        self._expected = None
        return True

    def choose(
        self, everything: Sequence[Candidate], shape: tuple[int, int]
    ) -> Candidate | None:
        """
        Return the target among the candidates of the frame that was pushed last, or None.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up. Of those that are rejected it only counts that they are out of step.
        shape : (int, int)
            Height and width of the frame, px.

        """
        self.reason = ''
        if self._locked is not None:
            if not everything and not self._scene.dense and self._locked_frames > SETTLED_FRAMES:
                self._scene.add_quiet()  # of most frames that is all
                return None
            if not self._clock.is_due(self._locked):
                size = self.region(shape).size
                self._scene.add_beside(everything, shape, size, self._locked)
            if self._scene.dense:
                return self._picked_out(everything, shape)
        elif not everything:
            self._scene.add_untracked(everything, shape)
            if self._scene.dense:
                return self._picked_out(everything, shape)
        elif self._scene.dense:
            # Each on a track of its own would cost a thousand times as much as it tells.
            self._scene.add_untracked(everything, shape)
            self._tracks = {}
            return self._picked_out(everything, shape)
        if not everything:
            return None
        seen = self._seen(everything, self._reaches())
        if any(track is self._locked and self._elsewhere(each) for track, each in seen):
            self._locked = self._target = None
            self._companions.forget()
        if self._locked is None:
            self._scene.add(seen, shape)
            if self._scene.dense or len(everything) > FEW_LIGHTS:
                found = self._picked_out(everything, shape)
                if self._scene.dense:
                    return found
        if not seen:
            return None
        needed: int | None = None  # not before it is asked for
        best: tuple[FlashTrack, Candidate] | None = None
        alone = self._frames <= FIRST_PAIRS and len(everything) == 1
        due = (
            self._locked is None or not self._followed or self._clock.is_due(self._locked)
        )
        for track, candidate in seen:
            track.trusted = not track.out_of_step and (track.trusted or alone)
            if not track.trusted and track.flashes < CERTAIN_FLASHES:
                needed = self._scene.flashes_needed(shape) if needed is None else needed
                if track.flashes < needed + (OUT_OF_STEP_FLASHES if track.out_of_step else 0):
                    continue
            if track is self._locked:
                best = track, candidate
                break
            if not due or self._elsewhere(candidate) or self._is_waited_for(candidate):
                continue
            if best is None or self._rank(candidate) > self._rank(best[1]):
                best = track, candidate
        self._tracks |= {id(track): track for track, _ in seen}
        if best is not None:
            self._follow(best[0])
            self._scene.forget()
        self._keep_the_best()
        return None if best is None else best[1]

    def _rank(self, candidate: Candidate) -> float:
        """Return what the target has most of: nearness to the place that is agreed, or SNR."""
        if self._agreed is None:
            return candidate.snr
        return -math.hypot(candidate.x - self._agreed.x, candidate.y - self._agreed.y)

    def _elsewhere(self, light: Candidate | FlashTrack) -> bool:
        """Tell whether a light is another one than that which is agreed on."""
        agreed = self._agreed
        return agreed is not None and (
            math.hypot(light.x - agreed.x, light.y - agreed.y) > agreed.gate_radius_px
        )

    def _keep_the_best(self) -> None:
        """Forget the tracks that are beyond the number that is kept."""
        if len(self._tracks) > MOST_TRACKS:
            kept = nlargest(
                MOST_TRACKS,
                self._tracks.values(),
                key=lambda each: (each is self._locked, each.flashes, each.height),
            )
            self._tracks = {id(each): each for each in kept}

    def _picked_out(
        self, everything: Sequence[Candidate], shape: tuple[int, int]
    ) -> Candidate | None:
        """Return the one of a crowd that flashes in step, where chance cannot have made it."""
        locked = self._locked
        found = self._scene.pick(everything, shape, locked, self._expected)
        if found is None:
            if self._scene.dense and everything:
                self.reason = self._scene.why_none(len(everything), followed=locked is not None)
            return None
        index, track = found
        candidate = everything[index]
        if locked is None and self._is_waited_for(candidate):
            return None
        self._scene.follow(index)
        track.sigma = math.hypot(candidate.sigma_x, candidate.sigma_y) / math.sqrt(2.0)
        assert self._clock.stamp_ns is not None
        track.stamp_ns = self._clock.stamp_ns
        if locked is not None:
            self._locked = track
        self._tracks = {id(track): track}
        self._follow(track)
        return candidate

    def _seen(
        self, everything: Sequence[Candidate], reaches: dict[int, Reach]
    ) -> list[tuple[FlashTrack, Candidate]]:
        """
        Return each of the strongest candidates with its track, brought up to date or new.

        A rejected one ends the tracks that it is out of step with.
        """
        candidates = []
        for each in everything:
            if not each.rejected:
                candidates.append(each)
            elif reaches:
                self._mark_out_of_step(each, reaches)
        candidates = self._strongest(candidates)
        companions = {
            index for index, each in enumerate(candidates) if self._companion(each)
        } if self._companions else set()
        partners = partners_of(candidates, reaches, companions, id(self._locked))
        return [
            (self._continued(each, partners.get(index)), each)
            for index, each in enumerate(candidates)
        ]

    def _follow(self, track: FlashTrack) -> None:
        """Follow a track from this frame on; it is the target, or stands in for it."""
        if self._locked is None and self._target is not None:
            gone = self._clock.age(self._target) > MAX_AGE_FRAMES
            if gone and self._companion(track) is not None:
                self._stands_in = True
            elif not self._stands_in and math.hypot(
                track.x - self._target.x, track.y - self._target.y
            ) > 2.0 * self.gate_px:
                self._companions.forget()
        self._locked = track
        if not self._stands_in:
            self._target = track

    def _companion(self, light: Candidate | FlashTrack) -> Companion | None:
        """Return which of the lights that flash beside the target this is; None for none."""
        if self._target is None or self._stands_in:
            return None
        # Where it was, and where its last speed would have it: that is not known to a pixel.
        places = [(self._target.x, self._target.y)]
        if self._target is self._locked:
            places.append(self._predicted_position(self._target))
        for x, y in places:
            found = self._companions.like(light.x - x, light.y - y, light.height, self.gate_px)
            if found is not None:
                return found
        return None

    def _is_waited_for(self, candidate: Candidate) -> bool:
        """Tell whether the target, beside which this light flashes, may still come back."""
        if self._target is None or self._clock.age(self._target) > PATIENCE_FRAMES:
            return False
        companion = self._companion(candidate)
        if companion is not None:
            away = math.hypot(companion.dx, companion.dy)
        elif self._companions and not self._stands_in and not self._is_in_reach(candidate):
            away = math.hypot(candidate.x - self._target.x, candidate.y - self._target.y)
        else:
            return False
        self.reason = (
            f'another light flashes in step, {away:.0f} px from the target, which was last seen '
            f'{self._clock.age(self._target):.0f} frames ago; a reflection? It is '
            f'taken after {PATIENCE_FRAMES} frames'
        )
        return True

    def _is_in_reach(self, candidate: Candidate) -> bool:
        """Tell whether the target can be this light, by where it was and how bright."""
        assert self._target is not None
        if self._target is self._locked:
            reach = self._reach(self._target)
        else:
            radius = FLANK_SIGMA * self._target.sigma
            radius += self.gate_px * max(self._clock.age(self._target) / PERIOD_FRAMES, 1.0)
            reach = Reach(self._target, self._target.x, self._target.y, radius)
        return offset_px_of(reach, candidate) < math.inf

    @property
    def surveys(self) -> bool:
        """Whether the whole of this frame is to be searched for other lights in step."""
        if self._scene.dense or not self._followed:
            return False
        return (
            self._stands_in
            or self._locked_frames < SURVEY_FRAMES // 2
            or self._locked_frames % SURVEY_FRAMES < SURVEY_PART
        )

    def survey(self, everything: Sequence[Candidate], region: Box) -> None:
        """
        Look for other lights that flash in step with the one that is followed.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up in the whole frame.
        region : Box
            The part of it whose lights `choose` had.

        """
        assert self._locked is not None
        reaches = self._reaches()
        reaches.pop(id(self._locked), None)
        new = [
            each for each in everything if each.rejected
            or not (region.x0 <= each.x < region.x1 and region.y0 <= each.y < region.y1)
        ]
        self._tracks |= {id(track): track for track, _ in self._seen(new, reaches)}
        locked = self._locked
        if not self._clock.is_now(locked):
            return  # what lit up in this frame is out of step
        others = [
            each for each in self._tracks.values()
            if each is not locked
            and self._clock.is_now(each)
            and each.run >= BESIDE_RUN
            and not each.out_of_step
        ]
        if not others:
            if self._locked_frames % SURVEY_FRAMES == SURVEY_PART - 1:
                self._companions.forget()
            return
        brightest = max(others, key=lambda each: each.height)
        young = self._stands_in or self._locked_frames < SURVEY_FRAMES
        brighter = brightest.height > BRIGHTER_RATIO * locked.height
        if young and brighter and not self._elsewhere(brightest):
            others = [locked if each is brightest else each for each in others]
            self._locked = self._target = locked = brightest
            self._stands_in = False
        if not self._stands_in:
            self._companions.learn(locked, others)

    def _strongest(self, candidates: list[Candidate]) -> list[Candidate]:
        """Return the highest of a crowd, and what may be the target that is followed."""
        if len(candidates) <= MOST_LIGHTS:
            return candidates
        reach = None if self._locked is None else self._reach(self._locked)
        ordered = sorted(candidates, key=lambda each: -each.height)
        return ordered[:MOST_LIGHTS] + [
            each for each in ordered[MOST_LIGHTS:]
            if reach is not None and offset_px_of(reach, each) < math.inf
        ]

    def _continued(self, candidate: Candidate, nearest: FlashTrack | None) -> FlashTrack:
        """Return a track brought up to date by the candidate that belongs to it; or a new one."""
        assert self._clock.stamp_ns is not None
        sigma = math.hypot(candidate.sigma_x, candidate.sigma_y) / math.sqrt(2.0)
        new = FlashTrack(
            candidate.x, candidate.y, sigma, candidate.height, self._clock.stamp_ns
        )
        if nearest is None:
            return new
        age = self._clock.age(nearest)
        if not self._clock.in_step(nearest):
            if nearest.flashes >= MOST_FLASHES and age < PERIOD_FRAMES:
                return new  # right after a flash that was expected: something else
            established = nearest.flashes >= ESTABLISHED_FLASHES
            if nearest is self._locked and established and age > PERIOD_FRAMES:
                # It missed its flash and comes a frame late: the light slipped.
                new.trusted = True
                self._replace_track(nearest, new)
                return new
            new.out_of_step = True
            self._replace_track(nearest, None)
            return new
        new.velocity_x = (candidate.x - nearest.x) / age
        new.velocity_y = (candidate.y - nearest.y) / age
        new.flashes = nearest.flashes + 1
        missed = round(age) > PERIOD_FRAMES + self._clock.is_phase_unknown(nearest)
        new.run = 1 if missed else nearest.run + 1
        new.out_of_step = nearest.out_of_step
        new.trusted = nearest.trusted
        self._replace_track(nearest, new)
        return new

    def _predicted_position(self, track: FlashTrack) -> tuple[float, float]:
        """Return where a track is expected in this frame, px."""
        if track is self._locked and self._expected is not None:
            return self._expected.x, self._expected.y
        return track.position_at(self._clock.age(track))

    def _reach(self, track: FlashTrack) -> Reach:
        """Return where a track may go on in this frame."""
        if track is self._locked and self._expected is not None:
            expected = self._expected
            radius = FLANK_SIGMA * track.sigma + expected.gate_radius_px
            return Reach(track, expected.x, expected.y, radius)
        age = self._clock.age(track)
        x, y = track.position_at(age)
        return Reach(track, x, y, track.gate_radius_px(self.gate_px, age))

    def _reaches(self) -> dict[int, Reach]:
        """Return where the tracks of earlier frames may go on."""
        return {
            key: self._reach(each) for key, each in self._tracks.items()
            if not self._clock.is_now(each)
        }

    def _replace_track(self, track: FlashTrack, by: FlashTrack | None) -> None:
        """End a track; where it was the one that is followed, another is from now on, or none."""
        if track is self._locked:
            self._locked = by
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
                if track is not self._locked:
                    self._replace_track(track, None)
                    del reaches[id(track)]

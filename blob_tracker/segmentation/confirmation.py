"""Which of the things that light up flashes in step with the camera: confirmation and lock."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.segmentation.box import Box, box_about, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.crowd import MOST_FLASHES
from blob_tracker.segmentation.crowded_scene import CrowdedScene
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_track import FlashTrack, offset_px_of, PERIOD_FRAMES
from blob_tracker.segmentation.flash_tracks import FlashTracks, ROOT_2
from blob_tracker.segmentation.frame_clock import FrameClock, STAMP_TOLERANCE_FRAMES
from blob_tracker.segmentation.target_memory import TargetMemory

FIRST_PAIRS = 3  # pairs of frames in which a single light is taken for the target at once
REGION_MARGIN_PX = 16  # px about the prediction, and as many sigma as FLANK_SIGMA says
# Other lights in step are looked for in the whole frame: in the first of so many frames of a lock,
# and from then on in a few frames of as many.
SURVEY_FRAMES, SURVEY_PART = 128, 8
BESIDE_RUN = 3  # flashes that another light has together with the target, before it is known
BRIGHTER_RATIO = 1.25  # times brighter: what a light of the first frames was a reflection of
OUT_OF_STEP_FLASHES = 2  # more flashes are asked of a light that was once seen out of step
CERTAIN_FLASHES = MOST_FLASHES + OUT_OF_STEP_FLASHES  # are always enough, also of such a light
SETTLED_FRAMES = 32  # of a lock, after which it is known whether it is in a crowd
FEW_LIGHTS = 8  # in a frame, beyond which it may become a crowd


class Confirmation:
    """
    Confirm the light that is on in every other frame, and follow it.

    A track, see `FlashTracks`, is confirmed after two flashes, and after more in a scene in which
    other things light up so often that chance would confirm them. Where they do so all over the
    frame `Glitter` tells what cannot be chance. The confirmed track is followed in a region about
    its predicted place, which grows with every flash that is missed, until the whole frame is
    searched again.

    Where a tracker tells where it expects the target, the region lies about that place, and what
    lights up there is the target, however it moved. Where nothing does when a flash is due, the
    expectation is as if it had not been, in the same frame.

    Other lights that flash in step are known, see `TargetMemory`. In the first two seconds the
    target is the brightest of them.

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
        self._clock = FrameClock()
        self._tracks = FlashTracks(gate_px, self._clock)
        self._memory = TargetMemory(gate_px, self._clock, self._tracks)
        self._scene = CrowdedScene(gate_px, self._clock)
        self._agreed: Expectation | None = None
        self._frames = 0
        self._locked_frames = 0

    @property
    def locked(self) -> bool:
        """Whether a confirmed light is followed."""
        return self._tracks.locked is not None

    @property
    def interval(self) -> float:
        """Return the time from frame to frame, see `FrameClock`."""
        return self._clock.interval

    @property
    def warning(self) -> str:
        """Name the other lights that flash in step with the target."""
        return self._memory.companions.warning

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
        tracks = self._tracks
        self._clock.push(stamp_ns)
        self._agreed = agreed
        self._frames += 1
        tracks.end_old()
        self._locked_frames = self._locked_frames + 1 if tracks.locked is not None else 0
        self._memory.end_old()
        tracks.expected = None
        followed = self._followed
        if expected is not None and followed is not None and expected.inside(shape):
            tracks.expected = expected
            if 2.0 * self._half(followed) > min(shape):
                tracks.expected = None

    def skip(self, stamp_ns: int) -> None:
        """Take note of a frame that showed the one before it once more, by its stamp, ns."""
        self._clock.skip(stamp_ns)
        self._scene.forget()

    @property
    def _followed(self) -> FlashTrack | None:
        """Return the target that is followed, where its motion is known."""
        locked = self._tracks.locked
        return None if locked is None or locked.flashes < 2 else locked

    def region(self, shape: tuple[int, int]) -> Box:
        """Return where in a frame of (h, w) the target can be."""
        track = self._followed
        if track is None:
            return whole(shape)
        half = self._half(track)
        height, width = shape
        if 2.0 * half > height or 2.0 * half > width:
            return whole(shape)
        x, y = self._tracks.predicted_position(track)
        column = min(max(round(x), 0), width - 1)
        row = min(max(round(y), 0), height - 1)
        side = round(half)
        return box_about(column, row, side, side, shape)

    def _half(self, track: FlashTrack) -> float:
        """Return half the side of the region about the target that is followed, px."""
        if self._tracks.expected is not None:
            return REGION_MARGIN_PX + self._tracks.reach(track).radius
        half = REGION_MARGIN_PX + track.gate_radius_px(self.gate_px, PERIOD_FRAMES)
        missed = math.ceil(self._clock.age(track) / PERIOD_FRAMES - STAMP_TOLERANCE_FRAMES) - 1
        return half if missed <= 0 else half * 2.0**missed

    def widened(self, everything: Sequence[Candidate]) -> bool:
        """
        Give up an expectation that was wrong, before anything is chosen; tell whether it was.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up in the region about it.

        """
        tracks = self._tracks
        track = tracks.locked
        if tracks.expected is None or track is None or self._scene.dense:
            return False
        reach = tracks.reach(track)
        if not self._clock.is_due(track) or any(
            not each.rejected and offset_px_of(reach, each) < math.inf for each in everything
        ):
            return False
        tracks.expected = None
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
        tracks, scene = self._tracks, self._scene
        locked = tracks.locked
        if locked is not None:
            if not everything and not scene.dense and self._locked_frames > SETTLED_FRAMES:
                scene.add_quiet()  # of most frames that is all
                return None
            if not self._clock.is_due(locked):
                scene.add_beside(everything, shape, self.region(shape).size, locked)
        elif scene.dense or not everything:
            scene.add_untracked(everything, shape)
            if everything:
                # Each on a track of its own would cost a thousand times as much as it tells.
                tracks.keep_alone()
                return self._picked_out(everything, shape)
        if scene.dense:
            return self._picked_out(everything, shape)
        if not everything:
            return None
        memory = self._memory
        seen = tracks.take(
            everything, tracks.reaches(), memory.beside if memory.companions else None
        )
        if self._agreed is not None and any(
            track is tracks.locked and self._elsewhere(each) for track, each in seen
        ):
            tracks.locked = None
            memory.forget()
        if tracks.locked is None:
            scene.add(seen, shape)
            if scene.dense or len(everything) > FEW_LIGHTS:
                found = self._picked_out(everything, shape)
                if scene.dense:
                    return found
        if not seen:
            return None
        best = self._best_of(seen, shape, alone=len(everything) == 1)
        tracks.keep(seen)
        if best is None:
            return None
        memory.follow(best[0])
        scene.forget()
        return best[1]

    def _best_of(
        self, seen: Sequence[tuple[FlashTrack, Candidate]], shape: tuple[int, int], *, alone: bool
    ) -> tuple[FlashTrack, Candidate] | None:
        """Return the target among the lights of a frame, where one has flashed often enough."""
        locked, followed = self._tracks.locked, self._followed
        due = followed is None or self._clock.is_due(followed)
        alone = alone and self._frames <= FIRST_PAIRS
        needed = 0  # not before it is asked for
        best: tuple[FlashTrack, Candidate] | None = None
        for track, candidate in seen:
            track.trusted = not track.out_of_step and (track.trusted or alone)
            if not track.trusted and track.flashes < CERTAIN_FLASHES:
                needed = needed or self._scene.flashes_needed(shape)
                if track.flashes < needed + (OUT_OF_STEP_FLASHES if track.out_of_step else 0):
                    continue
            if track is locked:
                return track, candidate
            if not due or self._elsewhere(candidate):
                continue
            why = self._memory.why_to_wait(candidate)
            if why:
                self.reason = why
            elif best is None or self._rank(candidate) > self._rank(best[1]):
                best = track, candidate
        return best

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

    def _picked_out(
        self, everything: Sequence[Candidate], shape: tuple[int, int]
    ) -> Candidate | None:
        """Return the one of a crowd that flashes in step, where chance cannot have made it."""
        tracks, scene = self._tracks, self._scene
        locked = tracks.locked
        found = scene.pick(everything, shape, locked, tracks.expected)
        if found is None:
            if scene.dense and everything:
                self.reason = scene.why_none(len(everything), followed=locked is not None)
            return None
        index, track = found
        candidate = everything[index]
        if locked is None:
            self.reason = self._memory.why_to_wait(candidate)
            if self.reason:
                return None
        scene.follow(index)
        track.sigma = math.hypot(candidate.sigma_x, candidate.sigma_y) / ROOT_2
        assert self._clock.stamp_ns is not None
        track.stamp_ns = self._clock.stamp_ns
        if locked is not None:
            tracks.locked = track
        tracks.keep_alone(track)
        self._memory.follow(track)
        return candidate

    @property
    def surveys(self) -> bool:
        """Whether the whole of this frame is to be searched for other lights in step."""
        if self._scene.dense or self._followed is None:
            return False
        frames = self._locked_frames
        return (
            frames < SURVEY_FRAMES // 2
            or frames % SURVEY_FRAMES < SURVEY_PART
            or self._memory.stands_in
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
        tracks, memory = self._tracks, self._memory
        locked = tracks.locked
        assert locked is not None
        new = [
            each for each in everything if each.rejected
            or not (region.x0 <= each.x < region.x1 and region.y0 <= each.y < region.y1)
        ]
        tracks.keep(tracks.take(new, tracks.reaches(but=locked)))
        if not self._clock.is_now(locked):
            return  # what lit up in this frame is out of step
        others = tracks.in_run(BESIDE_RUN)
        if not others:
            if self._locked_frames % SURVEY_FRAMES == SURVEY_PART - 1:
                memory.companions.forget()
            return
        brightest = max(others, key=lambda each: each.height)
        young = memory.stands_in or self._locked_frames < SURVEY_FRAMES
        brighter = brightest.height > BRIGHTER_RATIO * locked.height
        if young and brighter and not self._elsewhere(brightest):
            others = [locked if each is brightest else each for each in others]
            memory.exchange(brightest)
        memory.learn(others)

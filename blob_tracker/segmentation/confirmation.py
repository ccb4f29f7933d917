"""Which of the things that light up flashes in step with the camera: confirmation and lock."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.kernel import Array
from blob_tracker.segmentation.at_once import (
    Asked, is_survey, SETTLED_FRAMES, Shown, SURVEY_FRAMES, SURVEY_PART, Watched,
)
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.crowded_scene import CrowdedScene
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_memory import FlashMemory
from blob_tracker.segmentation.flash_track import FlashTrack, ROOT_2
from blob_tracker.segmentation.flash_tracks import CONFIRMED, DENSE, FEW_LIGHTS, LIGHT, TOLD
from blob_tracker.types import Pixels
import numpy as np

FIRST_PAIRS = 3  # pairs of frames in which a single light is taken for the target at once
BESIDE_RUN = 3  # flashes that another light has together with the target, before it is known
BRIGHTER_RATIO = 1.25  # times brighter: what the light that is followed is a reflection of


class Confirmation:
    """
    Confirm the light that is on in every other frame, and follow it.

    A track, see `flash_tracks.take`, is confirmed after two flashes, and after more in a scene in
    which other things light up so often that chance would confirm them. Where they do so all over
    the frame `Glitter` tells what cannot be chance. The confirmed track is followed in a region
    about its predicted place, which grows with every flash that is missed, until the whole frame
    is searched again.

    Where a tracker tells where it expects the target, the region lies about that place, and what
    lights up there is the target, however it moved. Where nothing does when a flash is due, the
    expectation is as if it had not been, in the same frame.

    Nor does a light go straight on for ever. Where nothing lights up where its speed would have it
    when a flash is due, and hardly anything does by chance, it is looked for about its last place
    as well, as far as the gate, in the same frame: it has turned.

    Other lights that flash in step are known, see `FlashMemory`. In the first two seconds the
    target is the brightest of them; later, a brighter one that was there for as long.

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
        Why a light that flashes in step was not taken in the last frame; empty if none was.

    """

    def __init__(self, gate_px: float) -> None:
        self.gate_px = gate_px
        self.reason = ''
        self._memory = FlashMemory(gate_px)
        self._scene = CrowdedScene(gate_px, self._memory.clock)
        self._agreed: Expectation | None = None
        self._outshone: int | None = None  # the frame since which another light is brighter
        self._turned = False  # whether it is looked for in this frame as one that has turned
        self._frames = 0

    @property
    def locked(self) -> bool:
        """Whether a confirmed light is followed."""
        return self._memory.locked

    @property
    def interval(self) -> float:
        """Return the time from frame to frame, see `FrameClock`."""
        return self._memory.clock.interval

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
        memory = self._memory
        memory.next_frame(stamp_ns)
        self._agreed, self._turned = agreed, False
        self._frames += 1
        if expected is not None and memory.moves and expected.inside(shape):
            memory.expect(expected)
            if 2.0 * memory.half_side() > min(shape):
                memory.expect(None)

    def at_once(
        self, stamp_ns: int, lit: Pixels, unlit: Pixels, asked: Asked, saturation: int,
        watched: Watched,
    ) -> Shown | None:
        """Take a frame where nothing is odd about it, see `FlashMemory.at_once`."""
        scene = self._scene
        if scene.dense or scene.watches:
            return None
        found = self._memory.at_once(
            stamp_ns, lit, unlit, asked, saturation, scene.crowd.values, watched,
            alone=self._frames < FIRST_PAIRS,
        )
        if found is not None:
            self._agreed, self._turned, self.reason = None, False, ''
            self._frames += 1
            if watched.since > 0.0 and not found.shown:
                scene.add_quiet()
        return found

    def skip(self, stamp_ns: int) -> None:
        """Take note of a frame that showed the one before it once more, by its stamp, ns."""
        self._memory.clock.skip(stamp_ns)
        self._scene.forget()

    def region(self, shape: tuple[int, int]) -> Box:
        """Return where in a frame of (h, w) the target can be."""
        return self._memory.region(shape)

    def widened(self, everything: Sequence[Candidate], shape: tuple[int, int]) -> bool:
        """
        Look elsewhere for a light that is due, before anything is chosen; tell whether to.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up in the region about it.
        shape : (int, int)
            Height and width of the frame, px.

        """
        memory = self._memory
        if not memory.is_due or self._turned or self._scene.dense or not memory.moves:
            return False
        if not memory.is_missed(everything):
            return False
        if memory.expected is not None:
            memory.expect(None)
            return True
        self._turned = self._scene.crowd.is_quiet(shape)
        if self._turned:
            memory.expect_turned()
        return self._turned

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
        memory, scene = self._memory, self._scene
        locked = memory.locked
        if locked:
            if not everything and not scene.dense and memory.locked_frames > SETTLED_FRAMES:
                scene.add_quiet()  # of most frames that is all
                return None
            if not memory.is_due:
                assert memory.followed is not None
                scene.add_beside(everything, shape, self.region(shape).size, memory.followed)
        elif scene.dense or not everything:
            scene.add_untracked(everything, shape)
            if everything:
                # Each on a track of its own would cost a thousand times as much as it tells.
                memory.keep_alone(None)
                return self._picked_out(everything, shape)
        if scene.dense:
            return self._picked_out(everything, shape)
        if not everything:
            return None
        alone = self._frames <= FIRST_PAIRS and len(everything) == 1
        seen, best, left = memory.see(
            everything, scene.crowd.values, shape, alone=alone, agreed=self._agreed is not None
        )
        if left != TOLD:
            return self._told(everything, shape, seen, left, alone=alone)
        if best < 0:
            return None
        scene.forget()
        return everything[int(seen[best, LIGHT])]

    def _told(
        self, everything: Sequence[Candidate], shape: tuple[int, int], seen: Array, left: int, *,
        alone: bool,
    ) -> Candidate | None:
        """Return the target where the place, other lights or a crowd have a say in it."""
        memory, scene = self._memory, self._scene
        if self._agreed is not None:
            followed, _ = memory.among(seen)
            if followed >= 0 and self._elsewhere(everything[int(seen[followed, LIGHT])]):
                memory.lose()
            left = memory.confirm(seen, scene.crowd.values, shape, alone=alone)
        if not memory.locked:
            scene.dense = left == DENSE
            if scene.dense or len(everything) > FEW_LIGHTS:
                found = self._picked_out(everything, shape)
                if scene.dense:
                    return found
        best = self._best_of(seen, everything)
        memory.keep(seen, best)
        if best < 0:
            return None
        scene.forget()
        return everything[int(seen[best, LIGHT])]

    def _best_of(self, seen: Array, everything: Sequence[Candidate]) -> int:
        """Return which of the lights that are confirmed is the target; -1 for none."""
        followed, is_open = self._memory.among(seen)
        best, best_light = -1, None
        for s in np.flatnonzero(seen[:, CONFIRMED]).tolist():
            if s == followed:
                return s
            candidate = everything[int(seen[s, LIGHT])]
            if not is_open or self._elsewhere(candidate):
                continue
            why = self._memory.why_to_wait(candidate)
            if why:
                self.reason = why
            elif best_light is None or self._rank(candidate) > self._rank(best_light):
                best, best_light = s, candidate
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
        memory, scene = self._memory, self._scene
        locked = memory.followed
        found = scene.pick(everything, shape, locked, memory.expected)
        if found is None:
            if scene.dense and everything:
                self.reason = scene.why_none(len(everything), followed=locked is not None)
            return None
        index, track = found
        candidate = everything[index]
        if locked is None:
            self.reason = memory.why_to_wait(candidate)
            if self.reason:
                return None
        scene.follow(index)
        sigma = math.hypot(candidate.sigma_x, candidate.sigma_y) / ROOT_2
        memory.keep_alone(track._replace(sigma=sigma, stamp=memory.clock.stamp))
        return candidate

    def why_another(self, candidate: Candidate) -> str:
        """Say why a light that was not taken is not the one that flashed last, if that is told."""
        return '' if self._scene.dense else self._memory.why_another(candidate)

    @property
    def surveys(self) -> bool:
        """Whether the whole of this frame is to be searched for other lights in step."""
        memory = self._memory
        if self._scene.dense or not memory.moves:
            return False
        return memory.stands_in or is_survey(memory.locked_frames)

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
        memory = self._memory
        memory.survey([
            each for each in everything if each.rejected
            or not (region.x0 <= each.x < region.x1 and region.y0 <= each.y < region.y1)
        ])
        if not memory.is_seen:
            return  # what lit up in this frame is out of step
        others = memory.in_run(BESIDE_RUN)
        frames = memory.locked_frames
        if not others:
            if frames % SURVEY_FRAMES == SURVEY_PART - 1:
                memory.companions.forget()
                self._outshone = None
            return
        locked = memory.followed
        assert locked is not None
        brightest = max(others, key=lambda each: each.height)
        brighter = brightest.height > BRIGHTER_RATIO * locked.height
        if not brighter:
            self._outshone = None
        elif self._outshone is None:
            self._outshone = self._frames
        lasts = self._outshone is not None and self._frames - self._outshone >= SURVEY_FRAMES
        young = memory.stands_in or frames < SURVEY_FRAMES
        if (young or lasts) and brighter and not self._elsewhere(brightest):
            self._outshone = None
            others = [locked if each is brightest else each for each in others]
            memory.exchange(brightest)
        memory.learn(others)

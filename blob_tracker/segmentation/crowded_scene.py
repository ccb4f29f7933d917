"""A scene that may be full of glints: whether it is, and which of them flashes in step."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.crowd import Crowd, KNOWN_RUN, MOST_FLASHES
from blob_tracker.segmentation.expectation import Expectation, GATE_SIGMA
from blob_tracker.segmentation.flash_track import FLASHES, FlashTrack, OUT_OF_STEP, RUN, SIGMA
from blob_tracker.segmentation.frame_clock import age_of, FrameClock
from blob_tracker.segmentation.glitter import bound, Glitter


class CrowdedScene:
    """
    Count what lights up, and pick the light in step where tracks would follow chance.

    Parameters
    ----------
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.
    clock : FrameClock
        Of the frames that are taken.

    Attributes
    ----------
    dense : bool
        Whether things light up all over the frame.

    """

    def __init__(self, gate_px: float, clock: FrameClock) -> None:
        self.dense = False
        self._clock = clock
        self._crowd = Crowd(gate_px)
        self._glitter = Glitter(gate_px)
        self._quiet_frames = 0  # between two flashes of the target, that are not counted yet

    def add_quiet(self) -> None:
        """Take a frame between two flashes of the target in which nothing lit up about it."""
        self._quiet_frames += 1

    def add_untracked(self, everything: Sequence[Candidate], shape: tuple[int, int]) -> None:
        """Take what lit up in a whole frame of (h, w) and is on no track."""
        count = sum(not each.rejected for each in everything)
        self._crowd.add(self._clock.frame, count, count)
        if everything:
            self._judge(_widest(everything), shape)

    def add(self, seen: Array, shape: tuple[int, int]) -> None:
        """Take what lit up in a whole frame of (h, w), a track of `FlashTrack` a row."""
        new, passing, sigma = _counted(seen)
        self._crowd.add(self._clock.frame, new, passing)
        self._judge(sigma, shape)

    def _judge(self, sigma: float, shape: tuple[int, int]) -> None:
        """Tell whether the scene is dense, by the widest light of a whole frame of (h, w)."""
        self.dense = self._crowd.is_crowd and self._crowd.is_dense(shape, sigma)

    def add_beside(
        self, everything: Sequence[Candidate], shape: tuple[int, int], size: int,
        target: FlashTrack,
    ) -> None:
        """
        Take what lights up about the target between two of its flashes.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up.
        shape : (int, int)
            Height and width of the frame, px.
        size : int
            Pixels of the region that was searched.
        target : FlashTrack
            Whose flash is not due.

        """
        count = sum(not each.rejected for each in everything)
        part = shape[0] * shape[1] / max(size, 1) if count > 0 else 1.0
        self._crowd.add_part(count * part, self._quiet_frames)
        self._quiet_frames = 0
        before = self.dense
        # Until then what lights up between its flashes may be the light itself, out of step.
        known = target.flashes >= MOST_FLASHES
        self.dense = known and self._crowd.is_beside(shape, target.sigma)
        if before and not self.dense:
            self.forget()

    def flashes_needed(self, shape: tuple[int, int]) -> int:
        """Return after how many flashes chance cannot have made a track in a frame of (h, w)."""
        return self._crowd.flashes_needed(shape)

    def pick(
        self,
        everything: Sequence[Candidate],
        shape: tuple[int, int],
        target: FlashTrack | None,
        expected: Expectation | None,
    ) -> tuple[int, FlashTrack] | None:
        """
        Return which light flashes in step where chance cannot have made it, and its track.

        Parameters
        ----------
        everything : sequence of Candidate
            What lit up.
        shape : (int, int)
            Height and width of the frame, px.
        target : FlashTrack or None
            That is followed.
        expected : Expectation or None
            Where it is expected.

        """
        clock, glitter, least = self._clock, self._glitter, bound(self._crowd.passing)
        if target is not None:
            if glitter.empty:
                glitter.begin_with(target, clock.frame - round(age_of(clock.values, target.stamp)), least)
            if expected is not None:
                variance = (expected.gate_radius_px / GATE_SIGMA) ** 2
                glitter.expect(clock.frame, expected.x, expected.y, variance)
        followed = target is not None
        glitter.look(
            everything, clock.frame, shape, followed=followed,
            density=self._crowd.passing / (shape[0] * shape[1]),
        )
        # Until it is a crowd it is only watched.
        return glitter.best(clock.frame, least, followed=followed) if self.dense else None

    def follow(self, index: int) -> None:
        """Follow the light that was picked, of that index, from this frame on."""
        self._glitter.follow(self._clock.frame, index, bound(self._crowd.passing))

    def forget(self) -> None:
        """Forget the lights that are watched."""
        if not self._glitter.empty:
            self._glitter.forget()

    def why_none(self, count: int, *, followed: bool) -> str:
        """Say why none of so many lights was picked."""
        if followed:
            return (
                f'{count} lit up about the target among glints, and none of them that must be it '
                'rather than one of these'
            )
        return (
            f'{self._crowd.passing:.0f} things light up at random in each frame, glints or lamps, '
            'and none that must be the light in step yet: it takes about ten flashes; shade or '
            'cover what glitters, lower the exposure, or set mask_url'
        )


def _widest(lights: Sequence[Candidate]) -> float:
    """Return the greatest sigma of those that are not rejected, px."""
    return max(
        (math.hypot(each.sigma_x, each.sigma_y) for each in lights if not each.rejected),
        default=0.0,
    ) / math.sqrt(2.0)


@kernel
def _counted(seen: Array) -> tuple[int, int, float]:
    """Return how many lights are new, how many pass, and the greatest sigma, px."""
    new, passing, sigma = 0, 0, 0.0
    for s in range(seen.shape[0]):
        new += seen[s, FLASHES] == 1.0 and seen[s, OUT_OF_STEP] == 0.0
        passing += seen[s, RUN] < KNOWN_RUN
        sigma = max(sigma, seen[s, SIGMA])
    return new, passing, sigma

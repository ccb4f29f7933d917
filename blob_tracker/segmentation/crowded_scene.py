"""A scene that may be full of glints: whether it is, and which of them flashes in step."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.crowd import Crowd, MOST_FLASHES
from blob_tracker.segmentation.expectation import Expectation, GATE_SIGMA
from blob_tracker.segmentation.flash_track import FlashTrack
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
    crowd : Crowd
        How much lights up by chance.

    """

    def __init__(self, gate_px: float, clock: FrameClock) -> None:
        self.dense = False
        self._clock = clock
        self.crowd = Crowd(gate_px)
        self._glitter = Glitter(gate_px)
        self._quiet_frames = 0  # between two flashes of the target, that are not counted yet

    @property
    def watches(self) -> bool:
        """Whether lights of a crowd are watched."""
        return not self._glitter.empty

    def add_quiet(self) -> None:
        """Take a frame between two flashes of the target in which nothing lit up about it."""
        self._quiet_frames += 1

    def add_untracked(self, everything: Sequence[Candidate], shape: tuple[int, int]) -> None:
        """Take what lit up in a whole frame of (h, w) and is on no track."""
        count = sum(not each.rejected for each in everything)
        self.crowd.add(self._clock.frame, count)
        if everything:
            self.dense = self.crowd.is_dense(shape, _widest(everything))

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
        self.crowd.add_part(count * part, self._quiet_frames)
        self._quiet_frames = 0
        before = self.dense
        # Until then what lights up between its flashes may be the light itself, out of step.
        known = target.flashes >= MOST_FLASHES
        self.dense = known and self.crowd.is_beside(shape, target.sigma)
        if before and not self.dense:
            self.forget()

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
        clock, glitter, least = self._clock, self._glitter, bound(self.crowd.passing)
        if target is not None:
            if glitter.empty:
                age = round(age_of(clock.values, target.stamp))
                glitter.begin_with(target, clock.frame - age, least)
            if expected is not None:
                variance = (expected.gate_radius_px / GATE_SIGMA) ** 2
                glitter.expect(clock.frame, expected.x, expected.y, variance)
        followed = target is not None
        glitter.look(
            everything, clock.frame, shape, followed=followed,
            density=self.crowd.passing / (shape[0] * shape[1]),
        )
        # Until it is a crowd it is only watched.
        return glitter.best(clock.frame, least, followed=followed) if self.dense else None

    def follow(self, index: int) -> None:
        """Follow the light that was picked, of that index, from this frame on."""
        self._glitter.follow(self._clock.frame, index, bound(self.crowd.passing))

    def forget(self) -> None:
        """Forget the lights that are watched."""
        if self.watches:
            self._glitter.forget()

    def why_none(self, count: int, *, followed: bool) -> str:
        """Say why none of so many lights was picked."""
        if followed:
            return (
                f'{count} lit up about the target among glints, and none of them that must be it '
                'rather than one of these'
            )
        return (
            f'{self.crowd.passing:.0f} things light up at random in each frame, glints or lamps, '
            'and none that must be the light in step yet: it takes about ten flashes; shade or '
            'cover what glitters, lower the exposure, or set mask_url'
        )


def _widest(lights: Sequence[Candidate]) -> float:
    """Return the greatest sigma of those that are not rejected, px."""
    return max(
        (math.hypot(each.sigma_x, each.sigma_y) for each in lights if not each.rejected),
        default=0.0,
    ) / math.sqrt(2.0)

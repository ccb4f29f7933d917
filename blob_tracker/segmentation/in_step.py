"""A light in step with the camera, or nearly so: its own clock may drift."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.segmentation.at_once import Asked, Shown, Watched
from blob_tracker.segmentation.blink import (
    compile_blinking, HalfRate, most_drawn, WAY_FRACTION,
)
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.drift import light_at
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_watch import exposure_of, FlashWatch, Seen
from blob_tracker.segmentation.frame_clock import PERIOD_FRAMES
from blob_tracker.segmentation.history import FrameError
from blob_tracker.segmentation.switching import Switching
from blob_tracker.types import Frame, Glimpse
import numpy as np

SIGMA_Y = Candidate._fields.index('sigma_y')
PATIENCE_FRAMES = 90  # without the light, after which it is looked for in pairs again
ROUND_WAY_PX = 0.3  # px, by which the way in an exposure may be off, by the two last places
# px in half an exposure, from which on it is not enough to know the light in step, and the part of
# a resting one in the unlit frame, some time ahead, from which on there is too little contrast.
MOVING_PX, TOO_EVEN, AHEAD_S = 0.1, 0.45, 0.25
SPEED_MEMORY = 0.2  # of the mean speed that a flash renews
OUT_OF_SIGHT_S = 0.5  # s from one flash to the next, after which it may be another light


class _Flash(NamedTuple):
    """Where the light was in its last flash, px, and when."""

    x: float
    y: float
    stamp_ns: int


NO_FLASH = _Flash(0.0, 0.0, -10**18)  # ns: out of sight of any frame


class InStep(Switching):
    """
    Follow a light that is on in every other frame, by pairs, until it shows to run free.

    A light near half the frame rate that is not wired to the camera goes over from the one frame
    of a pair to the other: it is seen in the middle of a part of the exposure, and about half way
    the pair has no contrast. From when `FlashWatch` sees it, the light is followed as one that
    blinks, each frame by itself.

    Parameters
    ----------
    max_pair_interval, registration, gate_px
        Those of `Alternate`. With a registration the light is followed by pairs alone.
    exposure : float
        Of a frame, s; 0 where the frames tell.

    """

    def __init__(
        self,
        *,
        max_pair_interval: float = 0.0,
        registration: str = 'none',
        gate_px: float = 24.0,
        exposure: float = 0.0,
    ) -> None:
        self._max_interval, self._registration = max_pair_interval, registration
        self._exposure = exposure
        self.gate_px = gate_px
        self._pairs = self._new_pairs()
        super().__init__(self._pairs)
        self._last: _Flash | None = None
        self._watch = FlashWatch()
        self._vx = self._vy = 0.0  # px/s, of the last flashes
        self._missed = 0  # frames since the light was seen
        self._taken_up = False  # whether it has been seen since it is known to run free
        compile_blinking()  # or it would be waited for in the midst of tracking

    def _begin(self, x: float, y: float, stamp_ns: int) -> None:
        """Watch a light of which nothing is known but where its flash is, px, and its stamp."""
        self._last = _Flash(x, y, stamp_ns)
        self._watch.forget()
        self._vx = self._vy = 0.0

    def _new_pairs(self) -> Alternate:
        return Alternate(
            max_pair_interval=self._max_interval, registration=self._registration,
            gate_px=self.gate_px,
        )

    @property
    def reason(self) -> str:
        """Why the last frame gave no light."""
        return self._mode.reason

    @property
    def finding(self) -> str:
        """Say that the light runs free, where it does."""
        return '' if self._mode is self._pairs else (
            'it flashes near half the frame rate by its own clock: every frame is searched by '
            'itself'
        )

    def agree_with(self, place: Expectation | None) -> None:
        """Say where another view follows the target, for the next frame: see `Confirmation`."""
        self._pairs.agree_with(place)

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Return the next frame and what it is compared with.

        Raises
        ------
        FrameError
            If the frame cannot follow those before it.

        """
        if self._mode is not self._pairs and self._missed > PATIENCE_FRAMES:
            self._mode = self._pairs = self._new_pairs()
            self._last = None
        self._missed += 1
        try:
            return self._mode.contrast(frame, expected)
        except FrameError:
            self._last = None
            raise

    def at_once(
        self, frame: Frame, before: Frame, asked: Asked
    ) -> tuple[Shown, Glimpse | None] | None:
        """
        Take the next frame where pairs are compared and nothing is odd about them.

        Parameters
        ----------
        frame, before : Frame
            The next frame, grey, and the one before it.
        asked : Asked
            What is asked of the light.

        Returns
        -------
        (Shown, Glimpse or None) or None
            What it shows, and what is not known of its instant. None where it takes more to tell:
            nothing is changed then.

        """
        last = self._last or NO_FLASH
        since = (frame.stamp_ns - last.stamp_ns) / 1e9
        followed = 0.0 < since < OUT_OF_SIGHT_S
        if self._mode is not self._pairs or self._pairs.locked != followed:
            return None
        found = self._pairs.at_once(frame, before, asked, Watched(
            self._watch.memory, (last.x, last.y), since if followed else 0.0,
            self._told_exposure(frame),
        ))
        if found is None:
            return None
        self._missed += 1
        if not found.shown:
            return found, None
        self._missed = 0
        if not followed:
            self._begin(*found.seen[:2], frame.stamp_ns)
            return found, None
        return found, self._heed(
            self._watch.taken(*found.seen), frame, found.table.item(0, SIGMA_Y)
        )

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the light that the frame shows, under the empty name."""
        if self._mode is not self._pairs and not self._taken_up:
            candidates = self._about_the_last_place(contrast.frame, candidates)
        chosen = self._mode.choose(contrast, candidates)
        if not chosen:
            return []
        self._missed = 0
        if self._mode is not self._pairs or self._registration != 'none':
            self._taken_up = True
            return chosen
        (name, light), = chosen
        return [(name, self._watched(contrast, light))]

    def _about_the_last_place(
        self, frame: Frame, candidates: Sequence[Candidate]
    ) -> list[Candidate]:
        """Return what can be the light that was followed: another one may flash beside it."""
        last = self._last
        if last is None:
            return list(candidates)
        frames = (frame.stamp_ns - last.stamp_ns) / 1e9 / self._pairs.interval
        reach = self.gate_px * max(frames / PERIOD_FRAMES, 1.0)
        return [
            each for each in candidates if math.hypot(each.x - last.x, each.y - last.y) < reach
        ]

    def _watched(self, contrast: Contrast, light: Candidate) -> Candidate:
        """Watch whether the light drifts; return it with what that lets doubt of its instant."""
        frame, before = contrast.frame, self._last
        stamp_ns = frame.stamp_ns
        since = 0.0 if before is None else (stamp_ns - before.stamp_ns) / 1e9
        if before is None or not 0.0 < since < OUT_OF_SIGHT_S:
            sigma = math.sqrt(light.sigma_major * light.sigma_minor)
            _, (x, y), _ = light_at(contrast.lit, light.x, light.y, sigma)
            self._begin(x, y, stamp_ns)
            return light
        interval = self._pairs.interval
        seen = self._watch.add(
            contrast.lit, contrast.unlit, light, (before.x, before.y),
            (stamp_ns / 1e9, since, interval, exposure_of(self._told_exposure(frame), interval)),
        )
        glimpse = self._heed(seen, frame, light.sigma_y)
        return light if glimpse is None else light._replace(glimpse=glimpse)

    def _told_exposure(self, frame: Frame) -> float:
        """Return for how long a frame is exposed, s; 0 where nobody tells."""
        return self._exposure or frame.exposure_ns / 1e9

    def _heed(self, seen: Seen, frame: Frame, sigma_y: float) -> Glimpse | None:
        """
        Change the mode where the light shows to run free; say what that lets doubt of its instant.

        Parameters
        ----------
        seen : Seen
            What its flash tells.
        frame : Frame
            That shows it.
        sigma_y : float
            Its standard deviation along the columns, px.

        """
        self._last = _Flash(seen.x, seen.y, frame.stamp_ns)
        # Shared line by line, and no time between the lines is known: the pair as a whole tells.
        if seen.shifted and frame.line_time_ns == 0:
            return None
        self._vx += SPEED_MEMORY * (seen.vx - self._vx)
        self._vy += SPEED_MEMORY * (seen.vy - self._vy)
        if not (seen.going_over or seen.side or seen.share):
            return None
        interval = self._pairs.interval
        exposure = exposure_of(self._told_exposure(frame), interval)
        if (seen.going_over or seen.side) and (
            0.5 * exposure * math.hypot(self._vx, self._vy) > MOVING_PX
            or seen.unlit + AHEAD_S * seen.going_over > TOO_EVEN
        ):
            self._mode = HalfRate(
                interval=interval, slower=seen.side * seen.going_over * exposure,
                max_pair_interval=self._max_interval, exposure=self._exposure,
            )
            self._mode.contrast(frame)
            self._taken_up = False
        if seen.share == 0.0:
            return None
        return _doubted(seen, exposure, sigma_y, frame.line_time_ns / 1e9)


def _doubted(seen: Seen, exposure: float, sigma_y: float, line_time: float) -> Glimpse:
    """Return what is not known of the instant of a light that seems to drift."""
    over, speed = seen.share, np.array([seen.vx, seen.vy])
    # It was on in the first part of the exposure, s, or in the last one; the speed is in px/s.
    late = 0.5 * over * exposure
    way = (1.0 - over) * exposure * speed
    doubt = late**2 * np.outer(speed, speed)
    # Its lines are not lit alike then, and nobody knows the sign.
    doubt[1, 1] += most_drawn(1.0 - over, sigma_y, exposure, line_time) ** 2
    return Glimpse(
        1.0 - over, way, WAY_FRACTION * float(np.hypot(*way)) + ROUND_WAY_PX, doubt, np.zeros(2)
    )

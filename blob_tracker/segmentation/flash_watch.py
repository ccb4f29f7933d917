"""A light in step, watched flash by flash: how fast it is, and whether it goes over."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, exact_kernel, kernel
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.drift import (
    APERTURE, Drift, forget_places, Instants, light_at, no_drift, no_instants, NOTHING_KNOWN,
    take_flash, take_place,
)
from blob_tracker.segmentation.line_shift import LEAST_SHIFTS, LineShift, no_shift, take_rows
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

Counts = NDArray[np.int64]
Memory = tuple[Array, Array, Counts, Array, Counts, Array, Array, Counts]

# px in half an exposure, and standard deviations of its light in the unlit frame, from which on
# its place there tells when it was seen.
LEAST_WAY_PX, LEAST_LIGHT_SIGMA = 0.15, 8.0
BEND_PART = 0.1  # of its way from frame to frame, by which it may be off as its path bends
SUREST = 0.25  # ways of half an exposure, to which a place is known at best
UNKNOWN_EXPOSURE = 0.5  # of the frame interval, where nobody tells
STEEP = 0.5  # of its speed along the lines of a frame, that a light has across them


class Seen(NamedTuple):
    """
    What a flash tells with those before it.

    Parameters
    ----------
    x, y : float
        Where the light is in the lit frame alone, px.
    vx, vy : float
        How fast it has been since the last flash, px/s.
    going_over : float
        Part of it that goes over to the other frames in a second; 0 where none does.
    share : float
        Part of it that has gone over so far, beyond the noise.
    unlit : float
        Part of it that is in the unlit frame.
    side : int
        1 of a light that was on at the end of the lit exposure, -1 at its start; 0 of one of which
        that is not known.
    shifted : bool
        Whether it stands higher in the one frame than in the other, or may: one that moves across
        the lines would be ahead or behind by it as one that drifts is, until enough flashes tell.

    """

    x: float
    y: float
    vx: float
    vy: float
    going_over: float
    share: float
    unlit: float
    side: int
    shifted: bool


class FlashWatch:
    """
    Remember the flashes of a light.

    Attributes
    ----------
    memory : tuple of arrays
        Those of `Drift`, `Instants` and `LineShift`, which go to the kernel one by one: to take a
        named tuple apart costs Numba more than to look at the pixels.

    """

    def __init__(self) -> None:
        self._drift, self._instants, self._shift = no_drift(), no_instants(), no_shift()
        self.memory: Memory = (*self._drift, *self._instants, *self._shift)
        self._flashes = 0

    def forget(self) -> None:
        """Begin anew."""
        if self._flashes == 0:
            return
        self._flashes = 0
        self._drift.known[:] = NOTHING_KNOWN
        self._instants.against[:] = 0.0
        for counts in (self._drift.counts, self._instants.counts, self._shift.counts):
            counts[:] = 0

    def add(
        self,
        lit: Pixels,
        unlit: Pixels,
        light: Candidate,
        before: tuple[float, float],
        times: tuple[float, float, float, float],
    ) -> Seen:
        """
        Take a flash; say what it tells with those before it.

        The light is looked for in the lit frame alone, since what is left in the unlit one draws
        the difference away from it, and in the unlit one where it was then if it moved evenly.

        Parameters
        ----------
        lit, unlit : (h, w) arrays
            The pair, DN.
        light : Candidate
            What was found in it.
        before : (float, float)
            Where the light was in the last flash, px.
        times : (float, float, float, float)
            Stamp of the flash, time since the last one, from frame to frame, and of an exposure,
            s.

        """
        sigma = mean_sigma(light.sigma_major, light.sigma_minor)
        return self.taken(*watch_flash(
            *self.memory, lit, unlit, light.x, light.y, sigma, light.noise, before, times
        ))

    def taken(
        self, x: float, y: float, vx: float, vy: float, going_over: float, share: float,
        unlit: float, side: int, shifted: bool,
    ) -> Seen:
        """Take note that a flash is in the memory; return what `watch_flash` told of it."""
        self._flashes += 1
        return Seen(x, y, vx, vy, going_over, share, unlit, side, shifted)


@exact_kernel
def exposure_of(known: float, interval: float) -> float:
    """Return the time of an exposure, s, of what is known of it and the time between frames."""
    return known if known > 0.0 else UNKNOWN_EXPOSURE * interval


@exact_kernel
def mean_sigma(major: float, minor: float) -> float:
    """Return the mean standard deviation of an ellipse, px."""
    return math.sqrt(major * minor)


@kernel
def watch_flash(
    flashes: Array, known: Array, flash_count: Counts, against: Array, place_counts: Counts,
    places: Array, rows: Array, row_counts: Counts, lit: Pixels, unlit: Pixels, x: float, y: float,
    sigma: float, noise: float, before: tuple[float, float],
    times: tuple[float, float, float, float],
) -> tuple[float, float, float, float, float, float, float, int, bool]:
    """Add a flash to the memory; return the fields of `Seen`."""
    stamp, since, interval, exposure = times
    light, (here_x, here_y), _ = light_at(lit, x, y, sigma)
    vx, vy = (here_x - before[0]) / since, (here_y - before[1]) / since
    x, y = here_x - interval * vx, here_y - interval * vy
    left, (there_x, there_y), count = light_at(unlit, x, y, sigma)
    going_over, share = take_flash(Drift(flashes, known, flash_count), stamp, light, left)
    noise *= math.sqrt(0.5 * count)
    there = left > LEAST_LIGHT_SIGMA * noise
    shifted = take_rows(LineShift(places, rows, row_counts), here_y, there_y, there)
    if there and row_counts[1] < LEAST_SHIFTS and abs(vy) > STEEP * abs(vx):
        shifted = True
    instants = Instants(against, place_counts)
    speed = math.hypot(vx, vy)
    unit = 0.5 * exposure * speed
    if not there:
        forget_places(instants)  # it comes back on the other side
    elif unit > LEAST_WAY_PX:
        ahead = ((there_x - x) * vx + (there_y - y) * vy) / speed
        aside = ((there_y - y) * vx - (there_x - x) * vy) / speed
        deviation = math.hypot(0.5 * APERTURE * sigma * noise / left, BEND_PART * interval * speed)
        take_place(
            instants, ahead / unit, max(deviation / unit, SUREST), interval * speed / unit,
            aside / unit,
        )
    part = left / max(light + left, 1e-9)
    return here_x, here_y, vx, vy, going_over, share, part, instants.counts[1], shifted

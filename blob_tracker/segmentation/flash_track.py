"""The track of a light that lights up: where it may go on, and which light goes on with it."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.frame_clock import age_of, PERIOD_FRAMES
import numpy as np

FOLLOWED_GATE_FRACTION = 0.3  # of the gate: what is left to chance once the motion is known
FLANK_SIGMA = 4.0  # sigma: a wide blob's peak wanders so far
ROOT_2 = math.sqrt(2.0)
MAX_BRIGHTNESS_RATIO = 2.5  # times brighter or fainter than before, and still the same light


class FlashTrack(NamedTuple):
    """
    A light that may be the target, as it was last seen.

    Parameters
    ----------
    x, y : float
        Where, px.
    sigma, height : float
        How wide, px, and how bright, DN.
    stamp : float
        When, as `FrameClock` counts, ns.
    flashes, run : float
        How often so far, and how often since a flash was missed.
    velocity_x, velocity_y : float
        px a frame.
    doubted : float
        Whether it was once seen out of step, or turned before it was confirmed; 0 or 1.
    trusted : float
        Whether nothing speaks against it; 0 or 1.

    """

    x: float
    y: float
    sigma: float
    height: float
    stamp: float
    flashes: float = 1.0
    run: float = 1.0
    velocity_x: float = 0.0
    velocity_y: float = 0.0
    doubted: float = 0.0
    trusted: float = 0.0


# The same as columns of a table of tracks.
X, Y, SIGMA, HEIGHT, SEEN, FLASHES, RUN, VX, VY, DOUBTED, TRUSTED = range(11)
FIELDS = 11
# Columns of a light in a frame: those of a new track, whether it is not rejected, and its SNR.
ALLOWED, SNR, LIGHT_FIELDS = 4, 5, 6

# Of a candidate: what goes into a light's row stands in these columns, and the SNR in this one.
CANDIDATE_FIELDS = Candidate._fields.index('height') + 1
SNR_FIELD = Candidate._fields.index('snr')


def rows_of(candidates: Sequence[Candidate]) -> Array:
    """Return (n, 13) fields of candidates up to the height, and whether they are not rejected."""
    if not candidates:
        return np.empty((0, CANDIDATE_FIELDS + 1))
    return np.array([(*each[:CANDIDATE_FIELDS], not each.rejected) for each in candidates])


@kernel
def lights_in(rows: Array) -> Array:
    """Return (n, 6) X, Y, SIGMA, HEIGHT, ALLOWED and SNR of what `rows_of` returns."""
    lights = np.empty((rows.shape[0], LIGHT_FIELDS))
    for i in range(rows.shape[0]):
        row, light = rows[i], lights[i]
        light[X], light[Y] = row[0], row[1]
        light[SIGMA] = math.hypot(row[2], row[3]) / ROOT_2
        light[HEIGHT], light[ALLOWED] = row[CANDIDATE_FIELDS - 1], row[CANDIDATE_FIELDS]
        light[SNR] = row[SNR_FIELD]
    return lights


@kernel
def gate_radius(track: Array, gate_px: float, age: float) -> float:
    """Return how far from where it is expected a track may be so many frames later, px."""
    moved = gate_px if track[FLASHES] == 1.0 else FOLLOWED_GATE_FRACTION * gate_px
    return FLANK_SIGMA * track[SIGMA] + moved * max(age, 1.0) / PERIOD_FRAMES


@kernel
def place_of(track: Array, clock: Array, expected: Array) -> tuple[float, float]:
    """Return where a track is in this frame, px: where it is expected, if anywhere."""
    if expected[2] >= 0.0:
        return expected[0], expected[1]
    age = age_of(clock, track[SEEN])
    return track[X] + track[VX] * age, track[Y] + track[VY] * age


@kernel
def reach_of(
    track: Array, clock: Array, expected: Array, gate_px: float
) -> tuple[float, float, float]:
    """
    Return where a track may go on in this frame.

    Parameters
    ----------
    track : (11,) array
        See `FlashTrack`.
    clock : (15,) array
        See `FrameClock`.
    expected : (3,) array
        Where somebody else expects it, and how far from there it may be, px; below 0 where nobody
        says.
    gate_px : float
        Greatest way of a light from one flash to the next, px.

    Returns
    -------
    x, y, radius : float
        Place, and how far from there it may be, px.

    """
    x, y = place_of(track, clock, expected)
    if expected[2] >= 0.0:
        return x, y, FLANK_SIGMA * track[SIGMA] + expected[2]
    return x, y, gate_radius(track, gate_px, age_of(clock, track[SEEN]))


@kernel
def offset_of(track: Array, reach: tuple[float, float, float], light: Array) -> float:
    """Return how far a light is from where a track is expected, px; infinity for another one."""
    x, y, radius = reach
    dx, dy = light[X] - x, light[Y] - y
    # Most of a crowd is far away: told by the first of these.
    if not (-radius < dx < radius and -radius < dy < radius):
        return np.inf
    away = math.hypot(dx, dy)
    alike = (
        track[HEIGHT] < MAX_BRIGHTNESS_RATIO * light[HEIGHT]
        and light[HEIGHT] < MAX_BRIGHTNESS_RATIO * track[HEIGHT]
    )
    return away if away < radius and alike else np.inf

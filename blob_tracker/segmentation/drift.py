"""Whether a light in step drifts: it goes over from the frames it is on in to the others."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

# The last flashes over which a line is laid: a beat of a second is seen in the first, one of a
# minute in the last.
SPANS = (12, 24, 48, 96, 192)
CHECKED = 6  # flashes from one look at them to the next
LEAST_RISE = 0.08  # of the light, that goes over in a span
LEAST_T = 8.0  # standard deviations of the line's slope
SMOOTHED = 3  # flashes, whose mean is compared with those before
NOISE_MEMORY = 0.1  # of the mean square that a flash renews
# Log-likelihood by which one explanation is beyond the others, and that one place takes at most.
DECIDED, MOST_AGAINST = 12.0, 4.0
# Most that may be held against a true one, on the mean of its places: two coordinates with noise
# make 1, and a few places are no light's.
MOST_MEAN = 2.0
LEAST_SIGMA = 5.0  # standard deviations of such a mean, by which it is another one
NOTHING_KNOWN = np.array([0.0, math.inf, -math.inf, math.inf, -math.inf])  # of no flash
APERTURE, NEAR, FAR = 3.0, 4.0, 6.0  # sigma: of the light, and of the ring about it


class Drift(NamedTuple):
    """
    The light in the lit frames and that in the unlit ones, flash by flash.

    Of a light that runs free near half the frame rate the one falls as the other rises, at an
    even rate. A lamp that it passes is in both, one that is switched on stays, and a light that
    recedes is in the lit frames alone.

    Parameters
    ----------
    flashes : (n, 3) array
        The last ones, in turn: time, s, and light in the lit and in the unlit frame, DN px^2.
    known : (5,) array
        Mean square of the change from flash to flash, then least and most of all means in the lit
        frames and in the unlit ones.
    counts : (1,) int64 array
        How many flashes there were.

    """

    flashes: Array
    known: Array
    counts: NDArray[np.int64]


def no_drift() -> Drift:
    """Return the memory of a light of which nothing is known."""
    return Drift(np.empty((SPANS[-1], 3)), NOTHING_KNOWN.copy(), np.zeros(1, np.int64))


@kernel
def take_flash(drift: Drift, time: float, lit: float, unlit: float) -> tuple[float, float]:
    """
    Take a flash.

    Parameters
    ----------
    drift : Drift
        Of the flashes before it; this one is added.
    time : float
        Its stamp, s.
    lit, unlit : float
        Light above its surroundings where it is and where it was a frame before, DN px^2.

    Returns
    -------
    rate : float
        Part of the light that goes over in a second, 0 where none does.
    share : float
        Part of it that has gone over to the unlit frame, as it seems so far: what is both missing
        in the one and new in the other, beyond the noise.

    """
    flashes, known, counts = drift
    count = counts[0]
    room = flashes.shape[0]
    if count > 0:
        before = flashes[(count - 1) % room, 1]
        known[0] += NOISE_MEMORY * (0.5 * (lit - before) ** 2 - known[0])
    here = flashes[count % room]
    here[0], here[1], here[2] = time, lit, unlit
    count += 1
    counts[0] = count
    if count < SMOOTHED:
        return 0.0, 0.0
    lit, unlit = 0.0, 0.0
    for k in range(count - 1, count - 1 - SMOOTHED, -1):
        lit += flashes[k % room, 1]
        unlit += flashes[k % room, 2]
    lit, unlit = lit / SMOOTHED, unlit / SMOOTHED
    known[1], known[2] = min(known[1], lit), max(known[2], lit)
    known[3], known[4] = min(known[3], unlit), max(known[4], unlit)
    over = min(known[2] - lit, unlit - known[3])
    noise = LEAST_SIGMA * math.sqrt(known[0] / SMOOTHED)
    share = over / max(lit + unlit, 1e-9) if over > noise > 0.0 else 0.0
    changed = min(known[2] - known[1], known[4] - known[3])
    if count % CHECKED == 0 and changed >= 0.5 * LEAST_RISE * (lit + unlit):
        for span in SPANS:
            if span > count:
                break
            rate = _going_over(flashes, count, span)
            if rate != 0.0:
                return rate, share
    return 0.0, share


@kernel
def _going_over(flashes: Array, count: int, span: int) -> float:
    """Return what goes over from the one to the other along a line through the last, 1/s; or 0."""
    room = flashes.shape[0]
    mean = np.zeros(3)
    for k in range(count - span, count):
        mean += flashes[k % room]
    mean /= span
    whole = mean[1] + mean[2]
    if whole <= 0.0:
        return 0.0
    square = 0.0
    slopes = np.zeros(2)
    for k in range(count - span, count):
        away = flashes[k % room, 0] - mean[0]
        square += away * away
        for side in range(2):
            slopes[side] += away * flashes[k % room, 1 + side]
    if square == 0.0:
        return 0.0
    slopes /= square
    left = np.zeros(2)
    for k in range(count - span, count):
        away = flashes[k % room, 0] - mean[0]
        for side in range(2):
            rest = flashes[k % room, 1 + side] - mean[1 + side] - slopes[side] * away
            left[side] += rest * rest
    lasted = flashes[(count - 1) % room, 0] - flashes[(count - span) % room, 0]
    for side in range(2):
        deviation = math.sqrt(max(left[side], 1e-12) / ((span - 2) * square))
        slope = abs(slopes[side])
        if slope < LEAST_T * deviation or slope * lasted < LEAST_RISE * whole:
            return 0.0
    fall, rise = slopes
    return 0.5 * (rise - fall) / whole if fall * rise < 0.0 else 0.0


class Instants(NamedTuple):
    """
    Where a moving light was in the unlit frames: when within the exposure it was seen.

    A light that is partly on in both frames of a pair was on at the end of the one exposure and
    at the start of the other, or the other way round: its two places are farther apart than its
    way from frame to frame, or less far, by its way in half an exposure. One that is never quite
    off is just as far; and where a filter mixes frames the place is that of the last flash.

    Parameters
    ----------
    against : (4,) array
        Half chi-squares of its places: late, early, never off, filtered.
    counts : (2,) int64 array
        How many there are, and the side that they tell: 1 of a light that was on at the end of
        the lit exposure, -1 at its start; else 0.

    """

    against: Array
    counts: NDArray[np.int64]


def no_instants() -> Instants:
    """Return the memory of a light that holds nothing against any of them."""
    return Instants(np.zeros(4), np.zeros(2, np.int64))


@kernel
def forget_places(instants: Instants) -> None:
    """Hold nothing against any of them."""
    instants.against[:] = 0.0
    instants.counts[:] = 0


@kernel
def take_place(
    instants: Instants, ahead: float, deviation: float, frame: float, aside: float
) -> None:
    """
    Take a place; `instants` tells the side by all of them.

    Parameters
    ----------
    instants : Instants
        Of the places before it; this one is added.
    ahead : float
        How far the light in the unlit frame is ahead of where it was in the middle of that, in
        ways of half an exposure.
    deviation : float
        Standard deviation of that.
    frame : float
        Way from one frame to the next in the same unit.
    aside : float
        How far it is beside its way, in that unit: of all of these it is on it.

    """
    against, counts = instants
    counts[0] += 1
    for k, there in enumerate((-1.0, 1.0, 0.0, -frame)):
        # What nothing explains is held against none of them.
        square = (ahead - there) ** 2 + aside * aside
        against[k] += min(0.5 * square / (deviation * deviation), MOST_AGAINST)
    counts[1] = _side(against, counts[0])


@kernel
def _side(against: Array, places: int) -> int:
    """Return the side that what so many places hold against each explanation tells."""
    late, early, never_off, filtered = against
    least = min(late, early)
    if least + DECIDED > min(never_off, filtered, max(late, early)):
        return 0
    if least > MOST_MEAN * places:
        return 0  # none of them is true: it is the texture behind the light, or its lines are cut
    return 1 if late < early else -1


@kernel
def light_at(
    image: Pixels, x: float, y: float, sigma: float
) -> tuple[float, tuple[float, float], int]:
    """
    Return the light within APERTURE sigma of a place above the ring about it.

    In DN px^2, with its centroid, px, and of how many pixels it is the sum.
    """
    height, width = image.shape
    reach = FAR * sigma
    aperture, near, far = (APERTURE * sigma) ** 2, (NEAR * sigma) ** 2, reach**2
    total, across, down, level = 0.0, 0.0, 0.0, 0.0
    pixels, around = 0.0, 0.0
    aside, below = 0.0, 0.0  # of the pixels themselves: the background has a centroid too
    left, right = max(int(x - reach), 0), min(int(x + reach) + 2, width)
    for j in range(max(int(y - reach), 0), min(int(y + reach) + 2, height)):
        dy = j - y
        row = np.uint64(j)
        # Sums of products without a branch, which the compiler vectorizes.
        for i in range(np.uint64(left), np.uint64(max(right, left))):
            dx = np.int32(i) - x
            square = dx * dx + dy * dy
            value = float(image[row, i])
            inside = 1.0 if square < aperture else 0.0
            ring = 1.0 if near < square < far else 0.0
            pixels += inside
            total += inside * value
            aside += inside * dx
            below += inside * dy
            across += inside * value * dx
            down += inside * value * dy
            around += ring
            level += ring * value
    count = int(pixels)
    if count == 0 or around == 0.0:
        return 0.0, (x, y), 0
    level /= around
    total -= count * level
    if total <= 0.0:
        return 0.0, (x, y), count
    return total, (x + (across - level * aside) / total, y + (down - level * below) / total), count

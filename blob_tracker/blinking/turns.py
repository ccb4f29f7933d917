"""A light that turns suddenly while it is exposed: what the middle of its light is off by."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel

TURNS = 0.03  # of the frames have a turn, of a light that may be any
# Of the frames of one that never turned, and frames over which its turns are counted
LEAST_TURNS, COUNTED = 1e-4, 100.0
INSTANTS = 6  # that are tried of a turn, in the exposure and as many before it


@kernel
def fill_bend(
    dx: float, dy: float, variance: float, speed: float, half: float, gap: float, turns: float,
    out: Array,
) -> float:
    """
    Fill what a turn may have added to a place; return the probability that there was one.

    With the velocity changed by u at the time t from the middle of the exposure of 2 h, the middle
    of the light is off the straight way on by m u, and off the place at that middle by b u:

        m = (h - t)^2 / (4 h),  b = (h - |t|)^2 / (4 h)    within the exposure
        m = -t,                 b = 0                      before it

    u is normal, with the speed as its standard deviation along each axis; t is even. The
    innovation d = m u + noise weighs the instants, and tells u.

    Parameters
    ----------
    dx, dy : float
        Innovation, px.
    variance : float
        Of it along either axis, where there was no turn.
    speed : float
        Before the turn, px a frame interval.
    half, gap : float
        h, half of the time for which the light was seen, and the time since it was seen before,
        frame intervals.
    turns : float
        How many it makes in a frame interval.
    out : (3,) array
        Gets the mean of (b u)(b u)^T over all that may have been: xx, xy, yy, px^2.

    """
    out[:] = 0.0
    square, own = dx * dx + dy * dy, speed * speed
    before = max(gap - 2.0 * half, 0.0)
    none, turned = math.exp(-0.5 * square / variance) / variance, 0.0
    for k in range(2 * INSTANTS):
        within = k < INSTANTS
        step = (2.0 * half if within else before) / INSTANTS
        t = (k + 0.5) * step - half if within else (INSTANTS - k - 0.5) * step - half
        moved = (half - t) ** 2 / (4.0 * half) if within else -t
        whole = variance + own * moved * moved
        weight = turns * step * math.exp(-0.5 * square / whole) / whole
        turned += weight
        if within:
            off = (half - abs(t)) ** 2 / (4.0 * half)
            told, left = own * moved / whole, own * variance / whole
            weight *= off * off
            out[0] += weight * (told * told * dx * dx + left)
            out[1] += weight * told * told * dx * dy
            out[2] += weight * (told * told * dy * dy + left)
    for k in range(3):
        out[k] /= max(none + turned, 1e-300)
    return turned / max(none + turned, 1e-300)


@kernel
def counted_turns(turns: float, turned: float, gap: float) -> float:
    """Return how many turns a light makes in a frame interval, after one of such a probability."""
    return max(turns + (turned - turns * min(gap, COUNTED)) / COUNTED, LEAST_TURNS)

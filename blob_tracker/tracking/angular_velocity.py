"""An angular velocity between its samples and past the newest, and the turn that it makes."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.tracking.rotation import from_vector, product
import numpy as np
from numpy.typing import NDArray

# Of samples to which a line is fitted: a longer time follows a turn too late, a shorter one the
# noise and the engine. On a boat 0.05 to 0.07 are alike (study servo).
FITTED_S = 0.06
FEWEST = 4  # samples of a line; of fewer the newest holds
# That they span at least: of a burst, stamped on arrival, the slope is noise over microseconds.
SHORTEST_S = FITTED_S / 2.0
BEFORE, AFTER, BETWEEN = 1, 2, 3  # where a gap is; 0 if there is none


@kernel
def _search(stamps: NDArray[np.int64], stamp: int) -> int:
    """Return how many stamps are not after one."""
    low, high = 0, len(stamps)
    while low < high:
        middle = (low + high) // 2
        if stamps[middle] <= stamp:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _line(
    stamps: NDArray[np.int64], rates: Array
) -> tuple[Array, Array, float, float, float]:
    """
    Return the rate at the newest sample, its slope, and their covariance for a noise of 1.

    The covariance is that of the weighted fit, A^-1 B A^-1 with A = X'WX and B = X'W^2X: of the
    rate, of both, and of the slope.
    """
    newest = len(stamps) - 1
    rate, slope = rates[newest].copy(), np.zeros(3)
    first = _search(stamps, stamps[newest] - round(1e9 * FITTED_S))
    span = 1e-9 * (stamps[newest] - stamps[first])
    if newest - first + 1 < FEWEST or span < SHORTEST_S:
        return rate, slope, 1.0, 0.0, 0.0
    a0 = a1 = a2 = b0 = b1 = b2 = 0.0
    sums, moments = np.zeros(3), np.zeros(3)
    for index in range(first, newest + 1):
        time = 1e-9 * (stamps[index] - stamps[newest])
        weight = 1.0 + time / FITTED_S
        a0 += weight
        a1 += weight * time
        a2 += weight * time * time
        b0 += weight * weight
        b1 += weight * weight * time
        b2 += weight * weight * time * time
        for k in range(3):
            sums[k] += weight * rates[index, k]
            moments[k] += weight * time * rates[index, k]
    determinant = a0 * a2 - a1 * a1
    for k in range(3):
        rate[k] = (a2 * sums[k] - a1 * moments[k]) / determinant
        slope[k] = (a0 * moments[k] - a1 * sums[k]) / determinant
    square = determinant * determinant
    return (
        rate, slope,
        (a2 * a2 * b0 - 2.0 * a1 * a2 * b1 + a1 * a1 * b2) / square,
        (-a1 * a2 * b0 + (a0 * a2 + a1 * a1) * b1 - a0 * a1 * b2) / square,
        (a1 * a1 * b0 - 2.0 * a0 * a1 * b1 + a0 * a0 * b2) / square,
    )


@kernel
def rate_at(
    stamps: NDArray[np.int64], rates: Array, stamp: int, hold: int
) -> tuple[Array, int]:
    """Return the angular velocity at an instant, and where there is a gap."""
    count = len(stamps)
    rate = np.zeros(3)
    after = _search(stamps, stamp)
    if after == 0:
        return rate, BEFORE
    before = after - 1
    if after == count:
        if stamp - stamps[before] > hold:
            return rate, AFTER
        rate, slope, _, _, _ = _line(stamps, rates)
        rate += 1e-9 * (stamp - stamps[before]) * slope
        return rate, 0
    if stamps[after] - stamps[before] > hold:
        return rate, BETWEEN
    share = (stamp - stamps[before]) / (stamps[after] - stamps[before])
    for k in range(3):
        rate[k] = rates[before, k] + share * (rates[after, k] - rates[before, k])
    return rate, 0


@kernel
def _turned(w0: Array, w1: Array, dt: float) -> Array:
    """Return how a vector at rest turns against the base while the rate goes from w0 to w1."""
    half, cone = 0.5 * dt, dt * dt / 12.0
    return from_vector(
        -half * (w0[0] + w1[0]) - cone * (w0[1] * w1[2] - w0[2] * w1[1]),
        -half * (w0[1] + w1[1]) - cone * (w0[2] * w1[0] - w0[0] * w1[2]),
        -half * (w0[2] + w1[2]) - cone * (w0[0] * w1[1] - w0[1] * w1[0]),
    )


@kernel
def turn_between(
    stamps: NDArray[np.int64], rates: Array, variances: Array, t0: int, t1: int, hold: int
) -> tuple[Array, float, int]:
    """Return the rotation, its variance, and where there is a gap."""
    turn = np.eye(3)
    count = len(stamps)
    variance = 0.0
    if count == 0 or t0 < stamps[0]:
        return turn, variance, BEFORE
    newest = stamps[count - 1]
    if t1 - newest > hold:
        return turn, variance, AFTER
    following = _search(stamps, t0)
    at = t0
    w0, gap = rate_at(stamps, rates, t0, hold)
    if gap:  # also where no time passes: nobody knows the rate there
        return turn, variance, gap
    while at < t1 and following < count:
        if stamps[following] <= t1:
            until = stamps[following]
            w1 = rates[following]
            if until - stamps[following - 1] > hold:
                gap = BETWEEN
        else:
            until = t1
            w1, gap = rate_at(stamps, rates, t1, hold)
        if gap:
            return turn, variance, gap
        dt = 1e-9 * (until - at)
        turn = product(_turned(w0, w1, dt), turn)
        # Each sample speaks for half the intervals beside it: its variance over its time
        # squared, shared out evenly over the interval so that parts add up to the whole.
        interval = 1e-9 * (stamps[following] - stamps[following - 1])
        variance += 0.5 * (variances[following - 1] + variances[following]) * interval * dt
        w0, at = w1, until
        following += 1
    if at < t1:
        rate, slope, of_rate, of_both, of_slope = _line(stamps, rates)
        begin, end = 1e-9 * (at - newest), 1e-9 * (t1 - newest)
        dt, half = end - begin, 0.5 * (end * end - begin * begin)
        turn = product(_turned(rate + begin * slope, rate + end * slope, dt), turn)
        variance += variances[count - 1] * (
            of_rate * dt * dt + 2.0 * of_both * dt * half + of_slope * half * half
        )
    return turn, variance, 0

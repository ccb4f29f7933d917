"""The periods after which a light that blinks may repeat itself."""

from __future__ import annotations

from blob_tracker.kernel import Array
import numpy as np

SHORTEST = 2.0  # frame intervals of a period: what is quicker is aliased
FEWEST_PERIODS = 2.0  # that a recording has
STEP = 0.2  # frame intervals by which the last frame's phase changes from one to the next
MOST_FRAMES = 360  # that are folded
AT_ONCE = 2048  # periods


def likely_periods(clock: Array, level: Array, most: int) -> Array:
    """
    Return the likeliest periods of a light, the likeliest first, frame intervals.

    Folded at its period a light that is on or off changes twice a flash, at any other one nearly
    all the time: the sum of (z_i+1 - z_i)^2 in the order of the phases is the least (Lafler and
    Kinman, ApJS 11 (1965)).

    Parameters
    ----------
    clock : (n,) array
        Times, frame intervals.
    level : (n,) array
        Brightness, 1 where it is fully lit.
    most : int
        Periods, at most.

    """
    clock, level = clock[:MOST_FRAMES], level[:MOST_FRAMES]
    span = float(np.ptp(clock)) + 1.0
    longest = span / FEWEST_PERIODS
    if longest < SHORTEST:
        return np.zeros(0)
    # d(1/P) = STEP / (span P), so ln P goes on evenly.
    count = max(int(np.log(longest / SHORTEST) * span / STEP), 2)
    periods = SHORTEST * (longest / SHORTEST) ** np.linspace(0.0, 1.0, count)
    rough = np.concatenate([
        _changes(clock, level, periods[k:k + AT_ONCE]) for k in range(0, count, AT_ONCE)
    ])
    padded = np.pad(rough, 1, constant_values=np.inf)
    least = np.flatnonzero((rough <= padded[:-2]) & (rough <= padded[2:]))
    return np.asarray(periods[least[np.argsort(rough[least], kind='stable')[:most]]])


def _changes(clock: Array, level: Array, periods: Array) -> Array:
    """Return the sum of the squared changes from phase to phase, for each period."""
    phase = (clock / periods[:, None]) % 1.0
    folded = level[np.argsort(phase, axis=1, kind='stable')]
    return np.asarray(((folded - np.roll(folded, 1, axis=1)) ** 2).sum(axis=1))

"""Whether a printed number is one that the same experiment gives when it is repeated."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.studies.printed import unit
import numpy as np
from numpy.typing import ArrayLike
import scipy  # which loads stats, 60 MB, when it is first used


@dataclass(frozen=True)
class Place:
    """
    Where a printed number lies among our repeats.

    Parameters
    ----------
    middle, spread : float
        Mean and standard deviation of the repeats.
    score : float
        Printed less mean, in standard deviations of a further repeat.
    within_95, within_99 : bool
        In the interval that holds a further repeat so often, with what the rounding of the
        printed number leaves open.

    """

    middle: float
    spread: float
    score: float
    within_95: bool
    within_99: bool


def place_among(printed: str, repeats: ArrayLike) -> Place:
    """
    Return where a printed positive number lies among repeats of the same experiment.

    The interval is that of a further repeat, mean +- t sd sqrt(1 + 1/R), on the logarithm, since
    variances and extremes are skewed.

    Parameters
    ----------
    printed : str
        With its digits.
    repeats : (R,) array
        Two at least, above zero.

    """
    values = np.asarray(repeats, dtype=float)
    logarithm = np.log(values)
    further = float(logarithm.std(ddof=1)) * np.sqrt(1.0 + 1.0 / values.size)
    half = 0.5 * unit(printed)
    low, high = (
        (np.log(max(edge, 1e-300)) - logarithm.mean()) / further
        for edge in (float(printed) - half, float(printed) + half)
    )
    t95, t99 = (scipy.stats.t.ppf(p, values.size - 1) for p in (0.975, 0.995))
    # What is nearest to the mean of all that the printed digits stand for.
    score = 0.0 if low <= 0.0 <= high else (low if low > 0.0 else high)
    return Place(
        float(values.mean()), float(values.std(ddof=1)), float(score),
        bool(abs(score) <= t95), bool(abs(score) <= t99),
    )


def likely_count(count: int, share: float) -> int:
    """Return how many of so many are within, at least, in 99 of 100 tables by chance alone."""
    return int(scipy.stats.binom.ppf(0.01, count, share))

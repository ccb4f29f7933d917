"""The overall system gain K as EMVA 1288 defines it."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from blob_tracker.calibration.frame_pair import Pair
from blob_tracker.calibration.noise_line import MISFIT
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads special when it is first used

RANGE = 0.7  # of saturation, up to which K is fitted (EMVA 1288, section 6.5)


def system_gain(bright: Sequence[Pair], darks: Sequence[Pair]) -> tuple[float, float] | None:
    """
    Return K by the letter of EMVA 1288 and its standard deviation, DN per electron.

    The regression of release 3.1 and 4.0 (linear), section 6.5, goes through the dark point and
    weighs all levels from 0 to 70 % of saturation, where the variance is largest, alike:

        K = sum x y / sum x^2,    x = mean - mean_dark,    y = s^2 - s_dark^2.

    Its variance is that of the variances, those of the dark frames shared by the levels that they
    are taken off. Where the points do not lie on a line, their own residuals tell it instead; and
    as K then depends on what each level weighs, the square of what K changes by when they are
    weighted by their variance is added.

    Parameters
    ----------
    bright, darks : sequences of Pair
        A bright pair takes the dark ones of its exposure, or all if there are none.

    Returns
    -------
    (float, float) or None
        None without dark frames, or with fewer than two levels in the range.

    """
    if not bright or not darks:
        return None
    groups = [
        [index for index, each in enumerate(darks) if each.exposure == pair.exposure]
        or list(range(len(darks)))
        for pair in bright
    ]
    # (bright, dark): what each dark pair counts for each bright one.
    share = np.zeros((len(bright), len(darks)))
    for row, group in zip(share, groups):
        row[group] = 1.0 / len(group)
    mean, variance, own = _columns(bright)
    dark_mean, dark_variance, dark_own = _columns(darks)
    x, y = mean - share @ dark_mean, variance - share @ dark_variance
    used = (x > 0.0) & (x <= RANGE * x[variance.argmax()])
    if used.sum() < 2:
        return None
    x, y, own, share = x[used], y[used], own[used], share[used]
    factors = x / (x @ x)
    gain = float(factors @ y)
    squared = float(factors**2 @ own + (factors @ share) ** 2 @ dark_own)
    residuals = y - gain * x
    expected = own + share**2 @ dark_own
    dof = x.size - 1
    if scipy.special.chdtrc(dof, float((residuals**2 / expected).sum())) < MISFIT:
        by_residuals = float(factors**2 @ residuals**2) * x.size / dof
        weights = x / expected
        weighted = float((weights @ y) / (weights @ x))
        squared = max(squared, by_residuals) + (weighted - gain) ** 2
    return gain, sqrt(squared)


def _columns(pairs: Sequence[Pair]) -> tuple[NDArray[np.float64], ...]:
    """Return mean, variance and the variance of the variance of pairs."""
    return tuple(np.array([
        (each.mean, each.variance, each.scatter * each.variance**2) for each in pairs
    ]).T)

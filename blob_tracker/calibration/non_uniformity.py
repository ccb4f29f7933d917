"""What the pixels differ by in light and in the dark, and how straight their response is."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from blob_tracker.calibration.frame_pair import CLIPPED, Pair, PILED_UP
from blob_tracker.calibration.noise_line import NoiseLine
import numpy as np


def linearity_of(
    bright: Sequence[Pair], black: float, most: float
) -> tuple[float, float] | None:
    """
    Return the mean relative deviation of the level from a line over the exposure, and its sigma.

    The line has the least relative squares between 5 and 95 % of saturation (EMVA 1288, 6.7).
    """
    points = [
        (each.exposure, each.mean - black, each.variance / (2.0 * each.count))
        for each in bright
        if each.exposure is not None
        and 0.05 * (most - black) <= each.mean - black <= 0.95 * (most - black)
        and each.at_highest < PILED_UP
    ]
    exposures, levels, variances = np.array(points, dtype=float).reshape(-1, 3).T
    if levels.size < 3 or np.unique(exposures).size < 3:
        return None
    slope, offset = np.polyfit(exposures, levels, 1, w=1.0 / levels)
    deviations = levels / (offset + slope * exposures) - 1.0
    sigma = np.sqrt((variances / levels**2).sum()) / levels.size
    return float(np.abs(deviations).mean()), float(sigma)


def _spatial_sigma(pair: Pair) -> float:
    """Return the standard deviation of a pair's spatial variance, a covariance of two frames."""
    spatial = max(pair.spatial_variance, 0.0)
    return sqrt(((spatial + pair.variance) ** 2 + spatial**2) / pair.count)


def prnu_of(
    bright: Sequence[Pair], darks: Sequence[Pair], black: float, most: float
) -> tuple[float, float] | None:
    """Return PRNU_1288 and its sigma, of the pair nearest to half saturation (eq. 44)."""
    pair = min(bright, key=lambda each: abs(each.mean - 0.5 * (most + black)))
    if pair.at_highest > PILED_UP or pair.mean <= black:
        return None
    dark, dark_sigma = _mean_spatial(darks)
    return _root(
        pair.spatial_variance - dark,
        sqrt(_spatial_sigma(pair) ** 2 + dark_sigma**2),
        1.0 / (pair.mean - black),
    )


def dsnu_of(darks: Sequence[Pair], line: NoiseLine) -> tuple[float, float] | None:
    """Return DSNU_1288, electrons, and its sigma (eq. 43)."""
    sound = [each for each in darks if each.at_zero < CLIPPED]
    if not sound:
        return None
    return _root(*_mean_spatial(sound), line.gain)


def _mean_spatial(pairs: Sequence[Pair]) -> tuple[float, float]:
    """Return the mean spatial variance of pairs, DN^2, and its sigma."""
    sound = [each for each in pairs if each.at_zero < CLIPPED]
    if not sound:
        return 0.0, 0.0
    # The same pixels each time: the temporal noise averages out, the draw of the pixels does not.
    return (
        float(np.mean([each.spatial_variance for each in sound])),
        sqrt(sum(_spatial_sigma(each) ** 2 for each in sound)) / len(sound),
    )


def _root(square: float, sigma: float, scale: float) -> tuple[float, float]:
    """Return the square root of a square that may be below zero, and its sigma, both scaled."""
    root = sqrt(max(square, 0.0))
    return scale * root, scale * (sqrt(root**2 + sigma) - root)

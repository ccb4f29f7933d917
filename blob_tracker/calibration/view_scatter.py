"""
By how much the errors of one view's points hang together.

A bent board, blur or a lens that focuses anew move all points of a view at once, so that they tell
less of the camera than as many independent points. Each view v has its part S_v of the
information and its pull g_v on the parameters (`bundle.parts`), which add up to S and to zero. If
the errors of points are independent, of variance s^2, the pulls scatter as

    E g_v^T S^-1 g_v = s^2 tr(S_v S^-1 - S_v S^-1 S_v S^-1)

The ratio of both sums is what the covariance of the parameters is too small by: the variance of a
sandwich clustered by view (Liang & Zeger, Biometrika 73 (1986) 13), of one scale for all
parameters. A sandwich of its own for each pair of them is singular with fewer views than
parameters; on seven public sets of pictures it was no nearer to what halves of a set differ by.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import special

# Chance at which errors that are independent seem to hang together: of fits in which the sigmas
# need not grow they do in at most 1 of 500.
CHANCE = 0.002

Array = NDArray[np.float64]


def variance_growth(information: Array, pulls: Array, variance: float, prior: Array) -> float:
    """
    Return the factor by which the covariance of independent points is too small.

    Parameters
    ----------
    information : (M, n, n) array
        S_v, what each view tells of the parameters at a variance of 1.
    pulls : (M, n) array
        g_v.
    variance : float
        Of one coordinate of one point, px^2.
    prior : (n,) array
        What is known of each parameter beside the views, on the diagonal of S, at a variance of 1.

    Returns
    -------
    float
        1 unless the pulls scatter significantly more than independent errors would make them.

    """
    total = information.sum(axis=0) + np.diag(prior)
    scale = np.sqrt(np.diag(total))
    values, vectors = np.linalg.eigh(total / np.outer(scale, scale))
    # S^-1/2; scaled, as focal lengths in px and coefficients of r^6 differ by many powers of ten.
    root = vectors / np.sqrt(np.maximum(values, values[-1] * 1e-15)) / scale[:, None]
    parts = root.T @ information @ root
    squares = parts @ parts
    expected = parts - squares
    freedom = float(np.trace(expected, axis1=1, axis2=2).sum())
    if not freedom > 0.0:
        return 1.0
    ratio = float(((pulls @ root) ** 2).sum()) / (freedom * variance)
    # Of each view with itself, and of each with every other: they add up to zero. The sum scatters
    # about as chi-square does that has its mean and variance (Satterthwaite 1946).
    scatter = (expected**2).sum() + (squares.sum(axis=0) ** 2).sum() - (squares**2).sum()
    degrees = freedom**2 / float(scatter)
    chance = float(special.chdtrc(degrees, ratio * degrees))
    return ratio if chance < CHANCE and ratio > 1.0 else 1.0

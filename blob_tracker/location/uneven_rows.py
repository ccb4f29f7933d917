"""How far a pulse may be from where it is seen, where its rows are not lit alike."""

from __future__ import annotations

import math

from blob_tracker.location.hypotheses import Pair
from blob_tracker.location.pair_likelihood import climb
from blob_tracker.location.pair_model import bounds, fill_elliptical, OWN, SIGMA
from blob_tracker.types import Location
import numpy as np


def variance_of_uneven_rows(pair: Pair, location: Location, x: float, y: float) -> float:
    """
    Return the variance along y of a pulse whose rows may be lit unevenly, px^2.

    Light that runs up or down with the rows as 1 + q (j - y) moves a pulse by q sigma^2 and
    makes it narrower along y: sigma_y^2 = sigma^2 (1 - u) with u = (q sigma)^2, in the first
    order of each. So u is told by the pulse's two widths, and the square of the shift is
    sigma^2 u. Of a u that is measured as m with the deviation d, and is not negative, the mean
    is that of the normal distribution cut off at 0.

    Parameters
    ----------
    pair : Pair
        The window.
    location : Location
        Its fit: amplitude and background, DN, and sigma, px.
    x, y : float
        Its place in the window, px.

    """
    lit = Pair(pair.lit, None, pair.noise, pair.saturation)
    lower, upper = bounds(lit)
    sigma = location.sigma
    start = np.array([x, y, location.amplitude, location.background, sigma, sigma])
    fit = climb(
        lit, fill_elliptical, start, np.append(lower, lower[SIGMA]), np.append(upper, upper[SIGMA])
    )
    if fit is None:
        return sigma**2
    wide, high = float(fit.theta[SIGMA]), float(fit.theta[OWN])
    slope = np.zeros(start.size)
    slope[SIGMA], slope[OWN] = 2.0 * high**2 / wide**3, -2.0 * high / wide**2
    measured = 1.0 - (high / wide) ** 2
    deviation = math.sqrt(float(slope @ fit.covariance @ slope))
    if not deviation > 0.0:
        return sigma**2
    import scipy  # no part of a start

    # The mean of the rest of a normal distribution above 0, whose ratio erfcx keeps from 0 / 0.
    standard = -measured / (math.sqrt(2.0) * deviation)
    ratio = math.sqrt(2.0 / math.pi) / float(scipy.special.erfcx(standard))
    return wide**2 * min(measured + deviation * ratio, 1.0)

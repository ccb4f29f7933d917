"""A light that flickers while a rolling shutter exposes its rows one after the other."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.location.estimates import Failure
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.pair_likelihood import climb, Floats
from blob_tracker.location.pair_model import (
    bounds, fill_banded, fill_elliptical, to_fit,
)
import numpy as np

STEEPEST = 1.0  # of the brightest row's light, a row
UNLIKE = 10.0  # of twice the log-likelihood, over a pulse that is higher than wide, or wider


def banded(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a pulse whose rows hold more and more of the light, or less and less, down to none.

        lit = b + A max(0, 1 + q (j - y)) P(x)

    A light that is dimmed by pulses shines for a part of each row's exposure that runs up and
    down with the rows. Within a pulse that is a slope, and its end. A slope moves the pulse by
    q sigma^2 and leaves it, in the first order, as it was: what can be seen of it does not say
    how far. So the window is refused, and only where the slope's end or its skewness shows.
    """
    start = np.array([base.x, base.y, base.amplitude, base.background, base.sigma])
    lower, upper = bounds(pair)
    wide = climb(
        pair, fill_elliptical, np.append(start, base.sigma), np.append(lower, lower[-1]),
        np.append(upper, upper[-1]),
    )
    least = -np.inf if wide is None else wide.log_likelihood
    best = None
    for slope in (-0.15, 0.15):
        fit = climb(
            pair, fill_banded, _start(start, slope), np.append(lower, -STEEPEST),
            np.append(upper, STEEPEST),
        )
        if fit is not None and (best is None or fit.log_likelihood > best.log_likelihood):
            best = fit
    if best is None or 2.0 * (best.log_likelihood - least) < UNLIKE:
        return None
    return replace(to_fit(pair, best), failure=Failure.BANDED)


def _start(start: Floats, slope: float) -> Floats:
    """Return where the fit of a slope starts: the slope moves the pulse to where it is seen."""
    moved = start.copy()
    moved[1] -= slope * start[4] ** 2
    return np.append(moved, slope)

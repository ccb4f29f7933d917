"""A light with a tail: a shutter that leaks, charge that runs, a lens with coma."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.location.doubt import doubted
from blob_tracker.location.hypotheses import Fit, is_heard, Pair
from blob_tracker.location.pair_likelihood import climb, Floats
from blob_tracker.location.pair_model import bounds, SIGMA
from blob_tracker.location.shape_model import fill_tailed, PART, WAY_X, WAY_Y
from blob_tracker.location.unlit_shape import joined, Shape, with_ghost
import numpy as np

MOST = 0.7  # of the light, in the tail: what has more is a streak
SHORTEST = 1.0  # sigmas: a shorter tail is a shift
FIRST_PART, FIRST_LENGTH = 0.15, 2.5  # of the light, and sigmas: where the fit begins
RARER = 4.0  # of the log-likelihood, times its chi2 squared: rarer beforehand than a streak


def tailed(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a pulse of which a part is dragged away from it, to one side.

        lit = b + A (1 - p) P(x) + A p integral_0^1 P(x + t w) dt

    The place is the head's.
    """
    if pair.unlit is None or base.amplitude <= 0.0:
        return None  # what stands behind the target may be the tail
    direction = _lopsided(pair, base)
    start = np.array([
        base.x, base.y, base.amplitude, base.background, base.sigma,
        *(FIRST_LENGTH * base.sigma * direction), FIRST_PART,
    ])
    lower, upper = bounds(pair)
    reach = np.full(2, float(max(pair.lit.shape)))
    lower = np.concatenate([lower, -reach, [0.0]])
    upper = np.concatenate([upper, reach, [MOST]])
    best = climb(pair, fill_tailed, start, lower, upper)
    if best is None:
        return None
    shape = with_ghost(pair, Shape(best, fill_tailed, start, lower, upper))
    best = shape.optimum
    theta = best.theta
    way = math.hypot(theta[WAY_X], theta[WAY_Y])
    if not 0.0 < theta[PART] < MOST or way < SHORTEST * theta[SIGMA]:
        return None
    if not is_heard(base, best.log_likelihood, best.parameters, RARER):
        return None  # what its misfit does to the place need not be known
    fit, left = doubted(
        pair, best, shape.model, joined(
            f'the light has a tail of {pair.pitch * way:.0f} px with '
            f'{100.0 * theta[PART]:.0f} % of it (a shutter that leaks, smear, blooming, or '
            'coma): its head is taken; lower the exposure, or learn its pulse (calibrate pulse)',
            shape.warning,
        ),
    )
    return replace(fit, rarity=RARER * max(left.chi2, 1.0) ** 2, lopsided=True)


def _lopsided(pair: Pair, base: Fit) -> Floats:
    """Return the unit vector to the side where the light reaches farther, by its third moments."""
    rows, columns = np.indices(pair.lit.shape)
    apart = np.stack([columns - base.x, rows - base.y]) / base.sigma
    squares = (apart**2).sum(axis=0)
    residual = pair.lit - base.background - base.amplitude * np.exp(-0.5 * squares)
    weight = np.where(pair.usable[0], np.exp(-0.25 * squares), 0.0)
    pull = (apart * (squares - 4.0) * weight * residual).sum(axis=(1, 2))
    length = float(np.hypot(*pull))
    return pull / length if length > 0.0 else np.array([1.0, 0.0])

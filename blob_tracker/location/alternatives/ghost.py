"""A light that is not dark in the unlit frame, and that has moved since."""

from __future__ import annotations

from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.pair_likelihood import climb, Floats, Model, Optimum
from blob_tracker.location.pair_model import (
    AMPLITUDE, bounds, BRIGHTEST, brightest, fill_dark_ghost, fill_static_ghost, GHOST, SHIFT_X,
    SHIFT_Y, SIGMA, to_fit,
)
from blob_tracker.location.unlit_pulse import outdoes_texture
from blob_tracker.location.unlit_shape import BEFORE, BRIGHTER, STILL_ON, UNDECIDED
import numpy as np

FARTHEST = 4.0  # sigmas: a light that is farther away in the unlit frame is another one


def ghost(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a light of which a share is left in the unlit frame, at a place of its own.

        lit = b + A P(x),    unlit = b + G P(x')

    A light behind the target, which is in both windows, looks the same where it is as wide as
    the pulse and less than some sigmas from it. So it is a ghost unless

        lit = b + A P(x) + G P(x')

    is clearly likelier, or it is too bright or too far away for one. And it is none where a
    random texture explains the unlit window as well.
    """
    if pair.unlit is None:
        return None
    left = fit_ghost(pair, fill_dark_ghost, first_guess(pair, base), BEFORE)
    if left is None:
        return None
    theta = left.theta
    distance = np.hypot(theta[SHIFT_X], theta[SHIFT_Y])
    share = theta[GHOST] / max(theta[AMPLITUDE], 1e-6)
    if share > BRIGHTER or distance > FARTHEST * theta[SIGMA]:
        return None
    if not outdoes_texture(pair, left):
        return None
    if lamp_is_likelier(pair, theta, left):
        return None
    return to_fit(pair, left, STILL_ON.format(100.0 * share))


def lamp_is_likelier(pair: Pair, start: Floats, fit: Optimum) -> bool:
    """Return whether a lamp behind the target, in both windows, is clearly likelier."""
    lamp = fit_ghost(pair, fill_static_ghost, start, None)
    return lamp is not None and 2.0 * (lamp.log_likelihood - fit.log_likelihood) > UNDECIDED


def first_guess(pair: Pair, base: Fit) -> Floats:
    """Return where a fit of two pulses starts: the base's, and the unlit window's brightest."""
    assert pair.unlit is not None
    background = float(np.median(pair.unlit))
    x, y = brightest(pair.unlit)
    left = max(float(pair.unlit[int(y), int(x)]) - background, 0.1)
    amplitude = max(base.amplitude, float(pair.lit.max()) - background, 1.0)
    return np.array([
        base.x, base.y, amplitude, background, base.sigma, x - base.x, y - base.y, left
    ])


def fit_ghost(
    pair: Pair, model: Model, start: Floats, flashes: float | None
) -> Optimum | None:
    """Fit two pulses, the second one so many flashes' displacements from the first, or free."""
    height, width = pair.lit.shape
    lower, upper = bounds(pair)
    lower = np.concatenate([lower, [-width, -height, 0.0]])
    upper = np.concatenate([upper, [width, height, BRIGHTEST]])
    prior = None if flashes is None else shift_prior(pair, flashes, start.size)
    return climb(pair, model, start, lower, upper, prior)


def shift_prior(pair: Pair, flashes: float, count: int) -> tuple[Floats, Floats] | None:
    """Return what the light's motion says of the shift beforehand, for `count` parameters."""
    if pair.motion is None:
        return None
    mean, known = np.zeros(count), np.zeros(count)
    mean[[SHIFT_X, SHIFT_Y]] = flashes * pair.motion.flash
    known[[SHIFT_X, SHIFT_Y]] = 1.0 / pair.motion.deviation**2
    return mean, known

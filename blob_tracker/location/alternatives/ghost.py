"""A light that is not dark in the unlit frame, and that has moved since."""

from __future__ import annotations

import math

from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.noise import pixel_variance
from blob_tracker.location.pair_likelihood import climb, Floats, Model, Optimum
from blob_tracker.location.pair_model import (
    AMPLITUDE, bounds, brightest, BRIGHTEST, fill_dark_ghost, fill_static_ghost, GHOST, GHOST_X,
    GHOST_Y, SIGMA, to_fit, X, Y,
)
from blob_tracker.location.texture_field import log_likelihood_of_texture
import numpy as np

BRIGHTER = 0.6  # of the lit pulse: such a light in the unlit frame is another one
FARTHEST = 4.0  # sigmas: beyond it, the same
CLEARLY = 10.0  # likelier, of twice the log-likelihood, than a texture: 1 to 150
UNDECIDED = 12.0  # of twice the log-likelihood, below which a ghost is likelier beforehand


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
    start = _start(pair, base)
    left = _fit(pair, fill_dark_ghost, start)
    if left is None:
        return None
    theta = left.theta
    distance = np.hypot(theta[GHOST_X] - theta[X], theta[GHOST_Y] - theta[Y])
    share = theta[GHOST] / max(theta[AMPLITUDE], 1e-6)
    if share > BRIGHTER or distance > FARTHEST * theta[SIGMA]:
        return None
    if not _outdoes_texture(pair, left):
        return None
    behind = _fit(pair, fill_static_ghost, theta)
    if behind is not None:
        if 2.0 * (behind.log_likelihood - left.log_likelihood) > UNDECIDED:
            return None
    return to_fit(
        pair, left,
        f'the light is still on in the unlit frame ({100.0 * share:.0f} % of it): shorten the '
        'exposure, or flash at half the frame rate',
    )


def _start(pair: Pair, base: Fit) -> Floats:
    """Return the first guess: the base fit, and the brightest spot of the unlit window."""
    assert pair.unlit is not None
    background = float(np.median(pair.unlit))
    x, y = brightest(pair.unlit)
    left = max(float(pair.unlit[int(y), int(x)]) - background, 0.1)
    amplitude = max(base.amplitude, float(pair.lit.max()) - background, 1.0)
    return np.array([
        base.x, base.y, amplitude, background, base.sigma, x, y, left
    ])


def _outdoes_texture(pair: Pair, left: Optimum) -> bool:
    """Return whether the unlit window is likelier to hold a pulse than a random texture."""
    assert pair.unlit is not None
    noise = pair.noise
    # The window's mean is what the texture knows of the noise; the pulse is told no more.
    variance = float(pixel_variance(pair.unlit.mean(), noise))
    squares = float(((pair.unlit - left.means[1]) ** 2).sum()) / variance
    pulse = -0.5 * (squares + pair.unlit.size * math.log(variance))
    return 2.0 * (pulse - log_likelihood_of_texture(pair.unlit, variance)) > CLEARLY


def _fit(pair: Pair, model: Model, start: Floats) -> Optimum | None:
    lower, upper = bounds(pair)
    lower = np.concatenate([lower, lower[:3]])
    upper = np.concatenate([upper, upper[:2], [BRIGHTEST]])
    return climb(pair, model, start, lower, upper)

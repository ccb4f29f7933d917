"""A light that lights up haze or a wall about itself: a glow, with a slope under the light."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.location.doubt import doubted
from blob_tracker.location.hypotheses import Fit, is_heard, Pair
from blob_tracker.location.light_moments import light_moments
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.pair_model import bounds, BRIGHTEST, SIGMA, X, Y
from blob_tracker.location.shape_model import (
    fill_glow, GLOW, GLOW_X, GLOW_XX, GLOW_XY, GLOW_Y, GLOW_YY,
)
import numpy as np

# Of its own level, that the glow gains within a sigma of the light: what is steeper is no glow of
# something at least three times as wide, but a part of the light.
STEEPEST = 0.5
FLAT = 0.05  # the same of what may be the light of lamps, or another exposure
WHOLE_PERIODS = 'expose for whole periods (10 ms at 50 Hz, 8.3 ms at 60 Hz)'
RARER = 4.0  # of the log-likelihood, times its chi2 squared: rarer beforehand than a streak


def glow(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a pulse on a glow that is in the lit window alone, a plane or a bent surface.

        lit = b + A P(x) + g(x),    unlit = b

    Below 0 it is what lamps of the scene, or the camera's exposure, took from the lit window.
    """
    if pair.unlit is None:
        return None  # what is constant and what the flash lights up cannot be told apart
    height, width = pair.lit.shape
    light = light_moments(pair)
    about = float(np.median(pair.unlit))
    start = np.array([
        light.x, light.y, light.peak, about, max(light.across, 0.5), light.background - about,
        0.0, 0.0,
    ])
    even = _fit(pair, start)
    if even is None:
        return None
    bent = _fit(pair, np.append(even.theta, [0.0, 0.0, 0.0]))
    best = even if bent is None or _evidence(pair, even) >= _evidence(pair, bent) else bent
    theta = best.theta
    level, slope = _at_the_light(theta, height, width)
    if slope * theta[SIGMA] > STEEPEST * abs(level):
        return None
    if not is_heard(base, best.log_likelihood, best.parameters, RARER):
        return None  # what its misfit does to the place need not be known
    rise, steepness = level / pair.pitch**2, slope / pair.pitch**3
    if level > 0.0:
        said = (
            f'the flash lights up haze or a wall about the light, by {rise:.0f} DN and '
            f'{steepness:.1f} DN/px: it is taken off; shade the wall from the light, or move it '
            'away from there'
        )
        if slope * theta[SIGMA] < FLAT * level:
            said += f'; or lamps on the mains do: {WHOLE_PERIODS}'
    else:
        said = (
            f'the scene about the light is {-rise:.0f} DN darker in the lit frame, by lamps on '
            f'the mains or auto-exposure: {WHOLE_PERIODS}, and switch auto-exposure off'
        )
    fit, left = doubted(pair, best, fill_glow, said)
    return replace(fit, rarity=RARER * max(left.chi2, 1.0) ** 2)


def _fit(pair: Pair, start: Floats) -> Optimum | None:
    lower, upper = bounds(pair)
    most = np.full(start.size - lower.size, BRIGHTEST)
    return climb(
        pair, fill_glow, start, np.concatenate([lower, -most]), np.concatenate([upper, most])
    )


def _at_the_light(theta: Floats, height: int, width: int) -> tuple[float, float]:
    """Return the glow's level where the light is, DN, and its slope there, DN/px."""
    across, down = 2.0 / (width - 1.0), 2.0 / (height - 1.0)
    u, v = across * theta[X] - 1.0, down * theta[Y] - 1.0
    by_u, by_v = theta[GLOW_X], theta[GLOW_Y]
    level = theta[GLOW] + by_u * u + by_v * v
    if theta.size > GLOW_XX:
        level += theta[GLOW_XX] * u * u + theta[GLOW_XY] * u * v + theta[GLOW_YY] * v * v
        by_u = by_u + 2.0 * theta[GLOW_XX] * u + theta[GLOW_XY] * v
        by_v = by_v + 2.0 * theta[GLOW_YY] * v + theta[GLOW_XY] * u
    return float(level), math.hypot(across * by_u, down * by_v)


def _evidence(pair: Pair, fit: Optimum) -> float:
    """Return the log-likelihood less what its parameters cost (Schwarz, 1978)."""
    return fit.log_likelihood - 0.5 * fit.parameters * math.log(pair.pixels.size)

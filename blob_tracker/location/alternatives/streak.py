"""A light that draws a streak while it is exposed, or that is longer than wide."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.location.doubt import doubted
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.light_moments import light_moments
from blob_tracker.location.pair_likelihood import climb, Floats, Model
from blob_tracker.location.pair_model import AMPLITUDE, bounds, SIGMA
from blob_tracker.location.shape_model import fill_bent, fill_streak, WAY_X, WAY_Y
from blob_tracker.location.unlit_shape import joined, Shape, with_ghost
import numpy as np

PLAIN = 2.0  # sigmas of length, up to which a pulse is as good as round
SLOWEST = 120  # steps: how long and how wide a short one is, is hard to tell apart
SHORTEST = 0.3  # px: from a length of 0 there is no way up


def streak(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a pulse that is dragged along a straight line, of any length and direction.

        lit = b + A / 2 integral_-1^1 P(x + t w) dt

    The place is the middle of the line: where the light is in the middle of the exposure, if it
    moves evenly. A pulse of two widths, at any angle, is one to within the noise unless it is
    long and bright. Where a tracker knows the way, w is that to within its
    deviation, and the line bends as the tracker says.
    """
    if pair.unlit is None and pair.way is None:
        return None  # what stands behind the target may be what makes it long
    light = light_moments(pair)
    half = math.sqrt(3.0 * max(light.along**2 - light.across**2, SHORTEST**2))
    to_end = half * light.direction
    prior = None
    model: Model = fill_streak
    if pair.way is not None:
        model = _bent(*pair.way.bend.tolist())
        to_end = 0.5 * pair.way.length
        half = float(np.hypot(*to_end))
        known = 4.0 / max(pair.way.deviation, SHORTEST) ** 2
        prior = (
            np.array([0.0, 0.0, 0.0, 0.0, 0.0, *to_end]),
            np.array([0.0, 0.0, 0.0, 0.0, 0.0, known, known]),
        )
    start = np.array([
        light.x, light.y, max(light.peak, 1.0) * (1.0 + 0.4 * half / light.across),
        light.background, max(0.9 * light.across, 0.5), *to_end,
    ])
    lower, upper = bounds(pair)
    reach = np.full(2, float(max(pair.lit.shape)))
    lower, upper = np.append(lower, -reach), np.append(upper, reach)
    best = climb(pair, model, start, lower, upper, prior, steps=SLOWEST)
    if best is None:
        return None
    shape = with_ghost(pair, Shape(best, model, start, lower, upper, prior))
    best = shape.optimum
    way, sigma = 2.0 * math.hypot(best.theta[WAY_X], best.theta[WAY_Y]), best.theta[SIGMA]
    warning = ''
    if way > PLAIN * sigma and pair.way is None:
        angle = math.degrees(math.atan2(best.theta[WAY_Y], best.theta[WAY_X])) % 180.0
        warning = (
            f'a streak of {pair.pitch * way:.0f} px at {angle:.0f} degrees: the light moves while '
            'it is exposed; its position is that in the middle of the exposure: shorten the '
            'exposure'
        )
    fit, _ = doubted(pair, best, shape.model, joined(warning, shape.warning))
    # Of the pulse at rest, A is the peak; of the streak it is less.
    lower_by = 1.0
    if way > 1e-3 * sigma:
        ends = way / (2.0 * math.sqrt(2.0) * sigma)
        lower_by = math.sqrt(math.pi) / 2.0 * math.erf(ends) / ends
    return replace(
        fit, amplitude=lower_by * float(best.theta[AMPLITUDE]), snr=math.sqrt(lower_by) * fit.snr,
        way=2.0 * best.theta[[WAY_X, WAY_Y]],
    )


def _bent(x: float, y: float) -> Model:
    """Return the model of a streak that bends so."""
    def fill(theta: Floats, means: Floats, slopes: Floats) -> None:
        fill_bent(theta, x, y, means, slopes)

    return fill

"""A light out of focus: a disc, or with a mirror lens a ring."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.location.doubt import doubted
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.light_moments import light_moments
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.pair_model import AMPLITUDE, bounds, SIGMA
from blob_tracker.location.shape_model import fill_disc, fill_ring, HOLE, RADIUS
from blob_tracker.location.unlit_shape import joined, Shape, with_ghost
import numpy as np

SLOWEST = 200  # steps: a thin ring's level, softness and width change for one another
ROUNDEST = 1.3  # times as long as wide: what is longer is no disc
FIRST_SOFTNESS = 0.8  # px
FIRST_HOLES = (0.35, 0.8)  # of the radius
HIGHER, SOFTER = 1.6, 1.2  # than a disc seems: a thin ring, which is below its level everywhere


def defocused(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a disc of even light with soft edges, or a ring.

        lit = b + A / 2 [erfc((r - R) / sqrt2 s) - erfc((r - R') / sqrt2 s)]

    The sigma that is returned has the second moments of the disc, s^2 + (R^2 + R'^2) / 4.
    """
    if pair.unlit is None:
        return None  # what stands behind the target is no part of a disc
    light = light_moments(pair)
    if light.along > ROUNDEST * light.across:
        return None
    start = np.array([
        light.x, light.y, 0.9 * light.peak, light.background, FIRST_SOFTNESS, light.radius
    ])
    lower, upper = bounds(pair)
    farthest = float(max(pair.lit.shape))
    lower, upper = np.append(lower, 0.5), np.append(upper, farthest)
    disc = climb(pair, fill_disc, start, lower, upper)
    ring_lower, ring_upper = np.append(lower, 0.0), np.append(upper, farthest)
    best, model = disc, fill_disc
    for first in _first_rings(start, disc):
        ring = climb(pair, fill_ring, first, ring_lower, ring_upper, steps=SLOWEST)
        if ring is None or ring.theta[HOLE] <= 0.0:
            continue
        if best is None or _evidence(pair, ring) > _evidence(pair, best):
            best, model, lower, upper = ring, fill_ring, ring_lower, ring_upper
    if best is None:
        return None
    seen = with_ghost(pair, Shape(best, model, best.theta, lower, upper))
    best = seen.optimum
    theta = best.theta
    inner = theta[HOLE] if model is fill_ring else 0.0
    if not inner < theta[RADIUS]:
        return None
    radius = pair.pitch * theta[RADIUS]
    shape = f'ring of radius {radius:.1f} px, hole {pair.pitch * inner:.1f} px' if inner else (
        f'disc of radius {radius:.1f} px'
    )
    fit, _ = doubted(
        pair, best, seen.model, joined(
            f'the light is a {shape}: out of focus? Focus the lens, or learn its pulse '
            '(calibrate pulse)', seen.warning,
        ),
    )
    width = math.sqrt(theta[SIGMA] ** 2 + 0.25 * (theta[RADIUS] ** 2 + inner**2))
    return replace(fit, sigma=width)


def _first_rings(start: Floats, disc: Optimum | None) -> list[Floats]:
    """Return where the fits of a ring begin: one with a small hole, and a thin one."""
    wide = start if disc is None else disc.theta
    thin = start.copy()
    thin[[AMPLITUDE, SIGMA]] *= HIGHER, SOFTER
    thin[RADIUS] -= 0.7
    return [
        np.append(first, hole * first[RADIUS]) for first, hole in zip((wide, thin), FIRST_HOLES)
    ]


def _evidence(pair: Pair, fit: Optimum) -> float:
    """Return the log-likelihood less what its parameters cost (Schwarz, 1978)."""
    return fit.log_likelihood - 0.5 * fit.parameters * math.log(pair.pixels.size)

"""A second light that flashes with the first and is merged with it: a mirror image."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.location.doubt import doubted
from blob_tracker.location.estimates import Beside
from blob_tracker.location.hypotheses import Fit, is_heard, Pair
from blob_tracker.location.light_moments import light_moments
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.pair_model import (
    AMPLITUDE, bounds, BRIGHTEST, brightest, GHOST, SHIFT_X, SHIFT_Y, SIGMA, X, Y,
)
from blob_tracker.location.shape_model import fill_two_lights
from blob_tracker.location.unlit_shape import joined, Shape, with_ghost
import numpy as np

NEAREST = 1.0  # sigma: nearer ones are one
FAINTEST = 0.05  # of the brighter one: less is no light of its own
EQUAL = 0.8  # of the brighter one: above it either may be the target
ALIKE = 0.5  # of it: above it the last flashes tell better which one is brighter
SLOWEST = 120  # steps
RARER = 6.0  # of the log-likelihood, times its chi2 squared: rarer beforehand than a streak
EIGHTHS = (
    'right of', 'below and right of', 'below', 'below and left of', 'left of',
    'above and left of', 'above', 'above and right of',
)


def two_lights(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit two pulses of one width.

        lit = b + A P(x) + A' P(x')

    The brighter one is the target, in the last flashes together; of two that are about as bright
    in the first one, that which is nearer to where the target should be, if that is known.
    """
    if pair.unlit is None:
        return None  # what stands behind the target may be the second light
    found = [
        fit for fit in (_fit(pair, start) for start in _first_guesses(pair, base))
        if fit is not None
    ]
    if not found:
        return None
    best = max(found, key=lambda fit: fit.log_likelihood)
    shape = with_ghost(pair, Shape(best, fill_two_lights, best.theta, *_bounds(pair)))
    best = shape.optimum
    theta = best.theta
    part = theta[GHOST] / max(theta[AMPLITUDE], 1e-6)
    distance = math.hypot(theta[SHIFT_X], theta[SHIFT_Y])
    if part < FAINTEST or distance < NEAREST * theta[SIGMA]:
        return None
    if _is_exchanged(pair, theta, part):
        best = _exchanged(best)
        theta = best.theta
        part = theta[GHOST] / theta[AMPLITUDE]
    eighth = round(math.degrees(math.atan2(theta[SHIFT_Y], theta[SHIFT_X])) / 45.0) % 8
    if not is_heard(base, best.log_likelihood, best.parameters, RARER):
        return None  # what its misfit does to the place need not be known
    fit, left = doubted(
        pair, best, shape.model, joined(
            f'a second light, {part:.1f} as bright, {pair.pitch * distance:.1f} px '
            f'{EIGHTHS[eighth]} the target, flashes with it: a reflection?', shape.warning,
        ),
    )
    return replace(
        fit, rarity=RARER * max(left.chi2, 1.0) ** 2, lopsided=bool(part < EQUAL),
        beside=Beside(theta[[SHIFT_X, SHIFT_Y]], _excess(best)),
    )


def _first_guesses(pair: Pair, base: Fit) -> list[Floats]:
    """Return where the fit begins: two alike along the light, one that is left over, the last."""
    light = light_moments(pair)
    half = math.sqrt(max(light.along**2 - light.across**2, 0.25)) * light.direction
    sigma = max(0.9 * light.across, 0.5)
    alike = np.array([
        light.x - half[0], light.y - half[1], 0.8 * light.peak, light.background, sigma,
        2.0 * half[0], 2.0 * half[1], 0.8 * light.peak,
    ])
    rows, columns = np.indices(pair.lit.shape)
    x, y = brightest(pair.lit)
    squares = (columns - x) ** 2 + (rows - y) ** 2
    pulse = light.peak * np.exp(-0.5 * squares / sigma**2)
    left = np.where(squares > sigma**2, pair.lit - light.background - pulse, 0.0)
    other_x, other_y = brightest(left)
    over = np.array([
        x, y, light.peak, light.background, sigma, other_x - x, other_y - y,
        max(float(left[int(other_y), int(other_x)]), 0.1 * light.peak),
    ])
    beside = pair.history.beside
    if beside is None:
        return [alike, over]
    again = over.copy()
    again[[SHIFT_X, SHIFT_Y]] = beside.shift
    return [alike, over, again]


def _fit(pair: Pair, start: Floats) -> Optimum | None:
    """Fit from a first guess; the brighter light is the first."""
    best = climb(pair, fill_two_lights, start, *_bounds(pair), steps=SLOWEST)
    if best is None or best.theta[GHOST] <= best.theta[AMPLITUDE]:
        return best
    return _exchanged(best)


def _bounds(pair: Pair) -> tuple[Floats, Floats]:
    lower, upper = bounds(pair)
    reach = np.array(pair.lit.shape[::-1], dtype=float)
    return (
        np.concatenate([lower, -reach, [0.0]]), np.concatenate([upper, reach, [BRIGHTEST]])
    )


def _excess(fit: Optimum) -> float:
    """Return by how many standard deviations the first light is brighter than the second."""
    levels = [AMPLITUDE, GHOST]
    (first, both), (_, second) = fit.covariance[np.ix_(levels, levels)]
    variance = max(float(first + second - 2.0 * both), 1e-12)
    return float((fit.theta[AMPLITUDE] - fit.theta[GHOST]) / math.sqrt(variance))


def _is_exchanged(pair: Pair, theta: Floats, part: float) -> bool:
    """Return whether the target is the second light, which is a `part` as bright."""
    beside = pair.history.beside
    shift = theta[[SHIFT_X, SHIFT_Y]]
    if beside is not None and part > ALIKE:
        return bool(shift @ beside.shift < 0.0)
    if part <= EQUAL or pair.motion is None or pair.motion.place is None:
        return False
    away = theta[[X, Y]] - pair.motion.place
    return bool(np.hypot(*(away + shift)) < np.hypot(*away))


def _exchanged(fit: Optimum) -> Optimum:
    """Return the fit with the second light as the first."""
    turn = np.eye(fit.theta.size)
    turn[X, SHIFT_X] = turn[Y, SHIFT_Y] = 1.0
    turn[SHIFT_X, SHIFT_X] = turn[SHIFT_Y, SHIFT_Y] = -1.0
    turn[[AMPLITUDE, GHOST]] = turn[[GHOST, AMPLITUDE]]
    return replace(fit, theta=turn @ fit.theta, covariance=turn @ fit.covariance @ turn.T)

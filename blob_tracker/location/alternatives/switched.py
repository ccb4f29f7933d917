"""A flash that switches while the rows of the light are exposed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
import math

from blob_tracker.location.alternatives.ghost import first_guess, lamp_is_likelier, shift_prior
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.pair_model import (
    AMPLITUDE, bounds, brightest, fill_switched, GHOST, SHARE, SHIFT_X, SHIFT_Y, SIGMA, SLOPE,
    to_fit, Y,
)
from blob_tracker.location.unlit_pulse import outdoes_texture
from blob_tracker.location.unlit_shape import (
    BEFORE, EVEN, FARTHEST, STEEPEST, STILL_ON, SWITCHES,
)
import numpy as np

ODD = 2.0  # standard deviations of chi2, beyond which a light that rests does not explain it
PROFILED = (0.1, 0.2, 0.4, 0.7, 1.1)  # sigmas from the likeliest place, along y
# Of the light in the lit frame, and what a row adds: where the fits of one that moves begin
FIRST_SHARE, FIRST_SLOPES = 0.75, (-0.12, 0.12, -0.02, 0.02)


def switched(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a light whose rows are shared out between the two frames.

        lit = b + A s_j P(x),    unlit = b + A (1 - s_j) P(x')

    A light that is on for one frame's time and off for the next switches at one instant of
    each frame. On a rolling shutter the rows that are exposed across that instant get a part of
    the flash in the lit frame and the rest in the unlit one. Their share s_j runs from 1 to 0,
    or from 0 to 1, over as many rows as are exposed at once.
    """
    if pair.unlit is None:
        return None
    start = _first_guess(pair, base)
    fits = [_fit(pair, start, moving=False)]
    if fits[0] is not None and fits[0].chi2 < 1.0 + ODD * math.sqrt(2.0 / pair.pixels.size):
        moving = _fit(pair, fits[0].theta, moving=True)
    else:
        moving = _fit_moving(pair, base, start if fits[0] is None else fits[0].theta)
    # Where all rows have the same share, more than a half, it is a ghost that moves.
    if moving is not None and (_runs(moving) or _share(pair, moving) < 0.5):
        fits.append(moving)
    found = [fit for fit in fits if fit is not None and outdoes_texture(pair, fit)]
    if not found:
        return None
    pixels = np.log(pair.pixels.size)
    best = min(found, key=lambda fit: fit.parameters * pixels - 2.0 * fit.log_likelihood)
    if lamp_is_likelier(pair, first_guess(pair, base), best):
        return None
    percent = 100.0 * _share(pair, best)
    if _runs(best):
        warning = SWITCHES.format(percent)
    else:
        warning = STILL_ON.format(100.0 - percent)
    seen = to_fit(pair, best, warning)
    if not best.theta[[SHIFT_X, SHIFT_Y]].any():
        return replace(seen, drawn=seen.y - base.y)
    y, variance = _profile(pair, best)
    covariance = seen.covariance.copy()
    covariance[1, 1] += variance
    return replace(seen, y=y, drawn=y - base.y, covariance=covariance)


def _profile(pair: Pair, best: Optimum) -> tuple[float, float]:
    """
    Return the mean of y by the likelihood of its places about the likeliest, and their variance.

    Where the cut is, how bright the light is and where it is are told by a few rows: there is more
    than one place that explains them, and the curvature at the top does not tell of the others.
    """
    places, heights = [float(best.theta[Y])], [best.log_likelihood]
    for side in (-1.0, 1.0):
        last = best
        for away in PROFILED:
            start = last.theta.copy()
            start[Y] = best.theta[Y] + side * away * best.theta[SIGMA]
            fit = _fit(pair, start, moving=True, held=(Y,))
            if fit is None:
                break
            places.append(float(start[Y]))
            heights.append(fit.log_likelihood)
            last = fit
    order = np.argsort(places)
    y, height = np.array(places)[order], np.array(heights)[order]
    if y.size < 3:
        return float(best.theta[Y]), float(best.theta[SIGMA]) ** 2
    weight = np.exp(height - height.max()) * np.gradient(y)
    weight /= weight.sum()
    mean = float(weight @ y)
    return mean, float(weight @ (y - mean) ** 2)


def _share(pair: Pair, fit: Optimum) -> float:
    """Return the share of the light in the lit frame, at its own row."""
    theta = fit.theta
    row = theta[Y] - 0.5 * (pair.lit.shape[0] - 1)
    return min(max(float(theta[SHARE] + theta[SLOPE] * row), 0.0), 1.0)


def _runs(fit: Optimum) -> bool:
    """Return whether the share surely runs along the rows, whatever the light's motion."""
    return bool(abs(fit.theta[SLOPE]) > EVEN * np.sqrt(fit.covariance[SLOPE, SLOPE]))


def _first_guess(pair: Pair, base: Fit) -> Floats:
    """Return where the fit starts: the pulse of both windows' sum, and its rows' shares."""
    assert pair.unlit is not None
    background = min(float(np.median(pair.unlit)), float(np.median(pair.lit)))
    total = pair.lit + pair.unlit - 2.0 * background
    x, y = brightest(total)
    amplitude = max(float(total[int(y), int(x)]), 1.0)
    sigma = np.sqrt(max(float(total.sum()), amplitude) / (2.0 * np.pi * amplitude))
    height = total.shape[0]
    rows = np.arange(height) - 0.5 * (height - 1)
    near = np.maximum(total.sum(axis=1), 0.0)
    near = np.where(near > 0.1 * near.max(), near, 0.0)
    shares = (pair.lit - background).sum(axis=1) / np.maximum(near, 1.0)
    # A straight line through the shares of the rows, weighted with their light.
    middle = float((near * rows).sum() / max(near.sum(), 1.0))
    level = float((near * shares).sum() / max(near.sum(), 1.0))
    spread = float((near * (rows - middle) ** 2).sum())
    slope = float((near * (rows - middle) * shares).sum()) / max(spread, 1.0)
    return np.array([
        x, y, amplitude, background, sigma, 0.0, 0.0, level - slope * middle, slope, 0.0
    ])


def _fit_moving(pair: Pair, base: Fit, at_rest: Floats) -> Optimum | None:
    """Fit a light that moves: the likeliest of the fits that begin with this or that slope."""
    assert pair.unlit is not None
    guess = first_guess(pair, base)
    middle = 0.5 * (pair.lit.shape[0] - 1)
    starts = [at_rest]
    for slope in FIRST_SLOPES:
        share = FIRST_SHARE - slope * (guess[Y] - middle)
        starts.append(np.concatenate([
            guess[:SHARE], [share, slope, -slope * guess[SHIFT_Y]]
        ]))
        starts[-1][AMPLITUDE] += guess[GHOST]
    found = [fit for fit in (_fit(pair, each, moving=True) for each in starts) if fit is not None]
    return max(found, key=lambda fit: fit.log_likelihood, default=None)


def _fit(
    pair: Pair, start: Floats, *, moving: bool, held: Sequence[int] = ()
) -> Optimum | None:
    """Fit from a first guess, of which some parameters are held."""
    height, width = pair.lit.shape
    lower, upper = bounds(pair)
    away = np.array([width, height, FARTHEST]) if moving else np.zeros(3)
    lower = np.concatenate([lower, -away[:2], [-FARTHEST, -STEEPEST], -away[2:]])
    upper = np.concatenate([upper, away[:2], [FARTHEST, STEEPEST], away[2:]])
    for p in held:
        lower[p] = upper[p] = start[p]
    prior = shift_prior(pair, BEFORE, start.size)
    return climb(pair, fill_switched, start, lower, upper, prior)

"""A flash that switches while the rows of the light are exposed."""

from __future__ import annotations

from blob_tracker.location.alternatives.ghost import first_guess, lamp_is_likelier, shift_prior
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.pair_model import (
    bounds, brightest, fill_switched, SHARE, SLOPE, to_fit, Y,
)
from blob_tracker.location.unlit_pulse import outdoes_texture
from blob_tracker.location.unlit_shape import (
    BEFORE, EVEN, FARTHEST, STEEPEST, STILL_ON, SWITCHES,
)
import numpy as np


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
    moving = _fit(pair, start if fits[0] is None else fits[0].theta, moving=True)
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
    return to_fit(pair, best, warning)


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
        x, y, amplitude, background, sigma, 0.0, 0.0, level - slope * middle, slope
    ])


def _fit(pair: Pair, start: Floats, *, moving: bool) -> Optimum | None:
    height, width = pair.lit.shape
    lower, upper = bounds(pair)
    away = np.array([width, height]) if moving else np.zeros(2)
    lower = np.concatenate([lower, -away, [-FARTHEST, -STEEPEST]])
    upper = np.concatenate([upper, away, [FARTHEST, STEEPEST]])
    prior = shift_prior(pair, BEFORE, start.size)
    return climb(pair, fill_switched, start, lower, upper, prior)

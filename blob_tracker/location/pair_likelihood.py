"""Models of a lit and an unlit window together: their likelihood, and the climb to its top."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math

from blob_tracker.location.hypotheses import Pair
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Model = Callable[[Floats], tuple[Floats, Floats]]

STEPS = 40
CONVERGED = 1e-3  # gain in log-likelihood still to be had
# Variance of the texture over that of an unlit pixel, among which the likeliest is taken.
TEXTURES = np.concatenate([[0.0], np.geomspace(0.05, 2000.0, 14)])


@dataclass(frozen=True)
class Optimum:
    """
    The top of a model's likelihood.

    Parameters
    ----------
    theta : (p,) array
        Parameters.
    covariance : (p, p) array
        Inverse of their Fisher information.
    log_likelihood : float
        Of the pixels, without the constant of the normal distribution.
    texture : float
        Variance of what is common to both windows, DN^2.
    chi2 : float
        Squared residuals over their variance, per degree of freedom.
    residuals : (k, h, w) array
        Pixels less their means, DN.

    """

    theta: Floats
    covariance: Floats
    log_likelihood: float
    texture: float
    chi2: float
    residuals: Floats


def precisions(pair: Pair, means: Floats) -> Floats:
    """Return the (k, h, w) inverse variances of the pixels of these means; 0 where clipped."""
    noise = pair.noise
    variance = np.maximum(means, 0.0) / noise.gain + noise.read_noise**2 + 1.0 / 12.0
    return np.where(pair.usable, 1.0 / variance, 0.0)


def log_likelihood(
    residuals: Floats, precision: Floats, texture: float
) -> tuple[float, float]:
    """
    Return ln L of a pair's residuals, and the squares that are in it.

    What is behind the target is in both windows: a pixel's two residuals have the variances
    V_1 + T and V_2 + T and the covariance T. With p = 1 / V the inverse of that matrix is
    diag(p) - T p p^T / (1 + T (p_1 + p_2)) and its determinant (1 + T (p_1 + p_2)) / (p_1 p_2).
    """
    weighted = precision * residuals
    shared = 1.0 + texture * precision.sum(axis=0)
    squares = float((weighted * residuals).sum())
    squares -= float((texture * weighted.sum(axis=0) ** 2 / shared).sum())
    logarithms = float(np.log(shared).sum() - np.log(precision[precision > 0.0]).sum())
    return -0.5 * (squares + logarithms), squares


def likeliest_texture(residuals: Floats, precision: Floats) -> float:
    """Return the variance of the texture under which the residuals are likeliest, DN^2."""
    if len(residuals) < 2:
        return 0.0
    level = np.median(precision[1][precision[1] > 0.0]) if precision[1].any() else 1.0
    tried = [
        log_likelihood(residuals, precision, texture)[0] for texture in TEXTURES / level
    ]
    return float(TEXTURES[int(np.argmax(tried))] / level)


def climb(
    pair: Pair, model: Model, start: Floats, lower: Floats, upper: Floats
) -> Optimum | None:
    """
    Climb the likelihood of a model with damped Fisher scoring; None where there is no top.

    Parameters
    ----------
    pair : Pair
        The pixels.
    model : callable
        theta -> the (k, h, w) means and their (p, k, h, w) slopes.
    start, lower, upper : (p,) arrays
        First guess, and what the parameters are held between.

    """
    theta = np.clip(start, lower, upper)
    means, slopes = model(theta)
    residuals = pair.pixels - means
    precision = precisions(pair, means)
    texture = likeliest_texture(residuals, precision)
    value, squares = log_likelihood(residuals, precision, texture)
    damping, settled = 1e-3, False
    for _ in range(STEPS):
        score, fisher = _normal_equations(slopes, residuals, precision, texture)
        # A parameter at its bound that is pushed outward stays there.
        free = ~(((theta <= lower) & (score < 0.0)) | ((theta >= upper) & (score > 0.0)))
        free &= np.diag(fisher) > 0.0
        damped = fisher[np.ix_(free, free)]
        damped = damped + np.diag(damping * np.diag(damped))
        step = np.zeros_like(theta)
        try:
            step[free] = np.linalg.solve(damped, score[free])
        except np.linalg.LinAlgError:
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e8:
                break
            continue
        ahead = np.clip(theta + step, lower, upper)
        tried, ahead_slopes = model(ahead)
        left = pair.pixels - tried
        weights = precisions(pair, tried)
        reached, ahead_squares = log_likelihood(left, weights, texture)
        gain = reached - value
        promised = 0.5 * float(score @ step)
        if gain >= 0.0:
            theta, means, slopes, residuals, precision = ahead, tried, ahead_slopes, left, weights
            value, squares = reached, ahead_squares
            damping *= 0.2
            texture = likeliest_texture(residuals, precision)
            value, squares = log_likelihood(residuals, precision, texture)
        else:
            damping *= 8.0
        # The root of the score is not quite the top, as the variance moves with the mean.
        if promised < CONVERGED or (damping > 1e6 and promised < 0.1):
            settled = True
            break
        if damping > 1e8:
            break
    if not settled or not math.isfinite(value):
        return None
    _, fisher = _normal_equations(slopes, residuals, precision, texture)
    # What is at a bound is known to be there.
    inner = (theta > lower) & (theta < upper) & (np.diag(fisher) > 0.0)
    covariance = np.zeros_like(fisher)
    try:
        covariance[np.ix_(inner, inner)] = np.linalg.inv(fisher[np.ix_(inner, inner)])
    except np.linalg.LinAlgError:
        return None
    freedom = int((precision > 0.0).sum()) - int(inner.sum())
    return Optimum(theta, covariance, value, texture, squares / max(freedom, 1), residuals)


def _normal_equations(
    slopes: Floats, residuals: Floats, precision: Floats, texture: float
) -> tuple[Floats, Floats]:
    """Return the (p,) score and the (p, p) Fisher information."""
    count = len(slopes)
    weighted = (slopes * precision).reshape(count, -1)
    score = weighted @ residuals.ravel()
    fisher = weighted @ slopes.reshape(count, -1).T
    if texture > 0.0:
        shared = texture / (1.0 + texture * precision.sum(axis=0))
        both = (slopes * precision).sum(axis=1)
        score -= both.reshape(count, -1) @ (shared * (precision * residuals).sum(axis=0)).ravel()
        fisher -= (both * shared).reshape(count, -1) @ both.reshape(count, -1).T
    return score, fisher

"""The means of a lit and an unlit window and their slopes, for models of pulses."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.likelihood import fill_profile
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.scoring import NARROWEST, WIDEST
import numpy as np

FLATTERY = 12.0  # as in `maximum_likelihood`
BRIGHTEST = 1e7  # DN: of a fitted pulse, clipped or not
X, Y, AMPLITUDE, BACKGROUND, SIGMA = range(5)  # of each model's parameters, the first five


@kernel
def pulse_and_slopes(height: int, width: int, x: float, y: float, sigma: float) -> Array:
    """Return (4, h, w): a pulse of unit peak, and its slopes by x, y and sigma."""
    across = np.empty((3, width))
    down = np.empty((3, height))
    fill_profile(x, sigma, across)
    fill_profile(y, sigma, down)
    out = np.empty((4, height, width))
    for j in range(height):
        for i in range(width):
            out[0, j, i] = down[0, j] * across[0, i]
            out[1, j, i] = down[0, j] * across[1, i]
            out[2, j, i] = down[1, j] * across[0, i]
            out[3, j, i] = down[2, j] * across[0, i] + down[0, j] * across[2, i]
    return out


def bounds(pair: Pair) -> tuple[Floats, Floats]:
    """Return what x, y, amplitude, background and sigma are held between."""
    height, width = pair.lit.shape
    lower = np.array([-0.5, -0.5, 0.0, -BRIGHTEST, NARROWEST])
    upper = np.array([
        width - 0.5, height - 0.5, BRIGHTEST, BRIGHTEST, WIDEST * max(height, width)
    ])
    return lower, upper


def one_pulse(pair: Pair, start: Floats) -> Optimum | None:
    """Fit the pulse that is in the lit window alone: the base of every comparison."""
    height, width = pair.lit.shape

    def model(theta: Floats) -> tuple[Floats, Floats]:
        x, y, amplitude, background, sigma = theta
        pulse = pulse_and_slopes(height, width, x, y, sigma)
        means = np.full(pair.pixels.shape, background)
        means[0] += amplitude * pulse[0]
        slopes = np.zeros((5, *means.shape))
        slopes[X, 0] = amplitude * pulse[1]
        slopes[Y, 0] = amplitude * pulse[2]
        slopes[AMPLITUDE, 0] = pulse[0]
        slopes[BACKGROUND] = 1.0
        slopes[SIGMA, 0] = amplitude * pulse[3]
        return means, slopes

    return climb(pair, model, start, *bounds(pair))


def no_pulse(pair: Pair) -> Fit:
    """Return the fit of windows without a pulse, placed at the brightest lit pixels."""
    height, width = pair.lit.shape

    def model(theta: Floats) -> tuple[Floats, Floats]:
        shape = pair.pixels.shape
        return np.full(shape, theta[0]), np.ones((1, *shape))

    level = np.array([float(np.median(pair.pixels))])
    limit = np.array([BRIGHTEST])
    optimum = climb(pair, model, level, -limit, limit)
    x, y = brightest(pair.lit)
    return Fit(
        x, y, np.eye(2) * max(height, width) ** 2, 0.0, level[0], 1.0, 0.0, math.inf,
        -math.inf if optimum is None else optimum.log_likelihood, 1,
    )


def brightest(pixels: Floats) -> tuple[float, float]:
    """Return x and y of the pixel in the middle of the brightest 3 x 3, px."""
    padded = np.pad(pixels, 1, mode='edge')
    height, width = pixels.shape
    total = sum(
        padded[j:j + height, i:i + width] for j in range(3) for i in range(3)
    )
    row, column = np.unravel_index(int(np.argmax(total)), pixels.shape)
    return float(column), float(row)


def to_fit(pair: Pair, optimum: Optimum, warning: str = '') -> Fit:
    """Return the fit of a model whose first parameters are those of the lit pulse."""
    theta, noise = optimum.theta, pair.noise
    amplitude, background = theta[AMPLITUDE], theta[BACKGROUND]
    peak = max(amplitude + background, 0.0) / noise.gain + noise.read_noise**2 + 1.0 / 12.0
    deviation = math.sqrt(max(optimum.covariance[AMPLITUDE, AMPLITUDE], 1e-12))
    grown = 1.0 + FLATTERY * (deviation / max(amplitude, 1e-6)) ** 2
    return Fit(
        float(theta[X]), float(theta[Y]), grown * optimum.covariance[:2, :2], float(amplitude),
        float(background), float(theta[SIGMA]), float(amplitude / math.sqrt(peak)), optimum.chi2,
        optimum.log_likelihood, len(theta) + (optimum.texture > 0.0), warning,
    )

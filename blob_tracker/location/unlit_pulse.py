"""Whether the unlit window holds a pulse, or the texture of what is behind the target."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.hypotheses import Pair
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.pair_model import bounds, brightest, fill_elliptical, SIGMA
from blob_tracker.location.sites import lacks_samples
from blob_tracker.location.texture_field import log_likelihood, Modes, modes_of
from blob_tracker.types import SensorNoise
import numpy as np

WIDEST = 1.0 / 3.0  # of the window, a sigma
CLEARLY = 10.0  # likelier, of twice the log-likelihood: 150 to 1


def shows_pulse(pair: Pair) -> bool:
    """
    Return whether one pulse explains the unlit window better than a random texture.

    It may be of any height and of two widths, up to a third of the window: wider ones are slopes.
    """
    assert pair.unlit is not None
    samples = pair.unlit
    if pair.sites is not None:
        samples = np.ascontiguousarray(samples[pair.lattice])
    if is_texture(samples, pair.unlit_variance):
        return False
    alone = Pair(pair.unlit, None, pair.noise, pair.saturation, sites=pair.sites)
    lower, upper = bounds(alone)
    upper[SIGMA] = WIDEST * max(pair.unlit.shape)
    upper = np.append(upper, upper[SIGMA])
    level = float(np.median(alone.lit))
    x, y = brightest(alone.lit)
    peak = max(float(alone.lit[int(y), int(x)]) - level, 1.0)
    fit = climb(
        alone, fill_elliptical, np.array([x, y, peak, level, 1.5, 1.5]),
        np.append(lower, lower[SIGMA]), upper,
    )
    return fit is not None and _gain(pair, fit.means[0]) > 0.0


def is_texture(samples: Floats, variance: float) -> bool:
    """Return whether unlit pixels are likelier a random texture than any pulse, on any level."""
    return bool(_is_texture(samples, variance, modes_of(samples)))


def hides_no_pulse(lit: Floats, unlit: Floats, noise: SensorNoise) -> bool:
    """
    Return whether the unlit pixels of a window are a texture, in one compiled call.

    False, too, where some pixels are no samples: then it takes `shows_pulse` to tell.
    """
    return bool(texture_hides_no_pulse(
        lit, unlit, 1.0 / noise.gain, noise.read_noise**2 + 1.0 / 12.0, modes_of(unlit)
    ))


def outdoes_texture(pair: Pair, fit: Optimum) -> bool:
    """Return whether the unlit window is likelier to be the model's than a random texture."""
    return _gain(pair, fit.means[1]) > CLEARLY


@kernel
def texture_hides_no_pulse(
    lit: Array, unlit: Array, shot: float, floor: float, modes: Modes
) -> bool:
    """Return what `hides_no_pulse` does; `shot` is 1 / gain, `floor` the variance of darkness."""
    if lacks_samples(lit):
        return False
    mean = unlit.sum() / unlit.size
    return _is_texture(unlit, max(mean, 0.0) * shot + floor, modes)


@kernel
def _is_texture(samples: Array, variance: float, modes: Modes) -> bool:
    squares = _least_squares(samples)
    likeliest = -0.5 * (squares / variance + samples.size * math.log(variance))
    return log_likelihood(samples, modes, variance, likeliest) >= likeliest


@kernel
def _least_squares(pixels: Array) -> float:
    """
    Return what any pulse on any level leaves of the pixels at least, DN^2.

    Without the means of its rows and columns b + A g_y g_x^T is a matrix of rank 1, and none of
    that rank is nearer to another matrix C than by the squares of the singular values after its
    first one (Eckart and Young, Psychometrika 1 (1936)). Those squares are the eigenvalues of
    G = C C^T, of which none is above the fourth root of tr G^4.
    """
    height, width = pixels.shape
    centred = pixels - pixels.sum() / pixels.size
    for j in range(height):
        centred[j] -= centred[j].sum() / width
    for i in range(width):
        centred[:, i] -= centred[:, i].sum() / height
    products = _products_of_rows(centred)
    squares, fourths = 0.0, 0.0
    for j in range(height):
        squares += products[j, j]
    for row in _products_of_rows(products):
        for value in row:
            fourths += value * value
    return squares - fourths**0.25


@kernel
def _products_of_rows(matrix: Array) -> Array:
    """Return the product of a matrix and its transpose."""
    height, width = matrix.shape
    products = np.empty((height, height))
    for j in range(height):
        for k in range(j + 1):
            total = 0.0
            for i in range(width):
                total += matrix[j, i] * matrix[k, i]
            products[j, k] = products[k, j] = total
    return products


def _gain(pair: Pair, means: Floats) -> float:
    """Return twice the log-likelihood of the unlit window's means over that of a texture."""
    assert pair.unlit is not None
    left = (pair.unlit - means)[pair.lattice]
    told = _log_likelihood(pair, left.size, float((left**2).sum()))
    return 2.0 * (told - pair.log_likelihood_of_texture)


def _log_likelihood(pair: Pair, count: int, squares: float) -> float:
    """Return that of means which leave such squares of so many unlit samples, DN^2."""
    variance = pair.unlit_variance
    return -0.5 * (squares / variance + count * math.log(variance))

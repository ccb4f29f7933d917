"""The means of a lit and an unlit window and their slopes, for models of pulses."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.likelihood import fill_profile
from blob_tracker.location.pair_likelihood import climb, Floats, Optimum
from blob_tracker.location.scoring import COVARIANCE_INFLATION, NARROWEST_PX, WIDEST
import numpy as np

BRIGHTEST = 1e7  # DN: of a fitted pulse, clipped or not
X, Y, AMPLITUDE, BACKGROUND, SIGMA = 0, 1, 2, 3, 4  # of each model's parameters
SHIFT_X, SHIFT_Y = 5, 6  # from the lit frame to the unlit one
GHOST = 7  # amplitude of the light that is in the unlit window
OWN = 5  # sigma along y
SHARE, SLOPE = 7, 8  # of the light in the lit frame: in the middle row, and what a row adds
LATER = 9  # what the share of the unlit frame's flash is more, in all rows


@kernel
def add_pulse(
    means: Array, slopes: Array, x: float, y: float, amplitude: float, sigma: float,
    places: tuple[int, int, int],
) -> None:
    """
    Add a pulse to the (h, w) means, and its slopes to the (p, h, w) of the parameters.

    `places` are the indices of its x, y and amplitude among them; that of sigma is SIGMA.
    """
    height, width = means.shape
    across = np.empty((3, width))
    down = np.empty((3, height))
    fill_profile(x, sigma, across)
    fill_profile(y, sigma, down)
    for j in range(height):
        g, h, q = down[0, j], down[1, j], down[2, j]
        for i in range(width):
            gi, hi, qi = across[0, i], across[1, i], across[2, i]
            means[j, i] += amplitude * g * gi
            slopes[places[0], j, i] += amplitude * g * hi
            slopes[places[1], j, i] += amplitude * h * gi
            slopes[places[2], j, i] += g * gi
            slopes[SIGMA, j, i] += amplitude * (q * gi + g * qi)


@kernel
def fill_one_pulse(theta: Array, means: Array, slopes: Array) -> None:
    """Fill the means and slopes of a pulse that is in the lit window alone."""
    means[:] = theta[BACKGROUND]
    slopes[:] = 0.0
    slopes[BACKGROUND] = 1.0
    add_pulse(
        means[0], slopes[:, 0], theta[X], theta[Y], theta[AMPLITUDE], theta[SIGMA],
        (X, Y, AMPLITUDE),
    )


@kernel
def fill_background(theta: Array, means: Array, slopes: Array) -> None:
    """Fill the means and slopes of windows without a pulse."""
    means[:] = theta[0]
    slopes[:] = 1.0


@kernel
def fill_two_pulses(theta: Array, in_lit: float, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a pulse, and one in the unlit window.

    `in_lit` is the share of the second one that is in the lit window, too: 0 of a light that is
    left, 1 of a lamp behind the target. Where it is itself a parameter its slope is left out.
    """
    fill_one_pulse(theta, means, slopes)
    for k in range(2):
        share = 1.0 if k == 1 else in_lit
        if share > 0.0:
            _add_ghost(theta, share, 1.0, means[k], slopes[:, k])


def fill_dark_ghost(theta: Floats, means: Floats, slopes: Floats) -> None:
    """Fill the means and slopes of a pulse, and one in the unlit window alone."""
    fill_two_pulses(theta, 0.0, means, slopes)


def fill_static_ghost(theta: Floats, means: Floats, slopes: Floats) -> None:
    """Fill the means and slopes of a pulse, and one in both windows."""
    fill_two_pulses(theta, 1.0, means, slopes)


@kernel
def fill_smeared_ghost(theta: Array, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a pulse after a recursive filter in time.

    The share k of the last frame that is in each one is the share of the last pulse that is in
    the unlit frame, so that in the lit one it is there once more; of the flash before, as far
    away again, there is k^2 of that.
    """
    kept = theta[GHOST] / max(theta[AMPLITUDE], 1e-6)
    fill_two_pulses(theta, kept, means, slopes)
    for k in range(2):
        share = kept * kept * (1.0 if k == 1 else kept)
        _add_ghost(theta, share, 2.0, means[k], slopes[:, k])


@kernel
def _add_ghost(
    theta: Array, share: float, shifts: float, means: Array, slopes: Array
) -> None:
    """Add a share of the second pulse, whose place is that of the first and so many shifts."""
    own = np.zeros(slopes.shape)
    add_pulse(
        means, own, theta[X] + shifts * theta[SHIFT_X], theta[Y] + shifts * theta[SHIFT_Y],
        share * theta[GHOST], theta[SIGMA], (SHIFT_X, SHIFT_Y, GHOST),
    )
    slopes[X] += own[SHIFT_X]
    slopes[Y] += own[SHIFT_Y]
    slopes[SHIFT_X] += shifts * own[SHIFT_X]
    slopes[SHIFT_Y] += shifts * own[SHIFT_Y]
    slopes[GHOST] += share * own[GHOST]
    slopes[SIGMA] += own[SIGMA]


@kernel
def fill_switched(theta: Array, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a pulse whose rows are shared out between the two windows.

    Row j has the share s_j = SHARE + SLOPE (j - middle) of its light in the lit window, not
    below 0 nor above 1, and the rest in the unlit one. Of a light that moves, or whose clock
    drifts, the rows are cut LATER in the unlit one: there it is s_j + LATER.
    """
    windows, height, width = means.shape
    amplitude, sigma = theta[AMPLITUDE], theta[SIGMA]
    means[:] = theta[BACKGROUND]
    slopes[:] = 0.0
    slopes[BACKGROUND] = 1.0
    across = np.empty((3, width))
    down = np.empty((3, height))
    for k in range(windows):
        fill_profile(theta[X] + k * theta[SHIFT_X], sigma, across)
        fill_profile(theta[Y] + k * theta[SHIFT_Y], sigma, down)
        for j in range(height):
            row = j - 0.5 * (height - 1)
            share = theta[SHARE] + theta[SLOPE] * row + k * theta[LATER]
            moves = 1.0 if 0.0 < share < 1.0 else 0.0
            share = min(max(share, 0.0), 1.0)
            if k == 1:
                share, moves = 1.0 - share, -moves
            g, h, q = down[0, j], down[1, j], down[2, j]
            for i in range(width):
                gi, hi, qi = across[0, i], across[1, i], across[2, i]
                light = amplitude * g * gi
                means[k, j, i] += share * light
                slopes[X, k, j, i] = amplitude * share * g * hi
                slopes[Y, k, j, i] = amplitude * share * h * gi
                slopes[AMPLITUDE, k, j, i] = share * g * gi
                slopes[SIGMA, k, j, i] = amplitude * share * (q * gi + g * qi)
                slopes[SHIFT_X, k, j, i] = k * slopes[X, k, j, i]
                slopes[SHIFT_Y, k, j, i] = k * slopes[Y, k, j, i]
                slopes[SHARE, k, j, i] = moves * light
                slopes[SLOPE, k, j, i] = moves * row * light
                slopes[LATER, k, j, i] = k * moves * light


@kernel
def fill_elliptical(theta: Array, means: Array, slopes: Array) -> None:
    """Fill the means and slopes of a pulse of two widths that is in the lit window alone."""
    height, width = means.shape[1:]
    amplitude = theta[AMPLITUDE]
    means[:] = theta[BACKGROUND]
    slopes[:] = 0.0
    slopes[BACKGROUND] = 1.0
    across = np.empty((3, width))
    down = np.empty((3, height))
    fill_profile(theta[X], theta[SIGMA], across)
    fill_profile(theta[Y], theta[OWN], down)
    for j in range(height):
        for i in range(width):
            means[0, j, i] += amplitude * down[0, j] * across[0, i]
            slopes[X, 0, j, i] = amplitude * down[0, j] * across[1, i]
            slopes[Y, 0, j, i] = amplitude * down[1, j] * across[0, i]
            slopes[AMPLITUDE, 0, j, i] = down[0, j] * across[0, i]
            slopes[SIGMA, 0, j, i] = amplitude * down[0, j] * across[2, i]
            slopes[OWN, 0, j, i] = amplitude * down[2, j] * across[0, i]


def bounds(pair: Pair) -> tuple[Floats, Floats]:
    """Return what x, y, amplitude, background and sigma are held between."""
    height, width = pair.lit.shape
    lower = np.array([-0.5, -0.5, 0.0, -BRIGHTEST, NARROWEST_PX])
    upper = np.array([
        width - 0.5, height - 0.5, BRIGHTEST, BRIGHTEST, WIDEST * max(height, width)
    ])
    return lower, upper


def one_pulse(pair: Pair, start: Floats) -> Optimum | None:
    """Fit the pulse that is in the lit window alone: the base of every comparison."""
    return climb(pair, fill_one_pulse, start, *bounds(pair))


def no_pulse(pair: Pair) -> Fit:
    """Return the fit of windows without a pulse, placed at the brightest lit pixels."""
    height, width = pair.lit.shape
    level = np.array([float(np.median(pair.pixels))])
    limit = np.array([BRIGHTEST])
    optimum = climb(pair, fill_background, level, -limit, limit)
    x, y = brightest(pair.lit)
    return Fit(
        x, y, np.eye(2) * max(height, width) ** 2, 0.0, level[0], 1.0, 0.0, math.inf,
        -math.inf if optimum is None else optimum.log_likelihood, 1,
    )


@kernel
def brightest(pixels: Array) -> tuple[float, float]:
    """Return x and y of the pixel in the middle of the brightest 3 x 3, px."""
    height, width = pixels.shape
    most = -math.inf
    x, y = 0.0, 0.0
    for j in range(height):
        for i in range(width):
            total = 0.0
            for jj in range(j - 1, j + 2):
                for ii in range(i - 1, i + 2):
                    total += pixels[min(max(jj, 0), height - 1), min(max(ii, 0), width - 1)]
            if total > most:
                most, x, y = total, float(i), float(j)
    return x, y


def to_fit(pair: Pair, optimum: Optimum, warning: str = '') -> Fit:
    """Return the fit of a model whose first parameters are those of the lit pulse."""
    theta, noise = optimum.theta, pair.noise
    amplitude, background = theta[AMPLITUDE], theta[BACKGROUND]
    peak = max(amplitude + background, 0.0) / noise.gain + noise.read_noise**2 + 1.0 / 12.0
    deviation = math.sqrt(max(optimum.covariance[AMPLITUDE, AMPLITUDE], 1e-12))
    grown = 1.0 + COVARIANCE_INFLATION * (deviation / max(amplitude, 1e-6)) ** 2
    return Fit(
        float(theta[X]), float(theta[Y]), grown * optimum.covariance[:2, :2], float(amplitude),
        float(background), float(theta[SIGMA]), float(amplitude / math.sqrt(peak)), optimum.chi2,
        optimum.log_likelihood, optimum.parameters, warning,
    )

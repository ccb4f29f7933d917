"""Score tests of a finished fit: which windows may follow another model than one pulse."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.likelihood import Observation, Profiles
from blob_tracker.location.normal_equations import NormalEquations
import numpy as np
from numpy.typing import NDArray

# Each test lets one true window in 1e5 through to the alternatives, which take a millisecond.
QUANTILE = 4.26  # standard deviations of a normal variate
ODD_PIXELS = 5.0  # standard deviations of chi2: its upper tail is longer than the normal one
ODD_SHIFT = 11.5  # half a chi-square of two degrees of freedom
# The same, which noise exceeds once in 1000: a lean that is missed moves the place, and the
# alternatives are heard against better odds than these.
ODD_LEAN = 6.9
LEANING = 13.8  # a chi-square of two degrees of freedom that noise exceeds once in 1000
REACH_SIGMA = 3.5  # beyond it the slope of the pulse, even times r^2, is next to nothing
HEAD = 4.0  # times the coefficient of the lopsidedness: where the light's head is, measured


class Suspicion:
    """What is odd about a window beside its fit: bits, of which none is set where nothing is."""

    NONE = 0
    AXES = 1
    """The pulse is not as wide along y as along x."""
    ROWS = 2
    """The rows do not share the light as the pulse does."""
    PIXELS = 4
    """The pixels lie further from the fit than their noise."""
    UNLIT = 8
    """The unlit window holds light where the pulse is, or shifts it."""
    FAILED = 16
    """There is no fit, and there is light in the unlit window."""
    LOPSIDED = 32
    """The pulse's core and its wings do not have one middle."""
    RELIT = 64
    """The texture behind the light is brighter or darker in the lit frame."""
    IN_UNLIT = UNLIT | FAILED


_AXES, _ROWS, _PIXELS = Suspicion.AXES, Suspicion.ROWS, Suspicion.PIXELS
_UNLIT, _FAILED = Suspicion.UNLIT, Suspicion.FAILED
_LOPSIDED = Suspicion.LOPSIDED


@kernel
def quantile(freedom: float) -> float:
    """Return the chi-square that is exceeded once in 1e5 (Wilson and Hilferty, 1931)."""
    part = 2.0 / (9.0 * freedom)
    return float(freedom * (1.0 - part + QUANTILE * math.sqrt(part)) ** 3)


@kernel
def suspect_fit(equations: NormalEquations, rows: float, height: int, elliptical: bool) -> int:
    """
    Return what is odd about a fit that has settled; `equations` are those of its last step.

    The score test (Rao, 1948) of a width of its own along y: with s the score of that width, v
    its row of the Fisher information, and F, U, step = F^-1 U those of the fit's parameters,

        T = (s - v . step)^2 / (F_ss - v^T F^-1 v)

    is a chi-square of one degree of freedom where the pulse is round. `rows` is the sum over
    the rows of the square of the amplitude that a row's residuals lack, over its variance.
    """
    found = 0
    if rows > quantile(float(height)):
        found |= _ROWS
    if elliptical:
        return found
    matrix, right, factor, step = equations
    lack, spread = right[5], matrix[5, 5]
    half = np.empty(5)
    for p in range(5):
        row = matrix[5, p] + (matrix[5, 5] if p == 4 else 0.0)
        lack -= row * step[p]
        for q in range(p):
            row -= factor[p, q] * half[q]
        half[p] = row / factor[p, p]
        spread -= half[p] * half[p]
    if lack * lack > QUANTILE**2 * spread:
        found |= _AXES
    return found


@kernel
def suspect_pixels(chi2: float, freedom: int) -> int:
    """Return whether a chi2 per degree of freedom is more than the noise makes of it."""
    return _PIXELS if chi2 > 1.0 + ODD_PIXELS * math.sqrt(2.0 / freedom) else 0


@kernel
def lopsidedness(
    seen: Observation, theta: Array, profiles: Profiles, texture: Array, left: float,
    behind: float, out: Array,
) -> float:
    """
    Fill out with how lopsided the residuals of a fit are, and return its chi-square.

    The score test of a shift that grows with the distance r from the centre,

        d mu = c . grad_(x, y) mu (r / sigma)^2,

    which a tail, coma and a second light beside the pulse have and nothing even has. The texture
    behind the light is taken off, at the cost of its noise: a slope of the wall is no tail.

    Parameters
    ----------
    seen : Observation
        Pixels of which a share of the texture is taken off.
    theta, profiles
        The fit, and its profiles.
    texture : (h, w) array
        Departure of the unlit window from its mean, DN; 0 if there is none.
    left : float
        Share of it that is left in the pixels.
    behind : float
        Variance of an unlit pixel, DN^2; 0 if there is none.
    out : (4,) array
        Gets the scores of c along x and y and their variances' inverse, so that several windows'
        can be summed; c is their ratio, px.

    """
    pixels, extra, _, shot, floor = seen
    across, down = profiles
    height, width = pixels.shape
    a, b, scale = theta[2], theta[3], 1.0 / (theta[4] * theta[5])
    first = max(int(math.ceil(theta[0] - REACH_SIGMA * theta[4])), 0)
    last = min(int(theta[0] + REACH_SIGMA * theta[4]) + 1, width)
    top = max(int(math.ceil(theta[1] - REACH_SIGMA * theta[5])), 0)
    bottom = min(int(theta[1] + REACH_SIGMA * theta[5]) + 1, height)
    rmx, rmy, rsx, rsy = 0.0, 0.0, 0.0, 0.0
    mmx, mmy, msx, msy, ssx, ssy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(top, bottom):
        g, h = a * down[0, j], a * down[1, j]
        dy2 = (j - theta[1]) * (j - theta[1])
        for i in range(first, last):
            gi, hi = across[0, i], across[1, i]
            mean = g * gi + b
            used = 1.0 if extra[j, i] < math.inf else 0.0
            weight = used / max(mean * shot + floor + behind, floor)
            residual = weight * (pixels[j, i] - left * texture[j, i] - mean)
            far = scale * ((i - theta[0]) * (i - theta[0]) + dy2)
            sx, sy = g * hi, h * gi
            rmx += residual * far * sx
            rmy += residual * far * sy
            rsx += residual * sx
            rsy += residual * sy
            wx, wy = weight * sx * sx, weight * sy * sy
            ssx += wx
            ssy += wy
            msx += far * wx
            msy += far * wy
            mmx += far * far * wx
            mmy += far * far * wy
    if not (ssx > 0.0 and ssy > 0.0):
        out[:] = 0.0
        return 0.0
    out[0] = rmx - msx / ssx * rsx
    out[1] = rmy - msy / ssy * rsy
    out[2] = mmx - msx * msx / ssx
    out[3] = mmy - msy * msy / ssy
    if not (out[2] > 0.0 and out[3] > 0.0):
        out[:] = 0.0
        return 0.0
    return float(out[0] * out[0] / out[2] + out[1] * out[1] / out[3])


def lean(sums: NDArray[np.float64]) -> float:
    """Return the chi-square of lopsidedness from its scores and their variances' inverse."""
    score_x, score_y, x, y = sums.tolist()
    return float(score_x**2 / x + score_y**2 / y) if x > 0.0 and y > 0.0 else 0.0


@kernel
def suspect_lopsided(leaning: float) -> int:
    """Return whether the chi-square of the lopsidedness is more than noise makes of it."""
    return _LOPSIDED if leaning > 2.0 * ODD_LEAN else 0


@kernel
def suspect_unlit(evidence: float, pulse: float) -> int:
    """
    Return whether the unlit window holds a light that matters.

    `evidence` is half the Mahalanobis square of the shift that it lends to the position, and
    `pulse` what a pulse near the lit one's place takes off its squares.
    """
    return _UNLIT if evidence > ODD_SHIFT or pulse > quantile(5.0) else 0


@kernel
def suspect_failure(white: float, usable: int) -> int:
    """Return whether a window without a fit has more in its unlit pixels than their noise."""
    return _FAILED if (1.0 + white) * (usable - 1) > quantile(usable - 1.0) else 0


def suspicions(code: NDArray[np.uint8]) -> list[tuple[int, int]]:
    """Return the windows about which anything is odd, and what it is, see `Suspicion`."""
    return [(n, suspicion) for n, suspicion in enumerate(code.tolist()) if suspicion]

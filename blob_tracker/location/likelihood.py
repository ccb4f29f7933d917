"""The likelihood of a window's pixels: its value, its slope and its Fisher information."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel, written_into_kernels
from blob_tracker.location.normal_equations import NormalEquations
import numpy as np

_SQRT2 = math.sqrt(2.0)
_SQRT_HALF_PI = math.sqrt(math.pi / 2.0)


class Observation(NamedTuple):
    """
    The pixels of one window and their noise.

    Pixel k has the mean mu_k = A g_x g_y + b and the variance V_k = shot mu_k + extra_k.

    Parameters
    ----------
    pixels : (h, w) array
        DN.
    extra : (h, w) array
        Variance beyond the shot noise of the mean, DN^2; infinite where the pixel is clipped.
    prior : (2,) array
        What is known of b beforehand, DN, and the inverse of its variance; 0 where nothing is.
    shot : float
        1 / gain, DN an electron.
    floor : float
        Variance of a dark pixel, DN^2.

    """

    pixels: Array
    extra: Array
    prior: Array
    shot: float
    floor: float


class Profiles(NamedTuple):
    """
    The pulse along either axis: its value and its slopes by centre and by sigma.

    Parameters
    ----------
    across, down : (3, w) and (3, h) arrays
        As `integrated_profile` returns them; memory to be used again.

    """

    across: Array
    down: Array


@kernel
def empty_profiles(height: int, width: int) -> Profiles:
    """Return the memory for them."""
    return Profiles(np.empty((3, width)), np.empty((3, height)))


@kernel
def fill_profile(centre: float, sigma: float, out: Array) -> None:
    """Fill out with `integrated_profile`: value, by centre, by sigma, each (count,)."""
    inverse = 1.0 / (_SQRT2 * sigma)
    edge = (-0.5 - centre) * inverse
    bell = math.exp(-edge * edge)
    area = math.erf(edge)
    for k in range(out.shape[1]):
        next_edge = (k + 0.5 - centre) * inverse
        next_bell = math.exp(-next_edge * next_edge)
        next_area = math.erf(next_edge)
        value = _SQRT_HALF_PI * sigma * (next_area - area)
        out[0, k] = value
        out[1, k] = bell - next_bell
        out[2, k] = value / sigma - _SQRT2 * (next_edge * next_bell - edge * bell)
        edge, bell, area = next_edge, next_bell, next_area


class RowSums(NamedTuple):
    """
    Sums over a row of pixels: 1, g, h, q and their products under the weight, and the residual.

    g, h and q are the pulse along x and its slopes by centre and by sigma; a row needs these
    fourteen sums whatever the number of parameters, since each derivative is a product of a
    factor along x and one along y.
    """

    one: float
    g: float
    h: float
    q: float
    gg: float
    gh: float
    gq: float
    hh: float
    hq: float
    qq: float
    residual: float
    residual_g: float
    residual_h: float
    residual_q: float


@kernel
def add_row(
    equations: NormalEquations, a: float, g: float, h: float, q: float, sums: RowSums
) -> None:
    """Add a row, at which the pulse along y is g and its slopes h and q, to the equations."""
    fisher, score = equations.matrix, equations.right
    s1, sg, sh, sq, sgg, sgh, sgq, shh, shq, sqq, r1, rg, rh, rq = sums
    ag, ah, aq = a * g, a * h, a * q
    fisher[0, 0] += ag * ag * shh
    fisher[1, 0] += ag * ah * sgh
    fisher[1, 1] += ah * ah * sgg
    fisher[2, 0] += ag * g * sgh
    fisher[2, 1] += ah * g * sgg
    fisher[2, 2] += g * g * sgg
    fisher[3, 0] += ag * sh
    fisher[3, 1] += ah * sg
    fisher[3, 2] += g * sg
    fisher[3, 3] += s1
    fisher[4, 0] += ag * ag * shq
    fisher[4, 1] += ag * ah * sgq
    fisher[4, 2] += ag * g * sgq
    fisher[4, 3] += ag * sq
    fisher[4, 4] += ag * ag * sqq
    fisher[5, 0] += ag * aq * sgh
    fisher[5, 1] += ah * aq * sgg
    fisher[5, 2] += aq * g * sgg
    fisher[5, 3] += aq * sg
    fisher[5, 4] += ag * aq * sgq
    fisher[5, 5] += aq * aq * sgg
    score[0] += ag * rh
    score[1] += ah * rg
    score[2] += g * rg
    score[3] += r1
    score[4] += ag * rq
    score[5] += aq * rg


@kernel
def join_widths(equations: NormalEquations) -> None:
    """Let one sigma move both widths: its row is the sum of theirs."""
    fisher, score = equations.matrix, equations.right
    for p in range(4):
        fisher[4, p] += fisher[5, p]
    fisher[4, 4] += 2.0 * fisher[5, 4] + fisher[5, 5]
    score[4] += score[5]


@kernel
def score_and_information(
    seen: Observation, theta: Array, profiles: Profiles, elliptical: bool,
    equations: NormalEquations,
) -> tuple[float, float]:
    """
    Fill the equations with the Fisher information and the score at theta; return chi2 and rows.

    The erf and exp are taken once a row and column. `rows` is the sum over the rows of the
    square of the amplitude that a row's residuals lack, over its variance.
    """
    pixels, extra, prior, shot, floor = seen
    across, down = profiles
    fisher, score = equations.matrix, equations.right
    height, width = pixels.shape
    fill_profile(theta[0], theta[4], across)
    fill_profile(theta[1], theta[5], down)
    a, b = theta[2], theta[3]
    fisher[:] = 0.0
    score[:] = 0.0
    chi2, rows = 0.0, 0.0
    for j in range(height):
        g, h, q = down[0, j], down[1, j], down[2, j]
        peak = a * g
        s1, sg, sh, sq = 0.0, 0.0, 0.0, 0.0
        sgg, sgh, sgq, shh, shq, sqq = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        r1, rg, rh, rq = 0.0, 0.0, 0.0, 0.0
        for i in range(width):
            gi, hi, qi = across[0, i], across[1, i], across[2, i]
            mean = peak * gi + b
            weight = 1.0 / max(mean * shot + extra[j, i], floor)
            residual = pixels[j, i] - mean
            wr = weight * residual
            wg = weight * gi
            wh = weight * hi
            wq = weight * qi
            chi2 += wr * residual
            s1 += weight
            sg += wg
            sh += wh
            sq += wq
            sgg += wg * gi
            sgh += wg * hi
            sgq += wg * qi
            shh += wh * hi
            shq += wh * qi
            sqq += wq * qi
            r1 += wr
            rg += wr * gi
            rh += wr * hi
            rq += wr * qi
        sums = RowSums(
            s1, sg, sh, sq, sgg, sgh, sgq, shh, shq, sqq, r1, rg, rh, rq
        )
        add_row(equations, a, g, h, q, sums)
        if sgg > 0.0:
            rows += rg * rg / sgg
    fisher[3, 3] += prior[1]
    score[3] += prior[1] * (prior[0] - b)
    if not elliptical:
        join_widths(equations)
    return chi2, rows


@written_into_kernels
def pixel_log_likelihood(
    pixel: float, mean: float, extra: float, shot: float, floor: float
) -> float:
    """
    Return a pixel's part of the log-likelihood whose slope is the score.

    The integral over the mean m of (z - m) / V(m), V = shot m + extra, from z: with
    u = V(m) / V(z) - 1 it is V(z) (ln(1 + u) - u) / shot^2.
    """
    variance = max(shot * pixel + extra, floor)
    u = max(shot * mean + extra, floor) / variance - 1.0
    if abs(u) < 1e-3 or shot == 0.0:
        value = -((pixel - mean) ** 2) / (2.0 * variance) * (1.0 - 2.0 / 3.0 * u)
    else:
        value = variance * (math.log(1.0 + u) - u) / shot**2
    return value


@kernel
def log_likelihood(seen: Observation, theta: Array, profiles: Profiles) -> float:
    """Return the log-likelihood whose slope is the score, up to a constant."""
    pixels, extra, prior, shot, floor = seen
    across, down = profiles
    height, width = pixels.shape
    fill_profile(theta[0], theta[4], across)
    fill_profile(theta[1], theta[5], down)
    value = -0.5 * prior[1] * (theta[3] - prior[0]) ** 2
    for j in range(height):
        for i in range(width):
            if extra[j, i] < math.inf:
                mean = theta[2] * across[0, i] * down[0, j] + theta[3]
                value += pixel_log_likelihood(pixels[j, i], mean, extra[j, i], shot, floor)
    return value

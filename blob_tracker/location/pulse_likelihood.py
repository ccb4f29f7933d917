"""The likelihood of a window with a learned pulse, its slopes, and the climb to its top."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.effective_psf import fill_images, Images, Surface
from blob_tracker.location.likelihood import Observation, pixel_log_likelihood
from blob_tracker.location.normal_equations import NormalEquations, solve
from blob_tracker.location.scoring import CONVERGED, DAMPED_STEPS
from blob_tracker.location.unlit_texture import share_of, Unlit

# Of the scale: beyond it the lens draws another pulse, not a larger one.
SMALLEST, LARGEST = 0.4, 2.5


class Work(NamedTuple):
    """
    Memory of a fit, to be used again.

    Parameters
    ----------
    images : Images
        The pulse and its slopes.
    weights, residuals : (h, w) arrays
        Inverse variance, 1/DN^2, and pixel less mean, DN.
    equations : NormalEquations
        Of x, y, amplitude, background and scale.

    """

    images: Images
    weights: Array
    residuals: Array
    equations: NormalEquations


@kernel
def _fill_equations(
    images: Images, weights: Array, residuals: Array, amplitude: float,
    equations: NormalEquations,
) -> float:
    """Fill the Fisher information and the score; return chi2."""
    values = images.values
    fisher, score = equations.matrix, equations.right
    height, width = weights.shape
    xx, xy, yy, xg, yg, gg, x1, y1, g1, s1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    xq, yq, gq, q1, qq = 0.0, 0.0, 0.0, 0.0, 0.0
    rx, ry, rg, r1, rq, chi2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(height):
        for i in range(width):
            g, x, y, q = values[0, j, i], values[1, j, i], values[2, j, i], values[3, j, i]
            w, r = weights[j, i], residuals[j, i]
            wr, wx, wy, wg, wq = w * r, w * x, w * y, w * g, w * q
            chi2 += wr * r
            s1 += w
            x1 += wx
            y1 += wy
            g1 += wg
            q1 += wq
            xx += wx * x
            xy += wx * y
            xg += wx * g
            xq += wx * q
            yy += wy * y
            yg += wy * g
            yq += wy * q
            gg += wg * g
            gq += wg * q
            qq += wq * q
            r1 += wr
            rx += wr * x
            ry += wr * y
            rg += wr * g
            rq += wr * q
    a, aa = amplitude, amplitude * amplitude
    fisher[0, 0] = aa * xx
    fisher[1, 0] = aa * xy
    fisher[1, 1] = aa * yy
    fisher[2, 0] = a * xg
    fisher[2, 1] = a * yg
    fisher[2, 2] = gg
    fisher[3, 0] = a * x1
    fisher[3, 1] = a * y1
    fisher[3, 2] = g1
    fisher[3, 3] = s1
    fisher[4, 0] = aa * xq
    fisher[4, 1] = aa * yq
    fisher[4, 2] = a * gq
    fisher[4, 3] = a * q1
    fisher[4, 4] = aa * qq
    score[0] = a * rx
    score[1] = a * ry
    score[2] = rg
    score[3] = r1
    score[4] = a * rq
    return chi2


@kernel
def score_and_information(
    seen: Observation, theta: Array, surface: Surface, work: Work
) -> float:
    """Fill the equations at theta: x, y, amplitude, background, scale; return chi2."""
    pixels, extra, prior, shot, floor = seen
    images, weights, residuals, equations = work
    fill_images(surface, theta[0], theta[1], theta[4], images)
    values = images.values
    a, b = theta[2], theta[3]
    height, width = pixels.shape
    for j in range(height):
        for i in range(width):
            mean = a * values[0, j, i] + b
            weights[j, i] = 1.0 / max(mean * shot + extra[j, i], floor)
            residuals[j, i] = pixels[j, i] - mean
    chi2 = _fill_equations(images, weights, residuals, a, equations)
    equations.matrix[3, 3] += prior[1]
    equations.right[3] += prior[1] * (prior[0] - b)
    return chi2


@kernel
def log_likelihood(seen: Observation, theta: Array, values: Array) -> float:
    """Return the log-likelihood whose slope is the score, as `likelihood.log_likelihood` does."""
    pixels, extra, prior, shot, floor = seen
    value = -0.5 * prior[1] * (theta[3] - prior[0]) ** 2
    height, width = pixels.shape
    for j in range(height):
        for i in range(width):
            if extra[j, i] < math.inf:
                mean = theta[2] * values[0, j, i] + theta[3]
                value += pixel_log_likelihood(pixels[j, i], mean, extra[j, i], shot, floor)
    return value


@kernel
def texture_share(
    unlit: Unlit, seen: Observation, theta: Array, surface: Surface, work: Work
) -> tuple[float, float, float]:
    """Return the share of the texture to take off, E and a chi2, as `texture_share` does."""
    images, weights, _, equations = work
    fill_images(surface, theta[0], theta[1], theta[4], images)
    height, width = weights.shape
    for j in range(height):
        for i in range(width):
            weights[j, i] = 1.0 if seen.extra[j, i] < math.inf else 0.0
    _fill_equations(images, weights, unlit.texture, theta[2], equations)
    variance = max(unlit.mean, 0.0) * seen.shot + seen.floor
    return share_of(equations, unlit.white, variance, theta[2])


@kernel
def advance(theta: Array, equations: NormalEquations, size: int, reach: float) -> float:
    """Take the step, no longer than the model stays true for; return score . step."""
    score, step = equations.right, equations.solution
    gain = 0.0
    for p in range(size):
        gain += score[p] * step[p]
    for p in range(2):
        theta[p] += min(max(step[p], -reach), reach)
    theta[2] = min(max(theta[2] + step[2], 0.3 * theta[2]), 10.0 * theta[2])
    theta[3] += step[3]
    if size == 5:
        scale = min(max(theta[4] + step[4], 0.8 * theta[4]), 1.25 * theta[4])
        theta[4] = min(max(scale, SMALLEST), LARGEST)
    return gain


@kernel
def climb(
    seen: Observation, theta: Array, surface: Surface, work: Work, size: int, reach: float
) -> bool:
    """Climb the likelihood with damped steps, each of which must rise; True at the top."""
    equations = work.equations
    last = theta.copy()
    damping, gain = 1e-2, math.inf
    score_and_information(seen, theta, surface, work)
    best = log_likelihood(seen, theta, work.images.values)
    for _ in range(DAMPED_STEPS):
        if not solve(equations, size, damping):
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e8:
                return False
            continue
        last[:] = theta
        gain = advance(theta, equations, size, reach)
        score_and_information(seen, theta, surface, work)
        value = log_likelihood(seen, theta, work.images.values)
        rise = value - best
        if rise >= 0.0:
            best = value
            if gain < CONVERGED and rise < CONVERGED and damping <= 1.0:
                return True
            damping *= 0.2
        else:
            theta[:] = last
            score_and_information(seen, theta, surface, work)
            if gain < CONVERGED and damping <= 1.0:
                return True
            damping *= 8.0
            if damping > 1e8:
                return False
    return False


@kernel
def likely_levels(seen: Observation, theta: Array, surface: Surface, work: Work) -> float:
    """Set amplitude and background to the best at this place; return what they take off chi2."""
    pixels, extra, prior, shot, floor = seen
    fill_images(surface, theta[0], theta[1], theta[4], work.images)
    values = work.images.values
    height, width = pixels.shape
    s1, g1, gg, z1, zg = prior[1], 0.0, 0.0, prior[1] * prior[0], 0.0
    for j in range(height):
        for i in range(width):
            weight = 1.0 / max(pixels[j, i] * shot + extra[j, i], floor)
            g, z = values[0, j, i], pixels[j, i]
            s1 += weight
            g1 += weight * g
            gg += weight * g * g
            z1 += weight * z
            zg += weight * g * z
    spread = gg - g1 * g1 / s1
    if not spread > 0.0:
        return -math.inf
    amplitude = (zg - z1 * g1 / s1) / spread
    theta[2] = max(amplitude, 1e-3)
    theta[3] = (z1 - theta[2] * g1) / s1
    return amplitude * abs(amplitude) * spread

"""Maximum likelihood with a pulse that was learned, in place of the Gaussian."""

from __future__ import annotations

from functools import lru_cache
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.effective_psf import (
    EffectivePsf, empty_images, fill_images, Images, Surface, surface_of,
)
from blob_tracker.location.estimates import Estimates, Failure
from blob_tracker.location.likelihood import Observation
from blob_tracker.location.normal_equations import (
    column_of_inverse, empty_equations, NormalEquations, solve,
)
from blob_tracker.location.scoring import (
    CONVERGED, COVARIANCE_INFLATION, DAMPED_STEPS, FAINTEST_SIGMA, FISHER_STEPS, MISFIT_SIGMA,
    TEXTURE_STEP,
)
from blob_tracker.location.sites import fill_absent, observe
from blob_tracker.location.start_value import start_value
from blob_tracker.location.suspicion import suspect_failure, suspect_pixels, suspect_unlit
from blob_tracker.location.unlit_texture import (
    blend, residual_variance, share_of, split_unlit, Unlit,
)
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

# Of the scale: beyond it the lens draws another pulse, not a larger one.
SMALLEST, LARGEST = 0.4, 2.5
STEP_PX = 0.5  # of a position at a time, or half a sigma where that is more
GRID = 64  # points along an axis, of which the pulse's half-height shape is had

_ROWS = 7  # of the table: x, y, amplitude, background, sigma, snr, chi2
_NONE, _NO_SIGNAL, _OUTSIDE = int(Failure.NONE), int(Failure.NO_SIGNAL), int(Failure.OUTSIDE)
_FEW, _DIVERGED = int(Failure.TOO_FEW_PIXELS), int(Failure.NOT_CONVERGED)
_NARROW, _WIDE = int(Failure.TOO_NARROW), int(Failure.TOO_WIDE)


class Pulse(NamedTuple):
    """
    The pulse as the kernel takes it.

    Parameters
    ----------
    surface : Surface
        Its spline.
    sigma : float
        Of the Gaussian nearest to it, px.
    half : (3,) array
        Of what is above half its peak: x and y of the middle, px, and the area, px^2.
    common : (2, 2) array
        `EffectivePsf.covariance`.
    size : int
        Parameters that are fitted: 5, or 4 without the scale.

    """

    surface: Surface
    sigma: float
    half: Array
    common: Array
    size: int


@lru_cache(maxsize=8)
def pulse_of(pulse: EffectivePsf, varies: bool | None = None) -> Pulse:
    """Return what the kernel takes; `varies` overrides what the pulse says of its scale."""
    along = np.linspace(-pulse.reach, pulse.reach, GRID)
    value = pulse.value(along[None, :], along[:, None])
    above = value > 0.5 * value.max()
    rows, columns = np.nonzero(above)
    area = float(above.sum()) * (along[1] - along[0]) ** 2
    half = np.array([along[columns].mean(), along[rows].mean(), area])
    free = pulse.varies if varies is None else varies
    return Pulse(
        surface_of(pulse), float(pulse.sigma), half,
        np.ascontiguousarray(pulse.covariance, dtype=float), 5 if free else 4,
    )


def learned_pulse(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    pulse: Pulse,
) -> tuple[Estimates, NDArray[np.uint8]]:
    """
    Locate N blobs by Fisher scoring, as `maximum_likelihood` does, with a learned pulse.

    The mean of pixel (k, l) is A P((k - x) / s, (l - y) / s) + b with the surface P of
    `EffectivePsf`. The likelihood, the share of the unlit window's texture, the clipped pixels
    and the growth of the covariance for faint pulses and for misfits are those of
    `maximum_likelihood`. To the covariance that of the pulse's own error is added.

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit may be None. Contiguous float64.
    noise : SensorNoise
        Gain and read noise.
    saturation : float or None
        DN of a clipped pixel.
    pulse : Pulse
        From `pulse_of`.

    Returns
    -------
    estimates : Estimates
        As those of `maximum_likelihood`; TOO_NARROW and TOO_WIDE where the blob is less than
        0.4 or more than 2.5 times as large as what was learned.
    odd : (N,) uint8 array
        The `Suspicion` about each window; 0 where the pulse explains it.

    """
    count = lit.shape[0]
    table = np.zeros((_ROWS, count))
    covariance = np.zeros((count, 2, 2))
    clipped = np.zeros(count, dtype=np.int64)
    failure = np.zeros(count, dtype=np.uint8)
    odd = np.zeros(count, dtype=np.uint8)
    _fit_all(
        lit,
        lit[:0] if unlit is None else unlit,
        1.0 / noise.gain,
        noise.read_noise**2 + 1.0 / 12.0,
        math.inf if saturation is None else float(saturation),
        pulse,
        table,
        covariance,
        clipped,
        failure,
        odd,
    )
    return Estimates.from_table(table, covariance, clipped, failure), odd


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
def _score_and_information(
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
def _log_likelihood(seen: Observation, theta: Array, values: Array) -> float:
    """Return the log-likelihood whose slope is the score, as `likelihood.log_likelihood` does."""
    pixels, extra, prior, shot, floor = seen
    value = -0.5 * prior[1] * (theta[3] - prior[0]) ** 2
    height, width = pixels.shape
    for j in range(height):
        for i in range(width):
            if extra[j, i] < math.inf:
                mean = theta[2] * values[0, j, i] + theta[3]
                residual = pixels[j, i] - mean
                variance = max(shot * pixels[j, i] + extra[j, i], floor)
                u = max(shot * mean + extra[j, i], floor) / variance - 1.0
                if abs(u) < 1e-3 or shot == 0.0:
                    value -= residual**2 / (2.0 * variance) * (1.0 - 2.0 / 3.0 * u)
                else:
                    value += variance * (math.log(1.0 + u) - u) / shot**2
    return value


@kernel
def _texture_share(
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
def _advance(theta: Array, equations: NormalEquations, size: int, reach: float) -> float:
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
def _climb(
    seen: Observation, theta: Array, surface: Surface, work: Work, size: int, reach: float
) -> bool:
    """Climb the likelihood with damped steps, each of which must rise; True at the top."""
    equations = work.equations
    last = theta.copy()
    damping, gain = 1e-2, math.inf
    _score_and_information(seen, theta, surface, work)
    best = _log_likelihood(seen, theta, work.images.values)
    for _ in range(DAMPED_STEPS):
        if not solve(equations, size, damping):
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e8:
                return False
            continue
        last[:] = theta
        gain = _advance(theta, equations, size, reach)
        _score_and_information(seen, theta, surface, work)
        value = _log_likelihood(seen, theta, work.images.values)
        rise = value - best
        if rise >= 0.0:
            best = value
            if gain < CONVERGED and rise < CONVERGED and damping <= 1.0:
                return True
            damping *= 0.2
        else:
            theta[:] = last
            _score_and_information(seen, theta, surface, work)
            if gain < CONVERGED and damping <= 1.0:
                return True
            damping *= 8.0
            if damping > 1e8:
                return False
    return False


@kernel
def _likely(seen: Observation, theta: Array, surface: Surface, work: Work) -> float:
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


@kernel
def _start(
    seen: Observation, lit: Array, saturation: float, paired: bool, mean: float, pulse: Pulse,
    work: Work, theta: Array, other: Array,
) -> None:
    """
    Fill theta with the likelier of two guesses.

    The one is about the brightest pixels, where other light is in the window; the other is the
    middle of all that is above half the peak, for a pulse that is dark where its middle is.
    """
    start_value(seen.pixels, lit, saturation, paired, mean, other)
    for p in range(2):
        theta[p] = other[p] - pulse.half[p]
    theta[4] = 1.0
    level = other[3]
    best = _likely(seen, theta, pulse.surface, work)
    pixels = seen.pixels
    height, width = pixels.shape
    top = -math.inf
    for j in range(height):
        for i in range(width):
            top = max(top, pixels[j, i])
    half = level + 0.5 * (top - level)
    x, y, total = 0.0, 0.0, 0.0
    for j in range(height):
        for i in range(width):
            if pixels[j, i] > half or lit[j, i] >= saturation:
                x += i
                y += j
                total += 1.0
    scale = 1.0
    if pulse.size == 5:
        scale = min(max(math.sqrt(total / pulse.half[2]), 0.6), 1.6)
    for look in range(2):
        # At its own scale, and at that of the half height.
        other[4] = 1.0 if look == 0 else scale
        other[0] = x / total - other[4] * pulse.half[0]
        other[1] = y / total - other[4] * pulse.half[1]
        value = _likely(seen, other, pulse.surface, work)
        if value > best:
            best = value
            theta[:5] = other[:5]
        if pulse.size == 4:
            break


@kernel
def _fit_all(
    lit: Array,
    unlit: Array,
    shot: float,
    floor: float,
    saturation: float,
    pulse: Pulse,
    table: Array,
    covariance: Array,
    clipped: NDArray[np.int64],
    failure: NDArray[np.uint8],
    odd: NDArray[np.uint8],
) -> None:
    """Fit each window; `shot` is 1 / gain, `floor` the variance of a dark pixel, DN^2."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    surface, size = pulse.surface, pulse.size
    seen = Observation(
        np.empty((height, width)), np.empty((height, width)), np.zeros(2), shot, floor
    )
    texture = np.zeros((height, width))
    work = Work(
        empty_images(height, width, surface.coefficients.shape[0]), np.empty((height, width)),
        np.empty((height, width)), empty_equations(),
    )
    equations = work.equations
    fisher, column = equations.matrix, equations.solution
    theta, start, other = np.empty(6), np.empty(6), np.empty(6)
    reach = max(0.5 * pulse.sigma, STEP_PX)
    for n in range(count):
        usable, mean = observe(
            n, lit[n], unlit[n] if paired else lit[n], paired, saturation, seen, texture, clipped
        )
        if usable < size + 1:
            failure[n] = _FEW
            continue
        white = 0.0
        share, evidence, bright = 0.0, 0.0, 0.0
        if paired:
            mean /= usable
            white = split_unlit(texture, seen.extra, mean, shot, floor, usable)
            share = 1.0
            blend(lit[n], Unlit(texture, mean, white), share, seen)
        if usable < height * width:
            fill_absent(seen.pixels, lit[n])
        _start(seen, lit[n], saturation, paired, mean, pulse, work, start, other)
        theta[:] = start
        done = False
        chi2 = 0.0
        for iteration in range(FISHER_STEPS):
            if paired and iteration == TEXTURE_STEP:
                behind_it = Unlit(texture, mean, white)
                share, evidence, bright = _texture_share(behind_it, seen, theta, surface, work)
                blend(lit[n], behind_it, share, seen)
            chi2 = _score_and_information(seen, theta, surface, work)
            if not solve(equations, size, 0.0):
                break
            gain = _advance(theta, equations, size, reach)
            if gain < CONVERGED and (not paired or iteration >= TEXTURE_STEP):
                done = True
                break
        if not done:
            theta[:] = start
            done = _climb(seen, theta, surface, work, size, reach)
            chi2 = _score_and_information(seen, theta, surface, work)
            done = done and solve(equations, size, 0.0)
        failure[n] = _judge(theta, done, fisher, height, width)
        if failure[n] != _NONE:
            odd[n] = suspect_failure(white, usable) if paired else 0
            continue
        odd[n] = suspect_unlit(evidence, bright)
        chi2 /= usable - size
        scale, left = 1.0, 0.0
        if paired:
            left = residual_variance(share, white)
            chi2 *= (1.0 + left) / (1.0 + max(left, share**2 + (1.0 - share) ** 2 * white))
        if chi2 > 1.0 + MISFIT_SIGMA * math.sqrt(2.0 / (usable - size)):
            scale = chi2
        odd[n] |= suspect_pixels(chi2, usable - size)
        scale *= 1.0 + COVARIANCE_INFLATION / _detection(theta, fisher)
        common = theta[4] ** 2
        column_of_inverse(equations, size, 0)
        covariance[n, 0, 0] = scale * column[0] + common * pulse.common[0, 0]
        covariance[n, 0, 1] = scale * column[1] + common * pulse.common[0, 1]
        covariance[n, 1, 0] = covariance[n, 0, 1]
        column_of_inverse(equations, size, 1)
        covariance[n, 1, 1] = scale * column[1] + common * pulse.common[1, 1]
        peak = max(theta[2] + theta[3], 0.0) * shot + floor
        peak += left * (max(mean, 0.0) * shot + floor)
        table[0, n] = theta[0]
        table[1, n] = theta[1]
        table[2, n] = theta[2]
        table[3, n] = theta[3]
        table[4, n] = pulse.sigma * theta[4]
        table[5, n] = theta[2] / math.sqrt(peak)
        table[6, n] = chi2


@kernel
def _judge(theta: Array, done: bool, fisher: Array, height: int, width: int) -> int:
    """Return the failure of a fit, or none."""
    for p in range(5):
        if not abs(theta[p]) < math.inf:
            return _DIVERGED
    if theta[4] <= 1.0001 * SMALLEST:
        return _NARROW
    if theta[4] >= 0.9999 * LARGEST:
        return _WIDE
    if not done:
        return _DIVERGED
    inside = -0.5 <= theta[0] <= width - 0.5 and -0.5 <= theta[1] <= height - 0.5
    if not inside:
        return _OUTSIDE
    if not (theta[2] > 0.0 and _detection(theta, fisher) > FAINTEST_SIGMA**2):
        return _NO_SIGNAL
    return _NONE


@kernel
def _detection(theta: Array, fisher: Array) -> float:
    """Return the squared SNR of the amplitude in its shape: of a matched filter."""
    return theta[2] ** 2 * (fisher[2, 2] - fisher[3, 2] ** 2 / fisher[3, 3])

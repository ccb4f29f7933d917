"""Maximum likelihood with a pulse that was learned, in place of the Gaussian."""

from __future__ import annotations

from functools import lru_cache
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.effective_psf import EffectivePsf, empty_images, Surface, surface_of
from blob_tracker.location.estimates import Estimates, Failure
from blob_tracker.location.likelihood import Observation
from blob_tracker.location.normal_equations import column_of_inverse, empty_equations, solve
from blob_tracker.location.pulse_likelihood import (
    advance, climb, LARGEST, likely_levels, score_and_information, SMALLEST, texture_share, Work,
)
from blob_tracker.location.scoring import (
    CONVERGED, covariance_growth, detection, FISHER_STEPS, is_vague, judge_optimum, TEXTURE_STEP,
)
from blob_tracker.location.sites import fill_absent, observe
from blob_tracker.location.start_value import start_value
from blob_tracker.location.suspicion import suspect_failure, suspect_pixels, suspect_unlit
from blob_tracker.location.unlit_texture import blend, residual_variance, split_unlit, Unlit
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

STEP_PX = 0.5  # of a position at a time, or half a sigma where that is more
GRID = 64  # points along an axis, of which the pulse's half-height shape is had

_ROWS = 7  # of the table: x, y, amplitude, background, sigma, snr, chi2
_NONE, _FEW = int(Failure.NONE), int(Failure.TOO_FEW_PIXELS)
_DIVERGED, _VAGUE = int(Failure.NOT_CONVERGED), int(Failure.VAGUE)
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


def compile_fit(pulse: EffectivePsf) -> None:
    """Fit a pulse to its own image, so that the loops are compiled or loaded before a light is."""
    lit = 100.0 * pulse.image((9, 9), 4.0, 4.0)[None] + 10.0
    noise = SensorNoise(gain=1.0, read_noise=1.0)
    learned_pulse(lit, np.full_like(lit, 10.0), noise, math.inf, pulse_of(pulse))


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
        As those of `maximum_likelihood`, also VAGUE; TOO_NARROW and TOO_WIDE where the blob is
        less than 0.4 or more than 2.5 times as large as what was learned.
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
    best = likely_levels(seen, theta, pulse.surface, work)
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
        value = likely_levels(seen, other, pulse.surface, work)
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
                share, evidence, bright = texture_share(behind_it, seen, theta, surface, work)
                blend(lit[n], behind_it, share, seen)
            chi2 = score_and_information(seen, theta, surface, work)
            if not solve(equations, size, 0.0):
                break
            gain = advance(theta, equations, size, reach)
            if gain < CONVERGED and (not paired or iteration >= TEXTURE_STEP):
                done = True
                break
        if not done:
            theta[:] = start
            done = climb(seen, theta, surface, work, size, reach)
            chi2 = score_and_information(seen, theta, surface, work)
            done = done and solve(equations, size, 0.0)
        failure[n] = _judge(theta, done, fisher, height, width)
        if failure[n] != _NONE:
            odd[n] = suspect_failure(white, usable) if paired else 0
            continue
        odd[n] = suspect_unlit(evidence, bright)
        chi2 /= usable - size
        left = 0.0
        if paired:
            left = residual_variance(share, white)
            chi2 *= (1.0 + left) / (1.0 + max(left, share**2 + (1.0 - share) ** 2 * white))
        odd[n] |= suspect_pixels(chi2, usable - size)
        scale = covariance_growth(chi2, usable - size, detection(theta, fisher))
        common = theta[4] ** 2
        column_of_inverse(equations, size, 0)
        covariance[n, 0, 0] = scale * column[0] + common * pulse.common[0, 0]
        covariance[n, 0, 1] = scale * column[1] + common * pulse.common[0, 1]
        covariance[n, 1, 0] = covariance[n, 0, 1]
        column_of_inverse(equations, size, 1)
        covariance[n, 1, 1] = scale * column[1] + common * pulse.common[1, 1]
        if odd[n] == 0 and is_vague(covariance[n], scale, (pulse.sigma * theta[4]) ** 2):
            failure[n] = _VAGUE
            continue
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
    return judge_optimum(theta, done, fisher, height, width)

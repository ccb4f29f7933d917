"""The steps of Fisher scoring: bounded, and damped where they must be to rise."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Failure
from blob_tracker.location.likelihood import (
    log_likelihood,
    Observation,
    Profiles,
    score_and_information,
)
from blob_tracker.location.normal_equations import NormalEquations, solve

# Of a matched filter's standard deviations: below it noise is found, not light
FAINTEST_SIGMA = 5.0
# Over the matched filter's squared SNR: how far the covariance is too small
COVARIANCE_INFLATION = 12.0
# Of the pulse's sigma: of a place that is known less well the slopes of the pulse tell the wrong
# covariance.
MOST_VAGUE = 2.0
MISFIT_SIGMA = 5.0  # standard deviations of chi2: beyond it the model is wrong, not the noise
FISHER_STEPS = 12  # a good start takes 4 or 5
TEXTURE_STEP = 2  # by which the pulse is known well enough to ask what the texture does to it
NARROWEST_PX = 0.2  # px: below it one pixel holds 99 % of the light and its place there is lost
WIDEST = 2.0  # times the window: a wider pulse is a slope, its amplitude and level are one
DAMPED_STEPS = 80
CONVERGED = 1e-4  # twice the gain in log-likelihood still to be had: 0.01 standard deviations

_NONE, _NO_SIGNAL, _OUTSIDE = int(Failure.NONE), int(Failure.NO_SIGNAL), int(Failure.OUTSIDE)
_DIVERGED = int(Failure.NOT_CONVERGED)


@kernel
def detection(theta: Array, fisher: Array) -> float:
    """Return the squared SNR of the amplitude in its shape: of a matched filter."""
    return theta[2] ** 2 * (fisher[2, 2] - fisher[3, 2] ** 2 / fisher[3, 3])


@kernel
def judge_optimum(theta: Array, done: bool, fisher: Array, height: int, width: int) -> int:
    """Return the failure of a fit whose width is in order, or none."""
    if not done:
        return _DIVERGED
    inside = -0.5 <= theta[0] <= width - 0.5 and -0.5 <= theta[1] <= height - 0.5
    if not inside:
        return _OUTSIDE
    if not (theta[2] > 0.0 and detection(theta, fisher) > FAINTEST_SIGMA**2):
        return _NO_SIGNAL
    return _NONE


@kernel
def covariance_growth(chi2: float, freedom: int, squared_snr: float) -> float:
    """Return by how much a misfit (chi2 a degree of freedom) and faintness let it grow."""
    growth = 1.0 + COVARIANCE_INFLATION / squared_snr
    if chi2 > 1.0 + MISFIT_SIGMA * math.sqrt(2.0 / freedom):
        growth *= chi2
    return growth


@kernel
def is_vague(covariance: Array, growth: float, squared_width: float) -> bool:
    """Tell whether noise alone leaves a place as wide as MOST_VAGUE times its pulse, px^2."""
    widest = max(covariance[0, 0], covariance[1, 1])
    return widest > growth * MOST_VAGUE**2 * squared_width


@kernel
def advance(theta: Array, equations: NormalEquations, size: int, extent: int) -> float:
    """Take the step, no longer than the model stays true for; return score . step."""
    score, step = equations.right, equations.solution
    gain = 0.0
    for p in range(size):
        gain += score[p] * step[p]
    for p in range(2):
        reach = max(theta[4 + p], 0.5)
        theta[p] += min(max(step[p], -reach), reach)
    theta[2] = min(max(theta[2] + step[2], 0.3 * theta[2]), 10.0 * theta[2])
    theta[3] += step[3]
    for p in range(4, 6):
        width = theta[p] + step[min(p, size - 1)]
        width = min(max(width, 0.6 * theta[p]), 1.7 * theta[p])
        theta[p] = min(max(width, NARROWEST_PX), WIDEST * extent)
    return gain


@kernel
def climb(
    seen: Observation, theta: Array, profiles: Profiles, elliptical: bool,
    equations: NormalEquations, size: int,
) -> bool:
    """
    Climb the likelihood with damped steps, each of which must rise; True at the top.

    For the windows where plain scoring does not settle: faint, cut by the edge, or two pulses.
    """
    extent = max(seen.pixels.shape)
    last = theta.copy()
    damping = 1e-2
    best = log_likelihood(seen, theta, profiles)
    for _ in range(DAMPED_STEPS):
        score_and_information(seen, theta, profiles, elliptical, equations)
        if not solve(equations, size, damping):
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e8:
                return False
            continue
        last[:] = theta
        gain = advance(theta, equations, size, extent)
        value = log_likelihood(seen, theta, profiles)
        if value >= best:
            rise = value - best
            best = value
            # A heavily damped step is short of the top however small its gain.
            if gain < CONVERGED and rise < CONVERGED and damping <= 1.0:
                return True
            damping *= 0.2
        else:
            theta[:] = last
            if gain < CONVERGED and damping <= 1.0:
                return True
            damping *= 8.0
            if damping > 1e8:
                return False
    return False

"""Maximum likelihood: the pixel-integrated Gaussian, fitted at the Cramer-Rao bound."""

from __future__ import annotations

from collections.abc import Callable
import math

from blob_tracker.kernel import Array, kernel, written_into_kernels
from blob_tracker.location.coarse import WIDEST as WIDEST_FINE_PX
from blob_tracker.location.contract import flag_invalid, validate
from blob_tracker.location.doubt import LOPSIDED_LIGHT
from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimate, Estimates, Failure
from blob_tracker.location.explain import explain, is_explained
from blob_tracker.location.hypotheses import Fit, History, Way
from blob_tracker.location.learned_pulse import learned_pulse, pulse_of
from blob_tracker.location.likelihood import empty_profiles, Observation, score_and_information
from blob_tracker.location.normal_equations import (
    column_of_inverse, empty_equations, NormalEquations, solve,
)
from blob_tracker.location.relit import is_relit, relit
from blob_tracker.location.scoring import (
    advance, climb, CONVERGED, covariance_growth, detection, FISHER_STEPS, is_vague,
    judge_optimum, NARROWEST_PX, TEXTURE_STEP, WIDEST,
)
from blob_tracker.location.sites import fill_absent, observe, pair_of
from blob_tracker.location.start_value import start_value
from blob_tracker.location.suspicion import (
    HEAD, lean, LEANING, lopsidedness, ODD_SHIFT, suspect_failure, suspect_fit, suspect_lopsided,
    suspect_pixels, suspect_unlit, Suspicion, suspicions,
)
from blob_tracker.location.texture_field import Modes, modes_of_size
from blob_tracker.location.unlit_pulse import shows_pulse, texture_hides_no_pulse
from blob_tracker.location.unlit_texture import (
    blend, residual_variance, split_unlit, texture_share, Unlit,
)
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

WARNED_CHI2 = 3.0  # beyond which a misfit is spoken of, whatever its kind
ANOTHER_PULSE = (
    'the learned pulse does not fit, and the Gaussian is fitted: it was learned at another size, '
    'focus or wavelength; learn it again (calibrate pulse), or leave pulse_url empty'
)

_ROWS = 11  # of the table: x, y, amplitude, background, sigma, snr, chi2, and from here on
_LOPSIDED = 7  # how lopsided it is
_NONE, _FEW = int(Failure.NONE), int(Failure.TOO_FEW_PIXELS)
_DIVERGED, _VAGUE = int(Failure.NOT_CONVERGED), int(Failure.VAGUE)
_RELIT, _IN_UNLIT = Suspicion.RELIT, Suspicion.IN_UNLIT
# The pixels that are fitted in one call: those of frames and of their sums, and all others
AT_ONCE_TYPES = tuple(map(np.dtype, (np.uint8, np.uint16, np.float64)))
NO_MODES = Modes(*2 * (np.empty((0, 0, 0)), np.empty((0, 0))))  # where nobody asks for a texture
_NARROW, _WIDE = int(Failure.TOO_NARROW), int(Failure.TOO_WIDE)


def maximum_likelihood(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    *,
    elliptical: bool = False,
    history: Callable[[], History] = History,
    pulse: EffectivePsf | None = None,
    way: Way | None = None,
) -> Estimates:
    r"""
    Locate N blobs by Fisher scoring on the likelihood of their pixels.

    The mean of pixel k is mu_k = A g_x g_y + b with the pixel-integrated Gaussian of
    `integrated_profile`, its variance V_k = mu_k / gain + read_noise^2 + 1/12. The score and
    the Fisher information of theta = (x, y, A, b, sigma)

        U_p = sum_k (z_k - mu_k) (d mu_k / d p) / V_k
        I_pq = sum_k (d mu_k / d p)(d mu_k / d q) / V_k          (Huang et al., Nature Methods
                                                                  10 (2013), eq. 3.6)

    give the step theta += I^-1 U and, at its end, the covariance I^-1. The clipped pixels are
    left out of every sum.

    With an unlit window the light behind the target is known, with as much noise again. Of the
    unlit window's texture (its departure from its mean) a share kappa is taken off the lit
    pixels: 0 is lit-only with the mean known, 1 is lit minus unlit. With E half the Mahalanobis
    square of the shift that the texture would lend to the fitted position,

        kappa = max(0, 1 - SHRINKAGE / E)                    (James and Stein, 1961)

    whose rms is, for any one texture that is weak beside the pulse, at most 1.09 times that of
    the better of lit-only and lit minus unlit. A texture that is strong beside the pulse is
    taken off whatever it shifts. The covariance holds the noise that the share brings and the
    texture that it leaves.

    The information at a faint pulse's estimate outdoes that at the truth, since the fit leans
    toward bright and narrow: the covariance grows by 1 + 12 / S^2, S being the SNR of a matched
    filter (4 % at S = 18). The form is the next order of the expansion, the 12 is measured over
    sigma 0.6 to 2.5 px and S from 8 to 40.

    Where chi2 says that the pulse is no Gaussian, or the noise not the one given, the
    covariance grows by chi2, unless `explain` knows better; where the pulse leans to one side, by
    the square of the distance from its head.

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit may be None. Contiguous float64.
    noise : SensorNoise
        Gain and read noise.
    saturation : float or None
        DN of a clipped pixel.
    elliptical : bool
        Fit a width along x and one along y in place of one for both.
    history : callable
        Returns what the light's last flashes say of this one: what a ghost in the unlit window is
        told by, and which of two models that fit as well. Called where something is odd.
    pulse : EffectivePsf or None
        Fit this one, and the Gaussian only if it does not fit the window or the Gaussian
        explains the window better. `elliptical` is for the Gaussian.
    way : Way or None
        Of the light while it is exposed: what a streak is fitted with if there is no unlit
        window to tell it from the scene.

    Returns
    -------
    Estimates
        Failure TOO_FEW_PIXELS where fewer are left than parameters plus one, NO_SIGNAL where
        the amplitude is below five of the standard deviations that it has in its shape,
        OUTSIDE where the pulse's centre leaves the window, TOO_NARROW and TOO_WIDE where its
        width does not tell its place, NOT_CONVERGED where the likelihood has no peak to climb,
        VAGUE where the place is known less well than twice the pulse's width.

    """
    if pulse is not None:
        return _with_pulse(lit, unlit, noise, saturation, pulse, elliptical, history, way)
    estimates, odd = fit_gaussians(lit, unlit, noise, saturation, elliptical=elliptical)
    limit = math.inf if saturation is None else float(saturation)
    for n, suspicion in suspicions(odd):
        fit = None
        behind = None if unlit is None else unlit[n]
        seen, unsure = noise, np.zeros(2)
        if behind is not None and suspicion & Suspicion.RELIT:
            suspicion &= ~Suspicion.RELIT
            # What a camera that averages over time has kept of a light is in both frames, too.
            if not shows_pulse(pair_of(lit[n], behind, noise, limit)):
                suspicion, behind, seen, unsure = _relight(
                    estimates, n, lit[n], behind, noise, limit, elliptical
                )
        if not is_explained(lit[n], behind, seen, suspicion):
            pair = pair_of(
                lit[n], behind, seen, limit, history=history(), way=way,
                haunted=bool(suspicion & Suspicion.IN_UNLIT),
            )
            theta = np.array([
                estimates.x[n], estimates.y[n], estimates.amplitude[n], estimates.background[n],
                estimates.sigma[n],
            ])
            fit = explain(pair, theta if estimates.failure[n] == _NONE else None, suspicion)
        if fit is not None:
            _adopt(estimates, n, fit)
        elif suspicion & Suspicion.LOPSIDED and lean(estimates.lopsided[n]) > 2.0 * ODD_SHIFT:
            estimates.warnings[n] = LOPSIDED_LIGHT
        elif estimates.chi2[n] > WARNED_CHI2:
            estimates.warnings[n] = (
                f'misfit (chi2 {estimates.chi2[n]:.1f}): the light is not a Gaussian, or the '
                'scene behind it is uneven: flash it, or learn its pulse (calibrate pulse)'
            )
        estimates.covariance[n] += np.outer(unsure, unsure)
    return estimates


def _relight(
    estimates: Estimates, n: int, lit: NDArray[np.float64], unlit: NDArray[np.float64],
    noise: SensorNoise, limit: float, elliptical: bool,
) -> tuple[int, NDArray[np.float64], SensorNoise, NDArray[np.float64]]:
    """
    Fit window n anew, its unlit pixels as bright as the scene of the lit ones.

    Returns
    -------
    tuple
        What is odd about it then; the unlit pixels and their noise; and by how much the place
        goes if the gain is another by its standard deviation, px.

    """
    suspicion, behind, seen, unsure = 0, unlit, noise, np.zeros(2)
    # Twice: the wings of the first fit are those of a light before another scene.
    for _ in range(2):
        light = (
            float(estimates.x[n]), float(estimates.y[n]), float(estimates.amplitude[n]),
            float(estimates.sigma[n]),
        )
        scene = relit(lit, unlit, noise, limit, light)
        if scene is None:
            break
        again, odd = fit_gaussians(
            np.stack([lit, lit]), np.stack([scene.unlit, scene.other]), scene.noise, limit,
            elliptical=elliptical,
        )
        estimates.take(n, again)
        estimates.lopsided[n] = again.lopsided[0]
        estimates.warnings[n] = scene.warning
        suspicion, behind, seen = int(odd[0]) & ~Suspicion.RELIT, scene.unlit, scene.noise
        if not again.ok.all():
            break
        unsure = np.array([again.x[1] - again.x[0], again.y[1] - again.y[0]])
    return suspicion, behind, seen, unsure


def fit_gaussians(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    *,
    elliptical: bool = False,
) -> tuple[Estimates, NDArray[np.uint8]]:
    """
    Fit the Gaussian alone, as `maximum_likelihood` does before it asks what else may be true.

    Returns
    -------
    estimates : Estimates
        Of N windows.
    odd : (N,) uint8 array
        The `Suspicion` about each.

    """
    table = np.zeros((_ROWS, lit.shape[0]))
    covariance = np.zeros((lit.shape[0], 2, 2))
    clipped = np.zeros(lit.shape[0], dtype=np.int64)
    failure = np.zeros(lit.shape[0], dtype=np.uint8)
    odd = np.zeros(lit.shape[0], dtype=np.uint8)
    _fit_all(
        lit,
        lit[:0] if unlit is None else unlit,
        1.0 / noise.gain,
        noise.read_noise**2 + 1.0 / 12.0,
        math.inf if saturation is None else float(saturation),
        bool(elliptical),
        table,
        covariance,
        clipped,
        failure,
        odd,
    )
    estimates = Estimates.from_table(
        table[:_LOPSIDED], covariance, clipped, failure, table[_LOPSIDED:].T
    )
    return estimates, odd


def at_once(
    lit: NDArray[np.generic],
    unlit: NDArray[np.generic] | None,
    noise: SensorNoise,
    saturation: float,
    *,
    elliptical: bool,
) -> Estimate | None:
    """
    Do to one (h, w) window what `locate_batch` does by `maximum_likelihood`, in one compiled call.

    None if that fails or something is odd about the window: then it takes more than that.
    `saturation` is infinite where no pixel can be clipped. The pixels are of the types that the
    kernels take, see `compile_at_once`, and still have their black level.
    """
    modes = NO_MODES if unlit is None or min(lit.shape) > WIDEST_FINE_PX else (
        modes_of_size(*lit.shape)
    )
    (
        sound, covariance, clipped, x, y, amplitude, background, sigma, snr, chi2, *lopsided,
    ) = _fit_pixels(
        lit, lit[:0] if unlit is None else unlit, noise.black_level, 1.0 / noise.gain,
        noise.read_noise**2 + 1.0 / 12.0, saturation, elliptical, modes,
    )
    if not sound:
        return None
    return Estimate(x, y, amplitude, background, sigma, snr, chi2, clipped, covariance, lopsided)


def compile_at_once() -> None:
    """Compile that for the pixels of all frames, or load it."""
    pulse = np.zeros((7, 7))
    pulse[2:5, 2:5] = 100.0
    noise = SensorNoise(gain=1.0, read_noise=1.0)
    for kind in AT_ONCE_TYPES:
        lit = pulse.astype(kind)
        at_once(lit, np.zeros_like(lit), noise, math.inf, elliptical=False)


def _with_pulse(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    pulse: EffectivePsf,
    elliptical: bool,
    history: Callable[[], History],
    way: Way | None,
) -> Estimates:
    """Fit the pulse, and in the windows that it does not explain the Gaussian."""
    found, odd = learned_pulse(lit, unlit, noise, saturation, pulse_of(pulse))
    silent = (found.failure == Failure.NO_SIGNAL) | (found.failure == Failure.VAGUE)
    failed = ~found.ok & ~silent
    doubtful = np.flatnonzero(failed | (found.ok & (odd != 0)))
    if not doubtful.size:
        return found
    other = maximum_likelihood(
        lit[doubtful], None if unlit is None else unlit[doubtful], noise, saturation,
        elliptical=elliptical, history=history, way=way,
    )
    for k, n in enumerate(doubtful):
        if failed[n] or (other.ok[k] and other.chi2[k] < found.chi2[n]):
            found.take(int(n), other, k)
            for name in ('warnings', 'evidence', 'beside', 'drawn', 'ways', 'other_models'):
                if k in getattr(other, name):
                    getattr(found, name)[int(n)] = getattr(other, name)[k]
            if other.ok[k] and k not in other.other_models:
                found.warnings.setdefault(int(n), ANOTHER_PULSE)
    return found


def _adopt(estimates: Estimates, n: int, fit: Fit) -> None:
    """Put a fit in the place of a window's estimates."""
    for name in ('x', 'y', 'covariance', 'amplitude', 'background', 'sigma', 'snr', 'chi2'):
        getattr(estimates, name)[n] = getattr(fit, name)
    estimates.failure[n] = fit.failure
    estimates.evidence[n] = fit.evidence
    if fit.beside is not None:
        estimates.beside[n] = fit.beside
    if fit.drawn:
        estimates.drawn[n] = fit.drawn
    if fit.way is not None:
        estimates.ways[n] = fit.way
    estimates.other_models[n] = fit.log_likelihood, fit.parameters
    if fit.warning:
        estimates.warnings[n] = fit.warning


@kernel
def _fit_pixels(
    lit: NDArray[np.generic],
    unlit: NDArray[np.generic],
    black_level: float,
    shot: float,
    floor: float,
    saturation: float,
    elliptical: bool,
    modes: Modes,
) -> tuple[
    bool, Array, int, float, float, float, float, float, float, float, float, float, float, float
]:
    """
    Fit one window of raw pixels.

    Returns
    -------
    tuple
        Whether it has a location, and all that is odd about it is a texture that both frames show;
        (2, 2) covariance, px^2; its clipped pixels, and the table.

    """
    seen, behind = np.empty(lit.shape), np.empty(unlit.shape)
    for j in range(lit.shape[0]):
        for i in range(lit.shape[1]):
            seen[j, i] = float(lit[j, i]) - black_level
    for j in range(unlit.shape[0]):
        for i in range(unlit.shape[1]):
            behind[j, i] = float(unlit[j, i]) - black_level
    covariance = np.zeros((1, 2, 2))
    (
        sound, odd, clipped, x, y, amplitude, background, sigma, snr, chi2, score_x, score_y,
        inverse_x, inverse_y,
    ) = _fit_one(seen, behind, shot, floor, saturation - black_level, elliptical, covariance)
    if sound and odd != 0:
        # `explain` has no other answer then than that it is no other model, and takes much longer.
        sound = chi2 <= WARNED_CHI2 and odd & ~_IN_UNLIT == 0 and modes.rows.shape[1] > 0 and (
            texture_hides_no_pulse(seen, behind, shot, floor, modes)
        )
    return (
        sound, covariance[0], clipped, x, y, amplitude, background + black_level, sigma, snr,
        chi2, score_x, score_y, inverse_x, inverse_y,
    )


@kernel
def _fit_one(
    lit: Array,
    unlit: Array,
    shot: float,
    floor: float,
    saturation: float,
    elliptical: bool,
    covariance: Array,
) -> tuple[
    bool, int, int, float, float, float, float, float, float, float, float, float, float, float
]:
    """Fit one window; return whether it has a location, what is odd, its clipped pixels, table."""
    height, width = lit.shape
    one = lit.reshape((1, height, width))
    behind = one[:0]
    if unlit.shape[0] > 0:
        behind = unlit.reshape((1, height, width))
    table = np.zeros((_ROWS, 1))
    clipped = np.zeros(1, dtype=np.int64)
    failure, odd = np.zeros(1, dtype=np.uint8), np.zeros(1, dtype=np.uint8)
    invalid = np.zeros(1, dtype=np.uint8)
    flag_invalid(one, behind if unlit.shape[0] > 0 else one, saturation, invalid)
    if invalid[0] == _NONE:
        _fit_all(
            one, behind, shot, floor, saturation, elliptical, table, covariance, clipped, failure,
            odd,
        )
    validate(
        table[0], table[1], covariance, table[2], table[3], table[4], table[5], table[6],
        (height, width), invalid, failure,
    )
    return (
        failure[0] == _NONE, int(odd[0]), clipped[0], table[0, 0], table[1, 0], table[2, 0],
        table[3, 0], table[4, 0], table[5, 0], table[6, 0], table[7, 0], table[8, 0], table[9, 0],
        table[10, 0],
    )


@kernel
def _fit_all(
    lit: Array,
    unlit: Array,
    shot: float,
    floor: float,
    saturation: float,
    elliptical: bool,
    table: Array,
    covariance: Array,
    clipped: NDArray[np.int64],
    failure: NDArray[np.uint8],
    odd: NDArray[np.uint8],
) -> None:
    """Fit each window; `shot` is 1 / gain, `floor` the variance of a dark pixel, DN^2."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    size = 6 if elliptical else 5
    seen = Observation(
        np.empty((height, width)), np.empty((height, width)), np.zeros(2), shot, floor
    )
    texture = np.zeros((height, width))
    profiles = empty_profiles(height, width)
    theta = np.empty(6)
    start = np.empty(6)
    lopsided = np.empty(4)
    equations = empty_equations()
    fisher = equations.matrix
    for n in range(count):
        usable, mean = observe(
            n, lit[n], unlit[n] if paired else lit[n], paired, saturation, seen, texture, clipped
        )
        if usable < size + 1:
            failure[n] = _FEW
            continue
        white = 0.0
        share, evidence, pulse = 0.0, 0.0, 0.0
        if paired:
            mean /= usable
            white = split_unlit(texture, seen.extra, mean, shot, floor, usable)
            # Lit minus unlit to start from: bright texture must not be taken for the target.
            share = 1.0
            blend(lit[n], Unlit(texture, mean, white), share, seen)
        if usable < height * width:
            fill_absent(seen.pixels, lit[n])
        start_value(seen.pixels, lit[n], saturation, paired, mean, start)
        theta[:] = start
        done = False
        for iteration in range(FISHER_STEPS):
            if paired and iteration == TEXTURE_STEP:
                behind_it = Unlit(texture, mean, white)
                share, evidence, pulse = texture_share(
                    behind_it, seen, theta, profiles, equations
                )
                blend(lit[n], behind_it, share, seen)
            chi2, rows = score_and_information(seen, theta, profiles, elliptical, equations)
            if not solve(equations, size, 0.0):
                break
            gain = advance(theta, equations, size, max(height, width))
            if gain < CONVERGED and (not paired or iteration >= TEXTURE_STEP):
                done = True
                break
        if not done:
            theta[:] = start
            done = climb(seen, theta, profiles, elliptical, equations, size)
            chi2, rows = score_and_information(seen, theta, profiles, elliptical, equations)
            done = done and solve(equations, size, 0.0)
        failure[n] = _judge(theta, done, fisher, height, width)
        if failure[n] != _NONE:
            odd[n] = suspect_failure(white, usable) if paired else 0
            continue
        odd[n] = suspect_unlit(evidence, pulse)
        odd[n] |= suspect_fit(equations, rows, height, elliptical)
        unlit_variance = max(mean, 0.0) * shot + floor if paired else 0.0
        leaning = lopsidedness(
            seen, theta, profiles, texture, 1.0 - share, unlit_variance, lopsided
        )
        table[_LOPSIDED:, n] = lopsided
        odd[n] |= suspect_lopsided(leaning)
        if paired and is_relit(lit[n], unlit[n], saturation, theta, white, unlit_variance):
            odd[n] |= _RELIT
        chi2 /= usable - size
        left = 0.0
        if paired:
            # Texture that was left in widens the residuals, beyond what it does to the position.
            left = residual_variance(share, white)
            chi2 *= (1.0 + left) / (1.0 + max(left, share**2 + (1.0 - share) ** 2 * white))
        odd[n] |= suspect_pixels(chi2, usable - size)
        scale = covariance_growth(chi2, usable - size, detection(theta, fisher))
        _fill_covariance(equations, size, scale, leaning, lopsided, covariance[n])
        if odd[n] == 0 and is_vague(covariance[n], scale, theta[4] * theta[5]):
            failure[n] = _VAGUE
            continue
        peak = max(theta[2] + theta[3], 0.0) * shot + floor
        peak += left * (max(mean, 0.0) * shot + floor)
        table[0, n] = theta[0]
        table[1, n] = theta[1]
        table[2, n] = theta[2]
        table[3, n] = theta[3]
        table[4, n] = math.sqrt(theta[4] * theta[5])
        table[5, n] = theta[2] / math.sqrt(peak)
        table[6, n] = chi2


@written_into_kernels
def _fill_covariance(
    equations: NormalEquations, size: int, scale: float, leaning: float, lopsided: Array,
    covariance: Array,
) -> None:
    """Fill in the (2, 2) covariance of the place, `scale` times that of the likelihood."""
    column = equations.solution
    column_of_inverse(equations, size, 0)
    covariance[0, 0] = scale * column[0]
    covariance[0, 1] = scale * column[1]
    covariance[1, 0] = scale * column[1]
    column_of_inverse(equations, size, 1)
    covariance[1, 1] = scale * column[1]
    if leaning > LEANING:
        # The head's place may be the light's: its variance less that of noise.
        for p in range(2):
            for q in range(2):
                covariance[p, q] += (
                    HEAD * HEAD * (1.0 - 2.0 / leaning) * lopsided[p] / lopsided[2 + p]
                    * lopsided[q] / lopsided[2 + q]
                )


@kernel
def _judge(theta: Array, done: bool, fisher: Array, height: int, width: int) -> int:
    """Return the failure of a fit, or none."""
    for p in range(6):
        if not abs(theta[p]) < math.inf:
            return _DIVERGED
    if min(theta[4], theta[5]) <= 1.0001 * NARROWEST_PX:
        return _NARROW
    if max(theta[4], theta[5]) >= 0.9999 * WIDEST * max(height, width):
        return _WIDE
    return judge_optimum(theta, done, fisher, height, width)

"""Maximum likelihood: the pixel-integrated Gaussian, fitted at the Cramer-Rao bound."""

from __future__ import annotations

import math

from numba import njit
import numpy as np
from numpy.typing import NDArray

from blob_tracker.location.estimates import Estimates, Failure
from blob_tracker.types import SensorNoise

NARROWEST = 0.2  # px: below it one pixel holds 99 % of the light and its place there is lost
WIDEST = 2.0  # times the window: a wider pulse is a slope, its amplitude and level are one
FAINTEST = 4.0  # standard deviations of the amplitude: below it noise is found, not light
MISFIT = 5.0  # standard deviations of chi2: beyond it the model is wrong, not the noise
SHRINKAGE = 1.2  # of `_texture_share`; 1.1 to 1.4 keep the worst case below 1.09
BESIDE = 0.25  # of the pulse's peak: a texture of this rms is half taken off whatever it shifts
STRAY = 1.2  # times its noise: the texture that a small shift leaves probable
FISHER_STEPS = 12  # a good start takes 4 or 5
DAMPED_STEPS = 80
CONVERGED = 1e-4  # twice the gain in log-likelihood still to be had: 0.01 standard deviations

# Everything but the licence to ignore NaN and infinity: a masked pixel's variance is infinite.
_FAST = {'reassoc', 'contract', 'nsz', 'arcp'}
_SQRT2 = math.sqrt(2.0)
_SQRT_HALF_PI = math.sqrt(math.pi / 2.0)
_ROWS = 7  # of the table: x, y, amplitude, background, sigma, snr, chi2
_NONE, _NO_SIGNAL, _OUTSIDE = int(Failure.NONE), int(Failure.NO_SIGNAL), int(Failure.OUTSIDE)
_FEW, _DIVERGED = int(Failure.TOO_FEW_PIXELS), int(Failure.NOT_CONVERGED)
_NARROW, _WIDE = int(Failure.TOO_NARROW), int(Failure.TOO_WIDE)


def maximum_likelihood(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    *,
    elliptical: bool = False,
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

    Where chi2 says that the pulse is no Gaussian, or the noise not the one given, the
    covariance grows by chi2.

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

    Returns
    -------
    Estimates
        Failure TOO_FEW_PIXELS where fewer are left than parameters plus one, NO_SIGNAL where
        the amplitude is below four of its standard deviations, OUTSIDE where the pulse's centre
        leaves the window, TOO_NARROW and TOO_WIDE where its width does not tell its place,
        NOT_CONVERGED where the likelihood has no peak to climb.

    """
    table = np.zeros((_ROWS, lit.shape[0]))
    covariance = np.zeros((lit.shape[0], 2, 2))
    clipped = np.zeros(lit.shape[0], dtype=np.int64)
    failure = np.zeros(lit.shape[0], dtype=np.uint8)
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
    )
    x, y, amplitude, background, sigma, snr, chi2 = table
    return Estimates(
        x=x,
        y=y,
        covariance=covariance,
        amplitude=amplitude,
        background=background,
        sigma=sigma,
        snr=snr,
        chi2=chi2,
        saturated=clipped,
        failure=failure,
    )


@njit(cache=True, fastmath=_FAST)
def _fit_all(
    lit, unlit, shot, floor, saturation, elliptical, table, covariance, clipped, failure
):
    """Fit each window; `shot` is 1 / gain, `floor` the variance of a dark pixel, DN^2."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    size = 6 if elliptical else 5
    pixels = np.empty((height, width))
    extra = np.empty((height, width))
    texture = np.zeros((height, width))
    behind = np.zeros((height, width))
    across = np.empty((3, width))
    down = np.empty((3, height))
    theta = np.empty(6)
    start = np.empty(6)
    fisher = np.empty((6, 6))
    factor = np.empty((6, 6))
    score = np.empty(6)
    step = np.empty(6)
    prior = np.zeros(2)
    for n in range(count):
        usable = 0
        mean = 0.0
        for j in range(height):
            for i in range(width):
                pixels[j, i] = lit[n, j, i]
                extra[j, i] = floor
                lost = lit[n, j, i] >= saturation
                if lost:
                    clipped[n] += 1
                if paired:
                    texture[j, i] = unlit[n, j, i]
                    lost = lost or unlit[n, j, i] >= saturation
                if lost:
                    extra[j, i] = math.inf
                else:
                    usable += 1
                    mean += texture[j, i]
        if usable < size + 1:
            failure[n] = _FEW
            continue
        white = 0.0
        share = 0.0
        if paired:
            mean /= usable
            white = _split_unlit(texture, behind, extra, mean, shot, floor, usable)
            # Lit minus unlit to start from: bright texture must not be taken for the target.
            share = 1.0
            prior[0] = mean
            _blend(lit[n], texture, behind, mean, share, white, shot, floor, pixels, extra, prior)
        _start(pixels, lit[n], extra, saturation, paired, mean, start)
        theta[:] = start
        done = False
        for iteration in range(FISHER_STEPS):
            if paired and iteration == 3:
                share = _texture_share(
                    texture, extra, across, down, theta, fisher, factor, score, step, white,
                    mean, shot, floor,
                )
                _blend(
                    lit[n], texture, behind, mean, share, white, shot, floor, pixels, extra,
                    prior,
                )
            chi2 = _accumulate(
                pixels, extra, shot, floor, theta, across, down, prior, elliptical, fisher, score
            )
            if not _solve(fisher, score, size, 0.0, factor, step):
                break
            gain = _advance(theta, score, step, size, max(height, width))
            if gain < CONVERGED and (not paired or iteration >= 3):
                done = True
                break
        if not done:
            theta[:] = start
            done = _climb(
                pixels, extra, shot, floor, theta, across, down, prior, elliptical, fisher,
                factor, score, step, size,
            )
            chi2 = _accumulate(
                pixels, extra, shot, floor, theta, across, down, prior, elliptical, fisher, score
            )
            done = done and _solve(fisher, score, size, 0.0, factor, step)
        failure[n] = _judge(theta, done, factor, size, height, width)
        if failure[n] != _NONE:
            continue
        chi2 /= usable - size
        scale, left = 1.0, 0.0
        if paired:
            # Texture that was left in widens the residuals, beyond what it does to the position.
            left = _left_over(share, white)
            chi2 *= (1.0 + left) / (1.0 + max(left, share**2 + (1.0 - share) ** 2 * white))
        if chi2 > 1.0 + MISFIT * math.sqrt(2.0 / (usable - size)):
            scale = chi2
        _column_of_inverse(factor, size, 0, step)
        covariance[n, 0, 0] = scale * step[0]
        covariance[n, 0, 1] = scale * step[1]
        covariance[n, 1, 0] = scale * step[1]
        _column_of_inverse(factor, size, 1, step)
        covariance[n, 1, 1] = scale * step[1]
        peak = max(theta[2] + theta[3], 0.0) * shot + floor
        peak += left * (max(mean, 0.0) * shot + floor)
        table[0, n] = theta[0]
        table[1, n] = theta[1]
        table[2, n] = theta[2]
        table[3, n] = theta[3]
        table[4, n] = math.sqrt(theta[4] * theta[5])
        table[5, n] = theta[2] / math.sqrt(peak)
        table[6, n] = chi2


@njit(cache=True, fastmath=_FAST)
def _split_unlit(texture, behind, extra, mean, shot, floor, usable):
    """
    Make `texture` the departure from the mean, `behind` its best guess free of noise.

    Return the variance of the texture over that of the noise.
    """
    variance = max(mean, 0.0) * shot + floor
    height, width = texture.shape
    total = 0.0
    for j in range(height):
        for i in range(width):
            texture[j, i] -= mean
            if extra[j, i] < math.inf:
                total += texture[j, i] ** 2
    white = max(total / ((usable - 1) * variance) - 1.0, 0.0)
    for j in range(height):
        for i in range(width):
            behind[j, i] = white / (1.0 + white) * texture[j, i]
    return white


@njit(cache=True, fastmath=_FAST)
def _left_over(share, white):
    """Return the variance that the unlit window adds, over that of its noise."""
    # The noise of the share that was taken off, and the texture of the share that was not.
    return max(share**2 + (1.0 - share) ** 2 * min(white, STRAY), share)


@njit(cache=True, fastmath=_FAST)
def _blend(lit, texture, behind, mean, share, white, shot, floor, pixels, extra, prior):
    """
    Take a share of the unlit texture off the lit pixels.

    `extra` becomes the variance of a pixel less its (A g_x g_y + b) shot, and `prior` the level
    b that the unlit window's mean gives, with the inverse of its variance.
    """
    height, width = texture.shape
    added = _left_over(share, white)
    usable = 0
    for j in range(height):
        for i in range(width):
            pixels[j, i] = lit[j, i] - share * texture[j, i]
            if extra[j, i] < math.inf:
                level = max(mean + behind[j, i], 0.0) * shot
                extra[j, i] = floor + behind[j, i] * shot + added * (level + floor)
                usable += 1
    # At share 1 the mean cancels; the hundredth keeps its weight finite.
    prior[0] = mean
    prior[1] = usable / ((1.01 - share) * (max(mean, 0.0) * shot + floor))


@njit(cache=True, fastmath=_FAST)
def _texture_share(
    texture, extra, across, down, theta, fisher, factor, score, step, white, mean, shot, floor
):
    """
    Return the share of the unlit texture to take off: 0 none, 1 all of it.

    The shift d that the texture lends to the position is a linear fit of the pulse's own
    derivatives to it; under noise alone E = d^T C^-1 d / 2 has the mean 1, and with texture of
    r times the noise 1 + r. The share r / (1 + r) is estimated by 1 - SHRINKAGE / E.
    """
    height, width = texture.shape
    size = 5
    _profile(theta[0], theta[4], across)
    _profile(theta[1], theta[5], down)
    amplitude = theta[2]
    fisher[:] = 0.0
    score[:] = 0.0
    variance = max(mean, 0.0) * shot + floor
    for j in range(height):
        for i in range(width):
            if extra[j, i] < math.inf:
                step[0] = amplitude * across[1, i] * down[0, j]
                step[1] = amplitude * across[0, i] * down[1, j]
                step[2] = across[0, i] * down[0, j]
                step[3] = 1.0
                step[4] = amplitude * (
                    across[2, i] * down[0, j] + across[0, i] * down[2, j]
                )
                for p in range(size):
                    score[p] += step[p] * texture[j, i]
                    for q in range(p + 1):
                        fisher[p, q] += step[p] * step[q]
    if not _solve(fisher, score, size, 0.0, factor, step):
        return 1.0
    shift_x, shift_y = step[0], step[1]
    _column_of_inverse(factor, size, 0, step)
    xx, xy = step[0], step[1]
    _column_of_inverse(factor, size, 1, step)
    yy = step[1]
    square = yy * shift_x**2 - 2.0 * xy * shift_x * shift_y + xx * shift_y**2
    evidence = 0.5 * square / ((xx * yy - xy * xy) * variance)
    # The fit is linear in a texture that is weak beside the pulse; the rest is taken off.
    strong = white * variance / (white * variance + (BESIDE * amplitude) ** 2)
    return max(strong, 1.0 - SHRINKAGE / max(evidence, SHRINKAGE))


@njit(cache=True, fastmath=_FAST)
def _start(pixels, lit, extra, saturation, paired, mean, theta):
    """
    Fill theta with a first guess: the half-height box about the brightest 3 x 3 pixels.

    A Gaussian is above half its height, and clipped above the level c of its peak, over the areas
    2 pi sigma^2 ln 2 and 2 pi sigma^2 ln(peak / c). With the half taken of the highest level
    that is left, the difference of the two areas gives sigma and their ratio the peak.
    """
    height, width = pixels.shape
    level = mean
    if not paired:
        # The darkest side: a pulse at the window's edge lights one or two of them.
        level = math.inf
        for j in (0, height - 1):
            total = 0.0
            for i in range(width):
                total += pixels[j, i]
            level = min(level, total / width)
        for i in (0, width - 1):
            total = 0.0
            for j in range(height):
                total += pixels[j, i]
            level = min(level, total / height)
    brightest = -math.inf
    row, column = 0, 0
    for j in range(height):
        for i in range(width):
            total = 0.0
            for jj in range(max(j - 1, 0), min(j + 2, height)):
                for ii in range(max(i - 1, 0), min(i + 2, width)):
                    total += pixels[jj, ii] - level
            # Twice the pixel itself decides between the equals of an undersampled pulse.
            total += 2.0 * (pixels[j, i] - level)
            if total > brightest:
                brightest, row, column = total, j, i
    top = -math.inf
    for j in range(max(row - 1, 0), min(row + 2, height)):
        for i in range(max(column - 1, 0), min(column + 2, width)):
            top = max(top, pixels[j, i])
    half = level + 0.5 * (top - level)
    left, right, upper, lower = column, column, row, row
    while left > 0 and pixels[row, left - 1] > half:
        left -= 1
    while right < width - 1 and pixels[row, right + 1] > half:
        right += 1
    while upper > 0 and pixels[upper - 1, column] > half:
        upper -= 1
    while lower < height - 1 and pixels[lower + 1, column] > half:
        lower += 1
    total, x, y = 0.0, 0.0, 0.0
    above, clipped = 0, 0
    for j in range(upper, lower + 1):
        for i in range(left, right + 1):
            excess = pixels[j, i] - half
            if excess > 0.0:
                above += 1
                total += excess
                x += excess * i
                y += excess * j
                if lit[j, i] >= saturation:
                    clipped += 1
    if total > 0.0:
        x /= total
        y /= total
    else:
        x, y = float(column), float(row)
    ring = max(above - clipped, 1)
    theta[0] = x
    theta[1] = y
    theta[2] = max((top - level) * 2.0 ** min(clipped / ring, 8.0), 1e-3)
    theta[3] = level
    theta[4] = min(max(math.sqrt(ring / (2.0 * math.pi * math.log(2.0))), 0.5), width)
    theta[5] = theta[4]


@njit(cache=True, fastmath=_FAST)
def _profile(centre, sigma, out):
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


@njit(cache=True, fastmath=_FAST)
def _accumulate(
    pixels, extra, shot, floor, theta, across, down, prior, elliptical, fisher, score
):
    """
    Fill the lower triangle of the Fisher information and the score; return chi2.

    Each derivative is a product of a factor along x and one along y, so a row needs fourteen
    sums whatever the number of parameters, and the erf and exp are taken once a row and column.
    """
    height, width = pixels.shape
    _profile(theta[0], theta[4], across)
    _profile(theta[1], theta[5], down)
    a, b = theta[2], theta[3]
    fisher[:] = 0.0
    score[:] = 0.0
    chi2 = 0.0
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
    fisher[3, 3] += prior[1]
    score[3] += prior[1] * (prior[0] - b)
    if not elliptical:
        # One sigma moves both widths: its row is the sum of theirs.
        for p in range(4):
            fisher[4, p] += fisher[5, p]
        fisher[4, 4] += 2.0 * fisher[5, 4] + fisher[5, 5]
        score[4] += score[5]
    return chi2


@njit(cache=True, fastmath=_FAST)
def _solve(matrix, right, size, damping, factor, solution):
    """
    Solve (M + damping diag M) x = right by Cholesky; False where M is singular.

    M is given by its lower triangle, and `factor` keeps its Cholesky factor.
    """
    for p in range(size):
        for q in range(p + 1):
            total = matrix[p, q]
            if p == q:
                total *= 1.0 + damping
            for k in range(q):
                total -= factor[p, k] * factor[q, k]
            if p == q:
                # A pivot of 1e-10 of its diagonal is what rounding leaves of a zero.
                if not total > 1e-10 * matrix[p, p]:
                    return False
                factor[p, p] = math.sqrt(total)
            else:
                factor[p, q] = total / factor[q, q]
    for p in range(size):
        total = right[p]
        for k in range(p):
            total -= factor[p, k] * solution[k]
        solution[p] = total / factor[p, p]
    _back_substitute(factor, size, solution)
    return True


@njit(cache=True, fastmath=_FAST)
def _back_substitute(factor, size, solution):
    """Solve L^T x = solution in place."""
    for p in range(size - 1, -1, -1):
        total = solution[p]
        for k in range(p + 1, size):
            total -= factor[k, p] * solution[k]
        solution[p] = total / factor[p, p]


@njit(cache=True, fastmath=_FAST)
def _column_of_inverse(factor, size, column, out):
    """Fill out with a column of the inverse of L L^T."""
    for p in range(size):
        total = 1.0 if p == column else 0.0
        for k in range(p):
            total -= factor[p, k] * out[k]
        out[p] = total / factor[p, p]
    _back_substitute(factor, size, out)


@njit(cache=True, fastmath=_FAST)
def _advance(theta, score, step, size, extent):
    """Take the step, no longer than the model stays true for; return score . step."""
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
        theta[p] = min(max(width, NARROWEST), WIDEST * extent)
    return gain


@njit(cache=True, fastmath=_FAST)
def _climb(
    pixels, extra, shot, floor, theta, across, down, prior, elliptical, fisher, factor, score,
    step, size,
):
    """
    Climb the likelihood with damped steps, each of which must rise; True at the top.

    For the windows where plain scoring does not settle: faint, cut by the edge, or two pulses.
    """
    extent = max(pixels.shape)
    last = theta.copy()
    damping = 1e-2
    best = _log_likelihood(pixels, extra, shot, floor, theta, across, down, prior)
    for _ in range(DAMPED_STEPS):
        _accumulate(
            pixels, extra, shot, floor, theta, across, down, prior, elliptical, fisher, score
        )
        if not _solve(fisher, score, size, damping, factor, step):
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e8:
                return False
            continue
        last[:] = theta
        gain = _advance(theta, score, step, size, extent)
        value = _log_likelihood(pixels, extra, shot, floor, theta, across, down, prior)
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


@njit(cache=True, fastmath=_FAST)
def _log_likelihood(pixels, extra, shot, floor, theta, across, down, prior):
    """
    Return the log-likelihood whose slope is the score, up to a constant.

    The integral over the mean m of (z - m) / V(m), V = shot m + extra, from z: with
    u = V(m) / V(z) - 1 it is V(z) (ln(1 + u) - u) / shot^2.
    """
    height, width = pixels.shape
    _profile(theta[0], theta[4], across)
    _profile(theta[1], theta[5], down)
    value = -0.5 * prior[1] * (theta[3] - prior[0]) ** 2
    for j in range(height):
        for i in range(width):
            if extra[j, i] < math.inf:
                mean = theta[2] * across[0, i] * down[0, j] + theta[3]
                residual = pixels[j, i] - mean
                variance = max(shot * pixels[j, i] + extra[j, i], floor)
                u = max(shot * mean + extra[j, i], floor) / variance - 1.0
                if abs(u) < 1e-3 or shot == 0.0:
                    value -= residual**2 / (2.0 * variance) * (1.0 - 2.0 / 3.0 * u)
                else:
                    value += variance * (math.log(1.0 + u) - u) / shot**2
    return value


@njit(cache=True, fastmath=_FAST)
def _judge(theta, done, factor, size, height, width):
    """Return the failure of a fit, or none."""
    for p in range(6):
        if not abs(theta[p]) < math.inf:
            return _DIVERGED
    if min(theta[4], theta[5]) <= 1.0001 * NARROWEST:
        return _NARROW
    if max(theta[4], theta[5]) >= 0.9999 * WIDEST * max(height, width):
        return _WIDE
    if not done:
        return _DIVERGED
    inside = -0.5 <= theta[0] <= width - 0.5 and -0.5 <= theta[1] <= height - 0.5
    if not inside:
        return _OUTSIDE
    column = np.empty(6)
    _column_of_inverse(factor, size, 2, column)
    if not theta[2] > FAINTEST * math.sqrt(column[2]):
        return _NO_SIGNAL
    return _NONE

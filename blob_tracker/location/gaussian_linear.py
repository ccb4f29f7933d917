"""One Gaussian by linear least squares on the logarithm of the light (thesis, section 4.2)."""

from __future__ import annotations

from blob_tracker.location.estimates import Estimates, Failure, outside
from blob_tracker.location.signal import count_clipped, signal_above_background
from blob_tracker.types import LocationError, SensorNoise
import numpy as np
from numpy.typing import ArrayLike, NDArray

DARK_DN = 0.5  # DN: what rounds to zero has no logarithm and is left out
SINGULAR = 1e-10  # of the normal equations' determinant, their diagonal being 1


def gaussian_linear_1d(values: ArrayLike, *, weighted: bool = False) -> tuple[float, float, float]:
    """
    Fit a Gaussian to a row of pixels through its logarithm (thesis, eq. 4.8).

        ln f = a0 + a1 k + a2 k^2,   centre = -a1 / 2 a2,   sigma^2 = -1 / 2 a2

    Parameters
    ----------
    values : (n,) array
        Light above the background, DN. Values below half a DN are left out.
    weighted : bool
        Weigh each logarithm with the square of its value, the inverse of its variance.

    Returns
    -------
    centre, sigma, amplitude : float
        px, px, DN.

    Raises
    ------
    LocationError
        If fewer than three values are left, or they do not fall to both sides.

    """
    row = np.asarray(values, dtype=float).reshape(1, 1, -1)
    if row.size < 3 or not np.isfinite(row).all():
        raise LocationError('a Gaussian needs a row of at least three finite pixels')
    place = np.arange(row.shape[2]) - (row.shape[2] - 1) / 2.0
    basis = np.stack([np.ones_like(place), place, place**2])[:, None, :]
    fit, _, failure = _fit_logarithm(row, np.ones_like(row), basis, weighted)
    if failure[0] == Failure.NONE and fit[0, 2] >= 0.0:
        failure[0] = Failure.TOO_WIDE
    if failure[0] != Failure.NONE:
        raise LocationError('fewer than three pixels hold light, or it does not fall from a peak')
    level, slope, bend = fit[0]
    centre = -slope / (2.0 * bend)
    amplitude = float(np.exp(level - bend * centre**2))
    return float(centre + (row.shape[2] - 1) / 2.0), float(np.sqrt(-0.5 / bend)), amplitude


def gaussian_linear(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    *,
    weighted: bool = False,
) -> Estimates:
    r"""
    Locate N blobs by a circular Gaussian fitted to the logarithm of the light.

        ln s = a0 + a1 x + a2 (x^2 + y^2) + a3 y                        (thesis, eq. 4.12, 4.14)
        x = -a1 / 2 a2,   y = -a3 / 2 a2,   sigma^2 = -1 / 2 a2

    The signal s is lit - unlit, or lit less the mean of the window's corners. Pixels that round
    to zero, and clipped ones, are left out. The logarithm blows up the noise of faint pixels;
    `weighted` gives each its s^2, the inverse of the variance of ln s up to a factor (Guo, IEEE
    Signal Processing Magazine 28 (2011) 134).

    The covariance is the sandwich M^-1 (sum w^2 u^2 phi phi^T) M^-1 with M = sum w phi phi^T and
    u^2 the scatter of ln s: the squared residual over a power of one less its leverage (between
    HC2 and HC3 of MacKinnon and White, J. Econometrics 29 (1985) 305), since no model holds for
    the logarithm of a faint pixel. The few bright pixels that bear the weighted fit do not show
    their own scatter well; half of theirs is the noise v carried through the logarithm,
    v / (s^2 + v). At a peak SNR of some thirty and sigma 1.7 in 11 x 11 it lies within the 95 %
    bounds of 2000 windows, about the mean over all sub-pixel places. Elsewhere it is off by a
    tenth (NEES 1.8 to 2.2 of 2 at sigma 1.4 in 9 x 9, amplitude 100 to 600 DN), and much too large
    where the background is taken from corners that the pulse reaches (sigma 3 in 9 x 9, lit only:
    NEES 1.0, 1.3 weighted), since the misfit shows as scatter.

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit may be None.
    noise : SensorNoise
        Gain and read noise.
    saturation : float or None
        DN of a clipped pixel.
    weighted : bool
        Weigh the logarithms by s^2.

    Returns
    -------
    Estimates
        Failure TOO_FEW_PIXELS where fewer than four are left or they lie on one line, TOO_WIDE
        where the light does not fall to all sides, OUTSIDE where the peak leaves the window.

    """
    dx, dy = _places(lit.shape)
    basis = np.stack([np.ones_like(dx), dx, dy, dx**2 + dy**2])
    return _locate(lit, unlit, noise, saturation, basis, weighted)


def gaussian_linear_elliptical(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    *,
    weighted: bool = False,
) -> Estimates:
    r"""
    Locate N blobs by an elliptical Gaussian fitted to the logarithm of the light.

        ln s = a0 + a1 x + a2 x^2 + a3 y + a4 y^2                              (thesis, eq. 4.15)
        x = -a1 / 2 a2,   y = -a3 / 2 a4

    The rest is as in `gaussian_linear`, with five pixels at least.
    """
    dx, dy = _places(lit.shape)
    basis = np.stack([np.ones_like(dx), dx, dy, dx**2, dy**2])
    return _locate(lit, unlit, noise, saturation, basis, weighted)


def _places(shape: tuple[int, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the pixels' (h, w) distances from the window's middle, where sums of powers meet."""
    height, width = shape[1:]
    rows, columns = np.mgrid[0:height, 0:width].astype(float)
    return columns - (width - 1) / 2.0, rows - (height - 1) / 2.0


def _fit_logarithm(
    values: NDArray[np.float64],
    usable: NDArray[np.float64],
    basis: NDArray[np.float64],
    weighted: bool,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint8]]:
    """
    Fit ln values by the (P, h, w) basis in each of N windows.

    Return the (N, P) coefficients, the (N, P, n) rows that map logarithms to them, and the
    (N,) failures.
    """
    count, size = values.shape[0], basis.shape[0]
    design = basis.reshape(size, -1)
    keep = (values.reshape(count, -1) >= DARK_DN) & (usable.reshape(count, -1) > 0.0)
    light = np.where(keep, values.reshape(count, -1), 1.0)
    weight = np.where(keep, light**2 if weighted else 1.0, 0.0)
    # The brightest pixel weighs 1, so that no determinant under- or overflows.
    weight /= np.maximum(weight.max(axis=1, keepdims=True), 1e-300)
    normal = (design * weight[:, None, :]) @ design.T
    length = np.sqrt(np.maximum(np.einsum('npp->np', normal), 1e-300))
    scaled = normal / (length[:, :, None] * length[:, None, :])
    regular = (keep.sum(axis=1) >= size) & (np.abs(np.linalg.det(scaled)) > SINGULAR)
    scaled[~regular] = np.eye(size)
    inverse = np.linalg.inv(scaled) / (length[:, :, None] * length[:, None, :])
    rows = inverse @ (design * weight[:, None, :])
    rows[~regular] = 0.0
    fit = (rows @ np.log(light)[:, :, None])[:, :, 0]
    failure = np.where(regular, Failure.NONE, Failure.TOO_FEW_PIXELS).astype(np.uint8)
    return fit, rows, failure


def _locate(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
    basis: NDArray[np.float64],
    weighted: bool,
) -> Estimates:
    """Locate by the basis 1, x, y and the squares: x^2 + y^2, or x^2 and y^2."""
    signal = signal_above_background(lit, unlit, noise)
    count, height, width = lit.shape
    usable = np.ones(lit.shape) if saturation is None else (lit < saturation).astype(float)
    fit, rows, failure = _fit_logarithm(signal.pixels, usable, basis, weighted)
    bend = fit[:, [3, -1]]
    failure[(bend >= 0.0).any(axis=1) & (failure == Failure.NONE)] = Failure.TOO_WIDE
    good = failure == Failure.NONE
    bend = np.where(good[:, None], bend, -0.5)
    fit = np.where(good[:, None], fit, 0.0)
    centre = -fit[:, 1:3] / (2.0 * bend)
    x = centre[:, 0] + (width - 1) / 2.0
    y = centre[:, 1] + (height - 1) / 2.0
    failure = outside(x, y, lit.shape, failure)
    good = failure == Failure.NONE
    centre = np.where(good[:, None], centre, 0.0)

    design = basis.reshape(basis.shape[0], -1)
    light = np.maximum(signal.pixels.reshape(count, -1), DARK_DN)
    kept = (rows != 0.0).any(axis=1)
    residual = np.where(kept, np.log(light) - fit @ design, 0.0)
    leverage = np.clip(np.einsum('pk,npk->nk', design, rows), 0.0, 0.99)
    # HC2 undoes the leverage of equal scatter and HC3 that of the worst; the plain logarithm's
    # errors lie between, and where the noise model bears half the load HC2 is enough.
    shown = residual**2 / (1.0 - leverage) ** (1.0 if weighted else 1.5)
    variance = signal.variance.reshape(count, -1)
    carried = variance / (light**2 + variance)
    spare = np.maximum(kept.sum(axis=1) - basis.shape[0], 0)[:, None]
    share = np.maximum(1.0 / (1.0 + spare), 0.5 if weighted else 0.0)
    scatter = share * carried + (1.0 - share) * shown
    # x = -a1 / 2 a2: dx = -(da1 + 2 x da2) / 2 a2, and so for y.
    squares = rows[:, [3, -1]]
    influence = (rows[:, 1:3] + 2.0 * centre[:, :, None] * squares) / (-2.0 * bend[:, :, None])
    covariance = (influence * scatter[:, None, :]) @ influence.transpose(0, 2, 1)

    top = np.minimum(fit[:, 0] - (bend * centre**2).sum(axis=1), 40.0)
    amplitude = np.exp(np.where(good, top, 0.0))
    sigma = np.sqrt(0.5 / np.sqrt(bend[:, 0] * bend[:, 1]))
    model = np.exp(np.minimum(np.where(good[:, None], fit @ design, 0.0), 40.0))
    snr, chi2 = signal.quality(
        amplitude, model.reshape(lit.shape), basis.shape[0] + 1, noise
    )
    return Estimates(
        x=x,
        y=y,
        covariance=covariance,
        amplitude=amplitude,
        background=signal.background,
        sigma=sigma,
        snr=snr,
        chi2=chi2,
        saturated=count_clipped(lit, saturation),
        failure=failure,
    )

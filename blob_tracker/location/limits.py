"""The Cramer-Rao bound: how well any unbiased estimator can do, whatever its cleverness."""

from __future__ import annotations

from blob_tracker.location.noise import pixel_variance
from blob_tracker.location.pulse import integrated_profile, sampled_profile
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import ArrayLike, NDArray


def cramer_rao_bound(
    shape: tuple[int, int],
    *,
    x: float,
    y: float,
    sigma: ArrayLike,
    amplitude: ArrayLike,
    background: float,
    noise: SensorNoise,
    unlit: bool = False,
    sigma_y: ArrayLike | None = None,
    sampled: bool = False,
    saturation: float | None = None,
) -> NDArray[np.float64]:
    r"""
    Return the least covariance of a position that is estimated without bias.

    With the mean mu_k and the variance V_k of the pixels left unclipped, and the parameters
    theta = (x, y, every A, every sigma, b),

        I_pq = sum_k (d mu_k / d p)(d mu_k / d q) / V_k,      bound = (I^-1) over x and y

    (Huang et al., Nature Methods 10 (2013), eq. 3.6; Mortensen et al., Nature Methods 7
    (2010)). The thesis has no such bound (section 2.3). V_k is `pixel_variance` of
    mu_k. The bound is the quasi-likelihood's: what V_k itself tells of the mean, through the
    scatter of a lone pixel, is left out, as in all the sources.

    With an unlit window b is known, and the difference of two pixels has the variance
    V_k = S_k / gain + 2 v(b), S_k being the pulse alone and v(b) `pixel_variance` at b. That is
    the bound of lit minus unlit; behind a target without texture an estimator that draws on
    that flatness can do better, down to the bound of the lit window with its level known.

    Parameters
    ----------
    shape : (int, int)
        Height and width of the window, px.
    x, y : float
        True position, px from the centre of the first pixel.
    sigma : float or (K,) array
        Standard deviation of the pulse, px; several for a sum of pulses with one mean (thesis,
        eq. 4.35, three of them).
    amplitude : float or (K,) array
        Peak of the unsampled pulse above its background, DN.
    background : float
        DN, the black level included.
    noise : SensorNoise
        Gain, read noise and black level.
    unlit : bool
        There is an unlit window: b is known, at the price of its noise.
    sigma_y : float or (K,) array or None
        Standard deviation along y where it is a parameter of its own: the elliptical pulse.
    sampled : bool
        The pulse is sampled at the pixels' centres (as in the thesis), not integrated over them.
    saturation : float or None
        DN of a clipped pixel: those whose mean reaches it carry nothing.

    Returns
    -------
    (2, 2) array
        px^2, order x, y.

    Raises
    ------
    ValueError
        If the pixels left do not determine the parameters.

    Examples
    --------
    The least standard deviation of x of a light of 150 DN on 40 DN, px:

    >>> bound = cramer_rao_bound(
    ...     (15, 15), x=7.0, y=7.0, sigma=2.0, amplitude=150.0, background=40.0,
    ...     noise=SensorNoise(gain=40.0, read_noise=0.7),
    ... )
    >>> round(float(bound[0, 0] ** 0.5), 3)
    0.009

    """
    widths = np.atleast_1d(np.asarray(sigma, dtype=float))
    heights = widths if sigma_y is None else np.atleast_1d(np.asarray(sigma_y, dtype=float))
    peaks = np.atleast_1d(np.asarray(amplitude, dtype=float))
    if not widths.shape == heights.shape == peaks.shape:
        raise ValueError(
            f'there are {peaks.size} amplitudes, {widths.size} sigma and {heights.size} sigma_y'
        )
    profile = sampled_profile if sampled else integrated_profile
    across, across_x, across_sigma = profile(shape[1], x, widths)
    down, down_y, down_sigma = profile(shape[0], y, heights)

    def on_pixels(
        along_y: NDArray[np.float64], along_x: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        return (along_y[:, :, None] * along_x[:, None, :]).reshape(peaks.size, -1)

    pulse = peaks @ on_pixels(down, across)
    columns = [peaks @ on_pixels(down, across_x), peaks @ on_pixels(down_y, across)]
    columns += list(on_pixels(down, across))
    wider = peaks[:, None] * on_pixels(down, across_sigma)
    taller = peaks[:, None] * on_pixels(down_sigma, across)
    columns += list(wider + taller) if sigma_y is None else [*wider, *taller]
    variance = pixel_variance(pulse + background, noise)
    if unlit:
        variance = variance + pixel_variance(np.full_like(pulse, background), noise)
    else:
        columns.append(np.ones_like(pulse))
    seen = np.ones(pulse.shape, dtype=bool)
    if saturation is not None:
        seen = pulse + background < saturation
    weighted = np.stack(columns, axis=1)[seen] / np.sqrt(variance[seen])[:, None]
    return _least_covariance(weighted, 2)


def cramer_rao_bound_1d(
    count: int,
    *,
    x: float,
    sigma: ArrayLike,
    amplitude: ArrayLike,
    variance: float,
    sampled: bool = False,
) -> float:
    """
    Return the least variance of a position in a row of pixels, estimated without bias.

    As `cramer_rao_bound`, with theta = (x, every A, every sigma): the background is known, and
    each pixel has the same noise.

    Parameters
    ----------
    count : int
        Pixels in the row.
    x : float
        True position, px from the centre of the first pixel.
    sigma : float or (K,) array
        Standard deviation of the pulse, px; several for a sum of pulses with one mean (thesis,
        eq. 4.32).
    amplitude : float or (K,) array
        Peak of each, DN.
    variance : float
        Of a pixel, DN^2.
    sampled : bool
        The pulse is sampled at the pixels' centres (as in the thesis), not integrated over them.

    Returns
    -------
    float
        px^2.

    Raises
    ------
    ValueError
        If the pixels do not determine the parameters.

    Examples
    --------
    A pulse of 100 DN in a row of pixels with noise of 1 DN: the least standard deviation, px:

    >>> variance = cramer_rao_bound_1d(21, x=10.0, sigma=2.0, amplitude=100.0, variance=1.0)
    >>> round(variance**0.5, 3)
    0.015

    """
    widths = np.atleast_1d(np.asarray(sigma, dtype=float))
    peaks = np.atleast_1d(np.asarray(amplitude, dtype=float))
    if widths.shape != peaks.shape:
        raise ValueError(f'there are {peaks.size} amplitudes and {widths.size} sigma')
    value, by_x, by_sigma = (sampled_profile if sampled else integrated_profile)(count, x, widths)
    columns = [peaks @ by_x, *value, *(peaks[:, None] * by_sigma)]
    return float(_least_covariance(np.stack(columns, axis=1) / np.sqrt(variance), 1)[0, 0])


def _least_covariance(jacobian: NDArray[np.float64], positions: int) -> NDArray[np.float64]:
    """Return (J^T J)^-1 over the first parameters, J in standard deviations of the pixels."""
    # Columns of unit length: amplitudes and widths differ by orders of magnitude.
    length = np.sqrt((jacobian**2).sum(axis=0))
    if jacobian.shape[0] < jacobian.shape[1] or not (length > 0.0).all():
        raise ValueError('the pixels left do not determine the pulse')
    # The R of a QR factor keeps twice the digits that J^T J would.
    triangle = np.linalg.qr(jacobian / length, mode='r')
    if np.abs(np.diag(triangle)).min() < 1e-12:
        raise ValueError('the pixels left do not determine the pulse')
    root = np.linalg.solve(triangle, np.eye(length.size))[:positions]
    return (root @ root.T) / np.outer(length[:positions], length[:positions])


def locale_extent(
    shape: tuple[int, int],
    *,
    x: ArrayLike,
    y: ArrayLike,
    sigma: float,
    amplitude: float,
    background: float = 0.0,
) -> NDArray[np.float64]:
    r"""
    Return how far along x a noise-free pulse can move before a rounded pixel changes.

    The positions that give one and the same rounded picture are a locale (Havelock, IEEE PAMI
    11 (1989) 1065; thesis, section 2.3), and no method can tell them apart. Pixel (i, j) of the
    sampled pulse steps where it meets a half-integer level L, at

        x = i -+ sigma sqrt(2 ln(A exp(-(j - y)^2 / 2 sigma^2) / (L - b)))

    so the extent of the locale about a position is the gap between the nearest of these on
    either side of it. For the extent along y exchange x and y, and the shape.

    Parameters
    ----------
    shape : (int, int)
        Height and width of the window, px.
    x, y : (M,) and (L,) arrays
        Positions, px: the map's columns and rows.
    sigma, amplitude, background : float
        px, DN, DN.

    Returns
    -------
    (L, M) array
        px; infinite where no pixel ever changes.

    Examples
    --------
    How far a pulse of 200 DN and one of 20 DN move before a pixel changes, px:

    >>> for amplitude in (200.0, 20.0):
    ...     extent = locale_extent((15, 15), x=[7.1], y=[7.2], sigma=2.0, amplitude=amplitude)
    ...     print(extent.round(4).tolist())
    [[0.0009]]
    [[0.0067]]

    """
    columns = np.atleast_1d(np.asarray(x, dtype=float))
    rows = np.atleast_1d(np.asarray(y, dtype=float))
    height, width = shape
    levels = np.arange(np.floor(background), background + amplitude + 1.0) + 0.5 - background
    levels = levels[(levels > 0.0) & (levels < amplitude)]
    extent = np.empty((rows.size, columns.size))
    for row, centre in enumerate(rows):
        peaks = amplitude * np.exp(-0.5 * ((np.arange(height) - centre) / sigma) ** 2)
        ratio = (peaks[:, None] / levels[None, :]).ravel()
        reach = sigma * np.sqrt(2.0 * np.log(ratio[ratio >= 1.0]))
        pixels = np.arange(width)[:, None]
        steps = np.sort(np.concatenate([(pixels - reach).ravel(), (pixels + reach).ravel()]))
        steps = np.concatenate([[-np.inf], steps, [np.inf]])
        after = np.searchsorted(steps, columns, side='right')
        extent[row] = steps[after] - steps[after - 1]
    return extent

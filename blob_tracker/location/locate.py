"""Place blobs in their windows by the method that is named."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from inspect import signature
import math
from typing import Any

from blob_tracker.location.centroid import centroid
from blob_tracker.location.contract import flag_invalid, LARGEST_DN, validate
from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimate, Estimates, Failure, NOTHING
from blob_tracker.location.explain import compile_alternatives
from blob_tracker.location.flash_memory import compile_memory
from blob_tracker.location.gaussian_linear import gaussian_linear, gaussian_linear_elliptical
from blob_tracker.location.hypotheses import Way
from blob_tracker.location.locale_table import locale_table
from blob_tracker.location.maximum_likelihood import (
    at_once, AT_ONCE_TYPES, compile_at_once, maximum_likelihood,
)
from blob_tracker.location.multi_gaussian_lm import multi_gaussian_lm
from blob_tracker.location.multi_gaussian_simplex import multi_gaussian_simplex
from blob_tracker.location.noise import noise_of_sum
from blob_tracker.location.noise_check import compile_check
from blob_tracker.location.sites import blanked, BY_SITES
from blob_tracker.location.skew import centroid_skew_corrected
from blob_tracker.types import Location, LocationError, SensorNoise, Window
import numpy as np
from numpy.typing import ArrayLike, NDArray

METHODS: dict[str, Callable[..., Estimates]] = {
    'centroid': centroid,
    'centroid_skew_corrected': centroid_skew_corrected,
    'gaussian_linear': gaussian_linear,
    'gaussian_linear_elliptical': gaussian_linear_elliptical,
    'multi_gaussian_simplex': multi_gaussian_simplex,
    'multi_gaussian_lm': multi_gaussian_lm,
    'locale_table': locale_table,
    'maximum_likelihood': maximum_likelihood,
}
# Of those that have one, what does all to a window that nothing is odd about.
AT_ONCE: dict[str, Callable[..., Estimate | None]] = {'maximum_likelihood': at_once}
FLOAT = np.dtype(np.float64)
UNASKED = {'elliptical', 'history'}  # the options that such a window may come with
# The parameters of each.
PARAMETERS = {name: frozenset(signature(method).parameters) for name, method in METHODS.items()}
SMALLEST_PX = 3  # px: below this the position, level and width of a pulse are not determined


def method_options(
    method: str, *, elliptical: bool = False, pulse: EffectivePsf | None = None
) -> dict[str, Any]:
    """
    Return the options of a method, as `locate` and `locate_batch` pass them on.

    Parameters
    ----------
    method : str
        A key of `METHODS`.
    elliptical : bool
        Fit a width along x and one along y.
    pulse : EffectivePsf or None
        Learned pulse to fit in place of the Gaussian.

    Raises
    ------
    ValueError
        If there is no such method, or it has no such form.

    Examples
    --------
    >>> method_options('maximum_likelihood', elliptical=True)
    {'elliptical': True}
    >>> method_options('centroid', elliptical=True)
    Traceback (most recent call last):
        ...
    ValueError: parameter 'elliptical' is True; the method 'centroid' has no such form

    """
    if method not in METHODS:
        raise ValueError(f"no method '{method}'; there is {', '.join(METHODS)}")
    asked = {'elliptical': elliptical or None, 'pulse': pulse}
    options = {name: value for name, value in asked.items() if value is not None}
    for name in options:
        if name not in PARAMETERS[method]:
            raise ValueError(
                f"parameter 'elliptical' is True; the method '{method}' has no such form"
                if name == 'elliptical' else f"the method '{method}' takes no learned pulse"
            )
    return options


def locate_batch(
    lit: ArrayLike,
    unlit: ArrayLike | None = None,
    *,
    method: str = 'maximum_likelihood',
    noise: SensorNoise,
    saturation: float | None = None,
    sites: NDArray[np.bool_] | None = None,
    **options: Any,
) -> Estimates:
    """
    Locate the blobs of N windows of one size.

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit None if there is no unlit frame.
    method : str
        A key of `METHODS`.
    noise : SensorNoise
        Gain, read noise and black level of a pixel. No method knows of the black level: it is
        taken off here, and added to the background that is found.
    saturation : float or None
        The DN at which a pixel is clipped.
    sites : (h, w) bool array or None
        Which pixels see the light, the same in all windows; None if all do.
    **options
        Passed on to the method (`elliptical=True`, say).

    Returns
    -------
    Estimates
        Positions in window coordinates; `ok` is False where `locate` would have raised.

    Raises
    ------
    LocationError
        If no window of the stack can be located: wrong shape, too small, unknown method, or
        one that needs every pixel.

    Examples
    --------
    Windows without noise of a light that moves by half a pixel:

    >>> from blob_tracker.simulation import pixel_integrated_gaussian
    >>> lit = np.stack([
    ...     40.0 + 150.0 * pixel_integrated_gaussian((15, 15), x, 7.0, 2.0) for x in (6.5, 7, 7.5)
    ... ])
    >>> estimates = locate_batch(lit, noise=SensorNoise(gain=40.0, read_noise=0.7))
    >>> estimates.x.round(3).tolist(), estimates.ok.tolist()  # px
    ([6.5, 7.0, 7.5], [True, True, True])
    >>> np.sqrt(estimates.covariance[:, 0, 0]).round(4).tolist()  # px
    [0.0094, 0.0094, 0.0094]

    """
    if method not in METHODS:
        raise LocationError(f"no method '{method}'; there is {', '.join(METHODS)}")
    lit = _stack(lit, 'lit')
    if unlit is not None:
        unlit = _stack(unlit, 'unlit')
        if unlit.shape != lit.shape:
            raise LocationError(f'lit is {lit.shape} and unlit {unlit.shape}; they must be equal')
    if min(lit.shape[1:]) < SMALLEST_PX:
        raise LocationError(
            f'the window is {lit.shape[2]} x {lit.shape[1]} px; '
            f'it must be at least {SMALLEST_PX} x {SMALLEST_PX}'
        )
    if lit.shape[0] == 0:
        return NOTHING
    if sites is not None:
        if method not in BY_SITES:
            raise LocationError(
                f'{method} needs every pixel and this window has those of one colour; take '
                f"{' or '.join(BY_SITES)}, or set channel of the camera to luma"
            )
        if sites.shape != lit.shape[1:] or not sites.any():
            raise LocationError(f'the sites are {sites.shape}, or none of them sees the light')
    black_level = noise.black_level
    if black_level != 0.0:
        lit = lit - black_level
        unlit = None if unlit is None else unlit - black_level
        saturation = None if saturation is None else saturation - black_level
        noise = replace(noise, black_level=0.0)
    limit = math.inf if saturation is None else float(saturation)
    if sites is not None:
        lit, limit = blanked(lit, sites), min(limit, LARGEST_DN)
    invalid = np.zeros(lit.shape[0], dtype=np.uint8)
    if flag_invalid(lit, lit if unlit is None else unlit, limit, invalid):
        # A method sees only numbers that it can work on; the flagged rows are overwritten below.
        lit = np.where((invalid == Failure.NONE)[:, None, None], lit, 0.0)
        if unlit is not None:
            unlit = np.where((invalid == Failure.NONE)[:, None, None], unlit, 0.0)
    estimates = METHODS[method](
        lit, unlit, noise, None if math.isinf(limit) else limit, **options
    )
    validate(
        estimates.x,
        estimates.y,
        np.ascontiguousarray(estimates.covariance),
        estimates.amplitude,
        estimates.background,
        estimates.sigma,
        estimates.snr,
        estimates.chi2,
        (lit.shape[1], lit.shape[2]),
        invalid,
        estimates.failure,
    )
    if black_level != 0.0:
        estimates = replace(estimates, background=estimates.background + black_level)
    return estimates


def locate(
    window: Window,
    *,
    method: str = 'maximum_likelihood',
    noise: SensorNoise,
    **options: Any,
) -> Location:
    """
    Locate the blob of one window, in the coordinates of the full, unbinned sensor.

    With b sensor pixels to a window pixel, u = x0 + b (x + 1/2) - 1/2, and the covariance
    grows by b^2. The stamp is that of the line y in which it lies: on a rolling shutter it is
    later than that of the window's middle line by (y - (h - 1)/2) line_time_ns.

    Parameters
    ----------
    window : Window
        Lit and, where there is one, unlit pixels.
    method : str
        A key of `METHODS`.
    noise : SensorNoise
        Gain, read noise and black level of a pixel in one frame, also where the window is the sum
        of several.
    **options
        Passed on to the method.

    Returns
    -------
    Location
        Position in px, covariance in px^2.

    Raises
    ------
    LocationError
        If the blob cannot be placed; the message gives the reason.

    Examples
    --------
    A Gaussian of 150 DN on 40 DN, without noise:

    >>> y, x = np.mgrid[:15, :15]
    >>> pulse = 150.0 * np.exp(-((x - 7.3) ** 2 + (y - 6.5) ** 2) / (2.0 * 2.0**2))
    >>> window = Window(lit=(40.0 + pulse).round().astype(np.uint8), x0=100, saturation=255)
    >>> location = locate(window, noise=SensorNoise(gain=40.0, read_noise=0.7))
    >>> round(location.x, 1), round(location.y, 1)  # px
    (107.3, 6.5)

    """
    return to_location(window, single(window, method=method, noise=noise, **options))


def single(
    window: Window, *, method: str, noise: SensorNoise, **options: Any
) -> Estimate:
    """Return the estimate of one window, in its own coordinates, or raise; see `locate`."""
    if options.keys() <= UNASKED:
        found = plain(window, method, noise, elliptical=options.get('elliptical', False))
        if found is not None:
            return found
    return estimate(window, method=method, noise=noise, **options).first()


def plain(
    window: Window, method: str, noise: SensorNoise, *, elliptical: bool
) -> Estimate | None:
    """Return the estimate of a window that nothing is odd about; None of any other."""
    if method not in AT_ONCE or window.sites is not None:
        return None
    lit, unlit = _one(window.lit), window.unlit
    if lit is None:
        return None
    if unlit is not None:
        unlit = _one(unlit)
        if unlit is None or unlit.shape != lit.shape:
            return None
        if unlit.dtype != lit.dtype:
            lit, unlit = lit.astype(FLOAT), unlit.astype(FLOAT)
    if window.looks > 1 or window.added_noise > 0.0:
        noise = _noise_in(window, noise)
    saturation = math.inf if window.saturation is None else float(window.saturation)
    across, down = window.binning
    return AT_ONCE[method](
        lit, unlit, noise, saturation, elliptical=elliptical or across != down
    )


def _noise_in(window: Window, noise: SensorNoise) -> SensorNoise:
    """Return the noise of a window's pixel, of one frame's."""
    if window.added_noise > 0.0:
        read_noise = math.hypot(noise.read_noise, window.added_noise)
        noise = replace(noise, read_noise=read_noise)
    return noise_of_sum(noise, window.looks)


def estimate(
    window: Window, *, method: str, noise: SensorNoise, **options: Any
) -> Estimates:
    """Return the estimates of one window, in its own coordinates; see `locate`."""
    lit = _numbers(window.lit, 'lit')[None]
    unlit = None if window.unlit is None else _numbers(window.unlit, 'unlit')[None]
    if window.binning[0] != window.binning[1] and 'elliptical' in PARAMETERS[method]:
        options['elliptical'] = True  # a round light is not, in the lines of a field
    if window.glimpse is not None and 'way' in PARAMETERS[method]:
        options['way'] = Way(
            window.glimpse.way / window.binning,
            window.glimpse.way_sigma / min(window.binning),
            # Over an even exposure the middle of the light lags by a third of what the ends do.
            3.0 * window.glimpse.lag / window.binning,
        )
    return locate_batch(
        lit,
        unlit,
        method=method,
        noise=_noise_in(window, noise),
        saturation=window.saturation,
        sites=window.sites,
        **options,
    )


def to_location(window: Window, found: Estimate) -> Location:
    """Return the location of a window from its estimate."""
    across, down = window.binning
    covariance = found.covariance
    if window.binning != (1, 1):
        covariance = covariance * np.outer(window.binning, window.binning)
    lag_x = lag_y = 0.0
    if window.glimpse is not None:
        covariance = covariance + window.glimpse.doubt
        lag_x, lag_y = window.glimpse.lag.tolist()
        lag_y += window.glimpse.drawn
    below = found.y - 0.5 * (len(window.lit) - 1)  # the window's middle line
    return Location(
        window.x0 + across * (found.x + 0.5) - 0.5 - lag_x,
        window.y0 + down * (found.y + 0.5) - 0.5 - lag_y,
        covariance,
        found.amplitude,
        found.background,
        found.sigma,
        found.snr,
        found.chi2,
        found.saturated,
        window.stamp_ns + round(below * window.line_time_ns),
        found.warning,
    )


def compile_ahead(methods: Iterable[str] = tuple(METHODS)) -> None:
    """
    Compile what Numba compiles of these methods, or load it from its cache.

    A node calls it as it starts: the first compilation takes some twenty seconds, which the first
    target would otherwise wait for.

    Parameters
    ----------
    methods : iterable of str
        Keys of `METHODS`; all of them if left out.

    """
    bell = np.exp(-((np.arange(7) - 3.0) ** 2) / 4.0)
    lit = np.round(100.0 * bell[:, None] * bell[None, :] + 10.0)[None]
    noise = SensorNoise(gain=1.0, read_noise=1.0)
    dark = np.full_like(lit, 10.0)
    for method in methods:
        locate_batch(lit, dark, method=method, noise=noise)
        if method in AT_ONCE:
            compile_at_once()
        if 'history' in PARAMETERS[method]:
            compile_alternatives()
    compile_check()
    compile_memory()


def _numbers(pixels: ArrayLike, name: str) -> NDArray[Any]:
    """Return the pixels as an array of real numbers, or raise LocationError."""
    try:
        array = np.asarray(pixels)
    except (TypeError, ValueError) as error:
        raise LocationError(f'{name} is not an array of numbers: {error}') from None
    if array.dtype.kind not in 'buif':
        raise LocationError(f'{name} holds {array.dtype}; it must hold real numbers')
    return array


def _one(pixels: ArrayLike) -> NDArray[Any] | None:
    """Return the pixels of one window as the kernels take them; None if it is none."""
    if type(pixels) is not np.ndarray or pixels.ndim != 2 or min(pixels.shape) < SMALLEST_PX:
        return None
    if pixels.dtype in AT_ONCE_TYPES:
        flags = pixels.flags
        if flags.c_contiguous and flags.writeable and flags.aligned:
            return pixels
    # Names of the type and the order take longer.
    return pixels.astype(FLOAT, 'C') if pixels.dtype.kind in 'buif' else None


def _stack(pixels: ArrayLike, name: str) -> NDArray[np.float64]:
    """Return the pixels as a contiguous (N, h, w) float64 stack, or raise LocationError."""
    stack = _numbers(pixels, name)
    if stack.ndim != 3:
        raise LocationError(f'{name} windows have {stack.ndim - 1} dimensions; they must have 2')
    stack = np.ascontiguousarray(stack, dtype=np.float64)
    # Numba compiles anew for a read-only array; a copy is a millionth of that.
    return stack if stack.flags.writeable else stack.copy()

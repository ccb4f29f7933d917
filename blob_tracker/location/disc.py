"""How large and how bright a light is in its window: a disc, seen through the optics."""

from __future__ import annotations

from dataclasses import dataclass
import math

from blob_tracker.location.noise import noise_of_sum, pixel_variance
from blob_tracker.types import Location, LocationError, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NODES, MORE_NODES = 16, 64  # of the quadrature: for a radius of up to MANY widths, and beyond
MANY = 6.0
MOST_PIXELS = 4096  # of a window: of a larger one each second is fitted, or third
STEPS = 30
CONVERGED = 1e-3  # of the standard deviation of the squared radius
NARROWEST = -0.8  # times the squared width of the optics: what is narrower is no light
PIXEL_VARIANCE = 1.0 / 12.0  # px^2, of the light over one
TEXTURE_SIGMA = 3.0  # of the correlation of neighbours, beyond which the residuals are no noise


@dataclass(frozen=True)
class Disc:
    """
    A disc of even brightness in the picture.

    Parameters
    ----------
    square : float
        Squared radius, image px^2; below 0 by chance if there is none.
    flux : float
        Sum of its light over all pixels, DN, of one look.
    covariance : (2, 2) array
        Of both, in this order. Where the residuals are larger than the noise, grown by it.
    chi2 : float
        Squared residuals over their variance, per degree of freedom.

    """

    square: float
    flux: float
    covariance: Array
    chi2: float


def fit_disc(
    window: Window, location: Location, *, noise: SensorNoise, psf_sigma: float
) -> Disc:
    """
    Fit a disc that the optics blur to a window whose blob has been placed.

    A disc of squared radius q and flux F, blurred by a Gaussian of variance s^2, is

        m(rho) = b + F / (2 pi s^2) int_0^1 g(t q) dt
        g(u) = exp(-(rho^2 + u) / 2 s^2) I_0(rho sqrt(u) / s^2)

    at the distance rho from its middle: the mean of Gaussians about all its points. It is smooth
    in q through 0, so that a light too small to be resolved has an unbiased q about 0. q, F and b
    are those of least squared residuals over the variance of the pixels, by Gauss-Newton steps;
    their covariance is the inverse of the normal matrix. The place is that of `location`: to first
    order its error changes neither.

    Parameters
    ----------
    window : Window
        Lit and unlit pixels.
    location : Location
        Where the blob is, how wide, and on what background.
    noise : SensorNoise
        Of the camera.
    psf_sigma : float
        Standard deviation of the picture of a point, image px: `Location.sigma` of a far light.

    Returns
    -------
    Disc
        In image px and DN.

    Raises
    ------
    LocationError
        If too few pixels are left, or no disc fits; or there is no unlit frame, and a texture
        about the light that nothing takes off: its neighbouring pixels are alike, and the
        covariance is that of noise.

    """
    distances, values, usable, stride = _pixels(window, location)
    kept = len(values)
    of_sum = noise_of_sum(noise, window.looks)
    added = window.looks * window.added_noise**2 * (1 if window.unlit is None else 2)
    unlit = 0.0 if window.unlit is None else pixel_variance(
        np.array([location.background]), of_sum)[0]
    blur = psf_sigma**2 + PIXEL_VARIANCE
    if kept < 4:
        raise LocationError('too few pixels are left to see how large the light is')
    square = 4.0 * (location.sigma**2 - psf_sigma**2)
    flux = 2.0 * math.pi * location.sigma**2 * location.amplitude
    level = 0.0 if window.unlit is not None else location.background
    for _ in range(STEPS):
        square = max(square, 0.5 * NARROWEST * blur)
        shape, by_square = _profile(distances, square, blur)
        design = np.stack([flux * by_square, shape, np.ones_like(shape)], axis=1)
        mean = np.maximum(flux * shape, 0.0) + location.background
        weights = 1.0 / (pixel_variance(mean, of_sum) + unlit + added)
        residuals = values - flux * shape - level
        information = design.T @ (weights[:, None] * design)
        try:
            covariance = np.linalg.inv(information)
        except np.linalg.LinAlgError:
            break
        step = covariance @ (design.T @ (weights * residuals))
        # A step to a far narrower or wider disc leaves the region where the model is linear.
        most = max(abs(square), blur)
        step *= min(1.0, most / max(abs(step[0]), 1e-12))
        square, flux, level = square + step[0], flux + step[1], level + step[2]
        if abs(step[0]) < CONVERGED * math.sqrt(covariance[0, 0]):
            break
    else:
        raise LocationError('no disc fits the light: its size is unknown')
    if not (flux > 0.0 and square > NARROWEST * blur and covariance[0, 0] > 0.0):
        raise LocationError('no disc fits the light: its size is unknown')
    scaled = np.sqrt(weights) * residuals
    if window.unlit is None and _are_alike(scaled, usable, stride):
        raise LocationError(
            'a texture about the light, which no unlit frame takes off, hides its size and flux; '
            'let it flash, or have it before an even background'
        )
    chi2 = float(scaled @ scaled) / (kept - 3)
    units = np.array([1.0, 1.0 / window.looks])
    return Disc(
        float(square), float(flux) / window.looks,
        max(chi2, 1.0) * covariance[:2, :2] * np.outer(units, units), chi2,
    )


def _pixels(
    window: Window, location: Location
) -> tuple[Array, Array, NDArray[np.bool_], int]:
    """Return distances from the middle, px, lit less unlit, DN, which pixels, every how many."""
    lit = np.asarray(window.lit, dtype=float)
    usable = np.isfinite(lit)
    if window.saturation is not None:
        usable &= lit < window.saturation
    if window.sites is not None:
        usable &= window.sites
    values = lit if window.unlit is None else lit - np.asarray(window.unlit, dtype=float)
    stride = math.ceil(math.sqrt(lit.size / MOST_PIXELS))
    if stride > 1:
        taken = np.zeros_like(usable)
        taken[::stride, ::stride] = True
        usable &= taken
    x, y = window.to_window(location.x, location.y)
    rows, columns = np.nonzero(usable)
    return np.hypot(columns - x, rows - y), values[usable], usable, stride


def _are_alike(scaled: Array, usable: NDArray[np.bool_], stride: int) -> bool:
    """Tell whether residuals over their sigmas are alike in pixels that are neighbours."""
    picture = np.full(usable.shape, np.nan)
    picture[usable] = scaled
    picture = picture[::stride, ::stride]
    products = np.concatenate([
        (picture[:, 1:] * picture[:, :-1]).ravel(), (picture[1:] * picture[:-1]).ravel(),
    ])
    products = products[np.isfinite(products)]
    # The correlation of noise is 0 +- 1 / sqrt(n).
    return bool(products.sum() > TEXTURE_SIGMA * math.sqrt(len(products)) * np.mean(scaled**2))


def _profile(distances: Array, square: float, blur: float) -> tuple[Array, Array]:
    """Return the picture of a disc of unit flux at distances, and its derivative by the square."""
    import scipy  # no part of a start

    many = square > MANY**2 * blur
    nodes, weights = np.polynomial.legendre.leggauss(MORE_NODES if many else NODES)
    parts, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    radii = np.sqrt(parts * abs(square))
    across = distances[:, None] * radii / blur
    if square >= 0.0:
        fall = np.exp(-((distances[:, None] - radii) ** 2) / (2.0 * blur))
        zeroth, first = scipy.special.i0e(across), scipy.special.i1e(across)
    else:  # the same functions of an imaginary radius
        fall = np.exp(-(distances[:, None] ** 2 - radii**2) / (2.0 * blur))
        zeroth, first = scipy.special.j0(across), scipy.special.j1(across)
    ratio = np.where(across > 1e-6, first / np.maximum(across, 1e-6), 0.5)
    slopes = fall * (ratio * distances[:, None] ** 2 / blur - zeroth) / (2.0 * blur)
    scale = 1.0 / (2.0 * math.pi * blur)
    return scale * (fall * zeroth) @ weights, scale * slopes @ (weights * parts)

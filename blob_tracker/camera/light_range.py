"""How far away a light is of which the size or the power is known, from one camera."""

from __future__ import annotations

from dataclasses import dataclass
import math

from blob_tracker.types import Bearing, Location
from blob_tracker.units import MRAD
import numpy as np

# Standard deviations of the radius: of a light that is less resolved the range has no Gaussian
# error. At five it is too great by 6 %, a third of its standard deviation.
RESOLVED_SIGMA = 5.0
APART_SIGMA = 5.0  # between two ranges of one light that are said to agree


class RangeError(ValueError):
    """A light whose range is not known; the message says why."""


@dataclass(frozen=True)
class LightRange:
    """
    How far away a light is.

    Parameters
    ----------
    distance : float
        From the camera's optical centre along the ray, m.
    variance : float
        m^2.
    angle : float
        Under which the light's diameter is seen, rad; 0 where that is not known.

    """

    distance: float
    variance: float
    angle: float = 0.0


@dataclass(frozen=True)
class Ranging:
    """
    What is known of a light and its picture, to tell its range.

    Parameters
    ----------
    psf_sigma : float
        Standard deviation of the picture of a point, image px.
    diameter : float
        Of the light, m; 0 if its size is to tell nothing.
    reference_distance, reference_flux : float
        Where its flux was measured, m, and what it was, DN; 0 if it is to tell nothing.
    calibration_sigma : float
        How well all of them are known, relative standard deviation.

    Raises
    ------
    ValueError
        If something is missing.

    """

    psf_sigma: float
    diameter: float = 0.0
    reference_distance: float = 0.0
    reference_flux: float = 0.0
    calibration_sigma: float = 0.01

    @property
    def tells_range(self) -> bool:
        """Whether size or flux is known."""
        return self.diameter > 0.0 or self.reference_flux > 0.0

    def __post_init__(self) -> None:
        if (self.reference_distance > 0.0) != (self.reference_flux > 0.0):
            raise ValueError(
                'range.reference_distance and range.reference_flux go together: what the '
                'diagnostics show as flux at that distance'
            )
        if not self.psf_sigma > 0.0 and self.tells_range:
            raise ValueError(
                'range.psf_sigma is 0; it must be the sigma of a light so far away that it is a '
                'point, px, which the locator shows in its diagnostics'
            )


def angle_per_pixel(location: Location, bearing: Bearing) -> float:
    """
    Return under which angle a pixel is seen at a place in the picture, rad.

    The square root of the solid angle over the area: with the derivative J of both angles by the
    place, which has made the bearing's covariance J C J^T of the location's C,

        sqrt(|det J| cos(elevation))

    holds for every lens.

    Parameters
    ----------
    location : Location
        Where the light is, px.
    bearing : Bearing
        The same as an angle.

    """
    ratio = np.linalg.det(bearing.covariance) / np.linalg.det(location.covariance)
    return MRAD * math.sqrt(math.sqrt(ratio) * math.cos(MRAD * bearing.elevation))


def range_by_size(
    square: float, square_variance: float, *, pixel: float, diameter: float, psf_sigma: float,
    calibration_sigma: float,
) -> LightRange:
    """
    Return the range of a light of known diameter D from its radius in the picture.

        r = D / 2 tan(p sqrt(q)),    (sigma_r / r)^2 = (sigma_q / 2 q)^2 + s^2

    where a pixel is seen under the angle p. How wide the optics make a point, known to s of its
    width w, is mistaken for a radius: sigma_q^2 has (8 w^2 s)^2 in it.

    Parameters
    ----------
    square, square_variance : float
        Squared radius of the disc, px^2, and its variance, px^4.
    pixel : float
        Angle of a pixel, rad.
    diameter : float
        Of the light, m.
    psf_sigma : float
        Standard deviation of the picture of a point, px.
    calibration_sigma : float
        How well diameter and psf_sigma are known, relative standard deviation.

    Raises
    ------
    RangeError
        If the light is not resolved.

    """
    spread = math.sqrt(square_variance + (8.0 * psf_sigma**2 * calibration_sigma) ** 2)
    if not 2.0 * square >= RESOLVED_SIGMA * spread:
        raise RangeError(
            f'the light is not resolved: its squared radius is {square:.2g} +- {spread:.2g} px^2, '
            'and what the optics blur hides it; its size gives the range once it is nearer'
        )
    half = pixel * math.sqrt(square)
    if not half < math.pi / 2.0:
        raise RangeError('the light fills half of the space: is range.diameter right?')
    distance = diameter / (2.0 * math.tan(half))
    relative = math.hypot(spread / (2.0 * square), calibration_sigma)
    return LightRange(distance, (relative * distance) ** 2, 2.0 * half)


def range_by_flux(
    flux: float, flux_variance: float, *, reference_distance: float, reference_flux: float,
    calibration_sigma: float,
) -> LightRange:
    """
    Return the range of a light whose flux was measured once at a known distance.

        r = r_0 sqrt(F_0 / F),    (sigma_r / r)^2 = (sigma_F / 2 F)^2 + s^2

    Exposure and gain must be as they were then, the light must shine alike to all sides, and the
    lens see it as bright off its axis.

    Parameters
    ----------
    flux, flux_variance : float
        Sum of the light over all pixels, DN, and its variance.
    reference_distance, reference_flux : float
        The distance at which it was measured, m, and the flux, DN.
    calibration_sigma : float
        How well the reference's range is known, relative standard deviation.

    Raises
    ------
    RangeError
        If the flux is not above its noise.

    """
    if not flux >= RESOLVED_SIGMA * math.sqrt(flux_variance):
        raise RangeError(
            f'the light is too faint: {flux:.3g} +- {math.sqrt(flux_variance):.2g} DN in all'
        )
    distance = reference_distance * math.sqrt(reference_flux / flux)
    relative = math.hypot(math.sqrt(flux_variance) / (2.0 * flux), calibration_sigma)
    return LightRange(distance, (relative * distance) ** 2)


def combined(
    by_size: LightRange, by_flux: LightRange, relative_covariance: float = 0.0
) -> LightRange:
    """
    Return the range of a light of which both size and flux give it.

        r = w r_s + (1 - w) r_F,    w = (v_F - c) / (v_s + v_F - 2 c)
        sigma_r^2 = (v_s v_F - c^2) / (v_s + v_F - 2 c)

    of the variances v and the covariance c of the two: generalised least squares.

    Parameters
    ----------
    by_size, by_flux : LightRange
        As `range_by_size` and `range_by_flux` return them.
    relative_covariance : float
        Of the relative errors of both, c / r_s r_F. Of a squared radius q and a flux F of one fit
        it is sigma_qF / 4 q F; what was calibrated has no part in it.

    Raises
    ------
    RangeError
        If the two differ by more than five standard deviations of that.

    """
    one, other = by_size.distance, by_flux.distance
    shared = relative_covariance * one * other
    apart = by_size.variance + by_flux.variance - 2.0 * shared
    off = abs(one - other) / math.sqrt(apart)
    if off > APART_SIGMA:
        raise RangeError(
            f'size and flux give {one:.4g} m and {other:.4g} m, {off:.1f} sigma apart: are '
            'exposure and gain those of range.reference_flux, and range.diameter and '
            'range.psf_sigma right?'
        )
    weight = (by_flux.variance - shared) / apart
    return LightRange(
        weight * one + (1.0 - weight) * other,
        (by_size.variance * by_flux.variance - shared**2) / apart,
        by_size.angle,
    )

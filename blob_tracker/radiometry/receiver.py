"""The camera: from light before its lens to electrons in its pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, inf, pi, sqrt

from blob_tracker.radiometry.error import above_zero, OpticsError, parts
from blob_tracker.radiometry.led import Led
from blob_tracker.radiometry.sunlight import STEP, WAVELENGTHS
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

HC = 6.62607015e-34 * 299792458.0  # J m: Planck's constant and the speed of light, exact (SI)
# Quantum efficiency over its greatest, by wavelength in nm: the usual course of silicon pixels
# that are made for the visible. A data sheet has that of its own.
COURSE = {
    400: 0.60, 450: 0.86, 500: 0.98, 530: 1.0, 550: 0.99, 600: 0.93, 650: 0.83, 700: 0.70,
    750: 0.56, 800: 0.43, 850: 0.30, 900: 0.19, 950: 0.10, 1000: 0.04,
}
DIFFRACTION = 0.42  # sigma of a Gaussian like an Airy disc, in wavelengths times f-number


@dataclass(frozen=True)
class Receiver:
    """
    A lens, a filter and a sensor, by their data sheets.

    Parameters
    ----------
    focal_length : float
        mm.
    pixel : float
        Pitch of the square pixels, um.
    f_number : float
        Focal length over the diameter of the aperture.
    transmission : float
        Of the lens.
    filter_width : float
        Pass band of the filter, nm, about the light's wavelength; infinite is no filter.
    filter_transmission : float
        Within its pass band.
    quantum_efficiency : float
        Electrons a photon at best, see `COURSE`.
    full_well : float
        Most electrons in a pixel; full scale of the converter is taken to be the same.
    read_noise : float
        Electrons.
    bits : int
        Of the converter.
    exposure : float
        s.
    blur : float
        Standard deviation of the image of a point by focus and aberrations, px.

    Raises
    ------
    OpticsError
        For an impossible number.

    Examples
    --------
    A pixel's noise in DN, and the size of a diode's image 100 m away:

    >>> camera = Receiver(focal_length=25.0, full_well=10_000.0, bits=12)
    >>> round(camera.noise.gain, 2), round(camera.noise.read_noise, 2)  # electrons a DN, DN
    (2.44, 1.02)
    >>> round(camera.sigma(Led(1.0), 100.0), 2)  # px
    0.83

    """

    focal_length: float = 25.0
    pixel: float = 3.45
    f_number: float = 2.8
    transmission: float = 0.85
    filter_width: float = inf
    filter_transmission: float = 0.9
    quantum_efficiency: float = 0.65
    full_well: float = 10_000.0
    read_noise: float = 2.5
    bits: int = 12
    exposure: float = 1e-3
    blur: float = 0.8

    def __post_init__(self) -> None:
        above_zero({
            'the focal length, mm,': self.focal_length, 'the pixel, um,': self.pixel,
            'the f-number': self.f_number, 'the full well, e-,': self.full_well,
            'the exposure, s,': self.exposure, 'the blur, px,': self.blur,
        })
        parts({
            'the transmission': self.transmission,
            'the transmission of the filter': self.filter_transmission,
            'the quantum efficiency': self.quantum_efficiency,
        })
        if not self.filter_width > 0.0:  # infinity is none
            raise OpticsError(f'the filter is {self.filter_width:g} nm wide; it must be above 0')
        if not self.read_noise >= 0.0:
            raise OpticsError(f'the read noise is {self.read_noise:g} e-; it must be 0 or more')
        if not 1 <= self.bits <= 16:
            raise OpticsError(f'the converter has {self.bits} bits; it must have 1 to 16')

    def exposed(self, exposure: float) -> Receiver:
        """Return the same with another exposure, s."""
        return replace(self, exposure=exposure)

    @property
    def noise(self) -> SensorNoise:
        """Return the noise of a pixel in DN, as the locator's `noise.*` have it."""
        gain = self.full_well / (2**self.bits - 1)
        return SensorNoise(gain, self.read_noise / gain)

    def electrons_per_joule(self, wavelength: float) -> float:
        """
        Return the electrons that a joule before the lens makes in the sensor, within the filter.

        With the quantum efficiency eta, the wavelength lambda and the transmission tau of lens and
        filter:

            r = tau eta lambda / (h c)

        Parameters
        ----------
        wavelength : float
            nm.

        """
        return float(self._responses(np.array([wavelength]))[0])

    def electrons_of(self, light: Led, irradiance: float) -> float:
        """
        Return the electrons of a flash in all its pixels.

        With the irradiance E before the lens, the aperture's diameter D, the time t for which the
        light is on within the exposure, and the part s of it that the filter lets pass:

            N = E (pi D^2 / 4) t s r,    r = tau eta lambda / (h c)

        Parameters
        ----------
        light : Led
            The light.
        irradiance : float
            W/m^2.

        """
        aperture = 0.25 * pi * (1e-3 * self.focal_length / self.f_number) ** 2
        energy = irradiance * aperture * self.seen_for(light) * light.passed(self.filter_width)
        return energy * self.electrons_per_joule(light.wavelength)

    def seen_for(self, light: Led) -> float:
        """Return how long the light is on within the exposure, s."""
        return min(light.flash or self.exposure, self.exposure)

    def background(self, radiance: NDArray[np.float64], wavelength: float) -> float:
        """
        Return the electrons of what is behind the light, in each pixel.

        The image of a wide surface of the radiance L has the irradiance pi L tau / (4 F^2), with
        the f-number F, at any distance (the camera equation, on the axis). On a pixel of the pitch
        p, in the exposure t, with the electrons r a joule:

            b = p^2 t sum_k pi L_k / (4 F^2) r_k Delta_k

        over the steps of the wavelength, of which the filter passes Delta_k nm each.

        Parameters
        ----------
        radiance : (61,) array
            W/m^2/sr/nm, at `WAVELENGTHS`.
        wavelength : float
            Middle of the filter's pass band, nm.

        """
        low, high = wavelength - 0.5 * self.filter_width, wavelength + 0.5 * self.filter_width
        upper, lower = WAVELENGTHS + 0.5 * STEP, WAVELENGTHS - 0.5 * STEP
        share = (np.minimum(upper, high) - np.maximum(lower, low)).clip(0.0)  # nm of each step
        image = 0.25 * pi * radiance / self.f_number**2
        energy = image * share * (1e-6 * self.pixel) ** 2 * self.exposure
        return float(energy @ self._responses(WAVELENGTHS))

    def sigma(self, light: Led, distance: float) -> float:
        """
        Return the standard deviation of the light's image, px.

        Of blur, diffraction and the disc itself (`blob_tracker.simulation.Optics`), in um with
        the pitch p:

            sigma^2 = blur^2 + (0.42 lambda F / p)^2 + (d f / (4 R p))^2

        Parameters
        ----------
        light : Led
            The light.
        distance : float
            R, m.

        """
        spread = DIFFRACTION * 1e-3 * light.wavelength * self.f_number / self.pixel
        own = 1e3 * self.focal_length * light.diameter / (4.0 * distance * self.pixel)
        return hypot(self.blur, spread, own)

    def _responses(self, wavelengths: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the electrons a joule before the lens, at wavelengths in nm."""
        course = np.interp(wavelengths, list(COURSE), list(COURSE.values()))
        glass = self.transmission * (
            self.filter_transmission if np.isfinite(self.filter_width) else 1.0
        )
        return np.asarray(
            glass * self.quantum_efficiency * course * 1e-9 * wavelengths / HC
        )


def matched_snr(peak: float, sigma: float, variance: float) -> float:
    """
    Return the signal-to-noise ratio in a filter of the blob's own width.

    As the segmenter reckons it for `min_snr` (`blob_tracker.segmentation.adaptive_moments`): with
    w = exp(-r^2 / 2 sigma^2), and the peak A above pixels of the variance V,

        SNR = A sum(w^2) / sqrt(V sum(w^2)) = A sigma sqrt(pi / V)

    Parameters
    ----------
    peak : float
        A, electrons.
    sigma : float
        px.
    variance : float
        V, electrons^2.

    """
    return peak * sigma * sqrt(pi / variance)

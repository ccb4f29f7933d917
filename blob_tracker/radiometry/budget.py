"""The link budget: is a light found at a range, and how well is its angle known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, erf, inf, pi, sqrt

from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.radiometry.error import above_zero, OpticsError
from blob_tracker.radiometry.led import Led
from blob_tracker.radiometry.receiver import matched_snr, Receiver
from blob_tracker.radiometry.surroundings import Surroundings
from blob_tracker.units import MRAD_PER_RAD
import numpy as np

LEAST_SNR = 7.0  # the segmenter's default `min_snr`
DROWNED = 'drowned by the light behind it'
AIM = 0.7  # of full scale at the peak, as find_exposure aims
WINDOW_SIGMA = 4.0  # half-width of the window for the bound
MOST_SIGMA = 8.0  # px: a wider blob has pixels of several, which tell as much of its position
LEAST_FOCAL_LENGTHS = 10.0  # nearer the image is not in the focal plane, nor the lens a point
MOST_WIDTH = 10_000.0  # px, of the image of what shines: a sensor has few more
PHASES = (0.0, 0.25, 0.5)  # px: the bound depends on where in its pixel a narrow blob lies


@dataclass(frozen=True)
class Budget:
    """
    What comes of a light at a range.

    Parameters
    ----------
    transmittance : float
        Of the air.
    irradiance : float
        Before the lens, W/m^2.
    electrons : float
        Of a flash, in all pixels.
    sigma : float
        Standard deviation of its image, px.
    peak : float
        Electrons of the flash in the brightest pixel, its centre on the pixel's.
    background : float
        Electrons of what is behind it, in each pixel.
    snr : float
        Of lit less unlit in a filter matched to the blob: it is found above `LEAST_SNR`.
    snr_one_frame : float
        The same of the lit frame alone, in which the pattern of the scene hides it.
    snr_in_the_dark : float
        That of lit less unlit with nothing behind it.
    bound_px : float
        Least standard deviation of its position along an axis, px; infinite where pixels are full.
    bound_mrad : float
        The same as an angle on the optical axis.
    full : float
        Part of the full well that background and peak fill together.
    background_full : float
        Part of it that the background alone fills.
    fitting_exposure : float
        At which the peak fills `AIM` of the full well, s.

    Examples
    --------
    Half as far away a light has four times the electrons, and some more by the clearer air:

    >>> far, near = (
    ...     link_budget(Led(1.0), Receiver(filter_width=10.0), Surroundings(50.0), distance)
    ...     for distance in (2000.0, 1000.0)
    ... )
    >>> round(near.electrons / far.electrons, 1), near.bound_px < far.bound_px
    (4.3, True)

    """

    transmittance: float
    irradiance: float
    electrons: float
    sigma: float
    peak: float
    background: float
    snr: float
    snr_one_frame: float
    snr_in_the_dark: float
    bound_px: float
    bound_mrad: float
    full: float
    background_full: float
    fitting_exposure: float

    @property
    def verdict(self) -> str:
        """Return in a sentence whether it is found, and if not, why."""
        if self.background_full >= 1.0:
            return 'the background alone saturates the pixels'
        if self.full >= 1.0:
            return 'light and background together saturate the pixels'
        if self.snr >= LEAST_SNR:
            return 'found'
        return 'too faint' if self.snr_in_the_dark < LEAST_SNR else DROWNED


def nearest(light: Led, camera: Receiver) -> float:
    """
    Return the least range that has a budget, m.

    That of ten focal lengths f, or where an image of d f / (R p) pixels is wider than a sensor.
    """
    width = 1e3 * camera.focal_length * light.diameter / camera.pixel  # px at 1 m
    return max(LEAST_FOCAL_LENGTHS * 1e-3 * camera.focal_length, width / MOST_WIDTH)


def link_budget(
    light: Led, camera: Receiver, surroundings: Surroundings, distance: float
) -> Budget:
    """
    Reckon what a camera sees of a light.

    The irradiance before the lens is I T / R^2. The flash makes N electrons (`Receiver`) in a
    Gaussian of the standard deviation sigma, with b electrons behind it in each pixel:

        peak = N erf(1 / (2 sqrt(2) sigma))^2,    V = b + read_noise^2 + gain^2 / 12

    electrons^2. In the difference of the lit and the unlit frame V is there twice, and the pattern
    of a scene that stands still is gone. In the lit frame alone the pattern, of the standard
    deviation c b and as wide as the blob, has to be exceeded as well. With A = N / (2 pi sigma^2)
    in a matched filter (`matched_snr`):

        SNR = A sigma sqrt(pi / (2 V)),    SNR_1 = A sigma sqrt(pi / (V + 4 pi sigma^2 (c b)^2))

    Parameters
    ----------
    light : Led
        What flashes.
    camera : Receiver
        What looks.
    surroundings : Surroundings
        Air and daylight.
    distance : float
        R, m.

    Raises
    ------
    OpticsError
        For a distance that is not above 0, or less than `nearest`.

    Examples
    --------
    A red diode of 1 W by day, a kilometre away, through a filter of 10 nm:

    >>> budget = link_budget(Led(1.0), Receiver(filter_width=10.0), Surroundings(), 1000.0)
    >>> round(budget.electrons), round(budget.snr, 1)
    (3684, 18.9)
    >>> budget.verdict
    'found'

    """
    _check_range(light, camera, distance)
    transmittance = surroundings.transmittance(distance, light.wavelength)
    irradiance = light.intensity() * transmittance / distance**2
    electrons = camera.electrons_of(light, irradiance)
    background = camera.background(surroundings.radiance(), light.wavelength)
    sigma = camera.sigma(light, distance)
    peak = electrons * _in_its_pixel(sigma)
    gain = camera.noise.gain
    dark = camera.read_noise**2 + gain**2 / 12.0
    variance = background + dark
    unsampled = electrons / (2.0 * pi * sigma**2)
    pattern = surroundings.texture * background * 2.0 * sigma * sqrt(pi)
    full = (background + peak) / camera.full_well
    bound = inf
    if full < 1.0 and unsampled > 0.0:
        bound = _bound(camera, sigma, unsampled, background)
    return Budget(
        transmittance, irradiance, electrons, sigma, peak, background,
        snr=matched_snr(unsampled, sigma, 2.0 * variance),
        snr_one_frame=matched_snr(unsampled, sigma, variance + pattern**2),
        snr_in_the_dark=matched_snr(unsampled, sigma, 2.0 * dark),
        bound_px=bound,
        bound_mrad=MRAD_PER_RAD * 1e-3 * camera.pixel / camera.focal_length * bound,
        full=full,
        background_full=background / camera.full_well,
        fitting_exposure=_fitting_exposure(light, camera, peak, background),
    )


def _check_range(light: Led, camera: Receiver, distance: float) -> None:
    """Refuse a range that has no budget."""
    above_zero({'the range, m,': distance})
    least = nearest(light, camera)
    if distance < least:
        raise OpticsError(
            f'the range is {distance:g} m; for a light of {1e3 * light.diameter:g} mm and '
            f'{camera.focal_length:g} mm of focal length it must be {least:.3g} m or more, '
            f'{LEAST_FOCAL_LENGTHS:g} focal lengths and an image of {MOST_WIDTH:g} px at most'
        )


def _in_its_pixel(sigma: float) -> float:
    """Return the part of a Gaussian that falls into the pixel about its centre."""
    return erf(0.5 / (sqrt(2.0) * sigma)) ** 2


def _bound(camera: Receiver, sigma: float, unsampled: float, background: float) -> float:
    """Return the Cramer-Rao bound along x of lit less unlit, px, rms over the phases."""
    side = max(int(sigma / MOST_SIGMA), 1)  # px, of what is taken for one pixel
    area, sigma = side**2, sigma / side
    half = max(ceil(WINDOW_SIGMA * sigma), 2)
    gain = camera.noise.gain
    # Of each of them with its step of 1 DN, less the one that the bound adds.
    read_noise = sqrt(area * (camera.noise.read_noise**2 + 1.0 / 12.0) - 1.0 / 12.0)
    variances = [
        cramer_rao_bound(
            (2 * half + 1, 2 * half + 1), x=half + phase, y=half + phase, sigma=sigma,
            amplitude=area * unsampled / gain, background=area * background / gain,
            noise=replace(camera.noise, read_noise=read_noise), unlit=True,
        )[0, 0]
        for phase in PHASES
    ]
    return side * float(np.sqrt(np.mean(variances)))


def _fitting_exposure(light: Led, camera: Receiver, peak: float, background: float) -> float:
    """Return the exposure at which the brightest pixel is at its aim, s."""
    aim = AIM * camera.full_well
    seen = camera.seen_for(light)
    both = aim / (background / camera.exposure + peak / seen)  # the light is on all the while
    if not light.flash or both <= light.flash:
        return both
    # A longer exposure adds no more of the light.
    return (aim - peak / seen * light.flash) / (background / camera.exposure)

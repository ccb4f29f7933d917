"""Air and daylight between a light and a camera, and behind the light."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

from blob_tracker.radiometry.error import above_zero, OpticsError, parts
from blob_tracker.radiometry.sunlight import LEVELS, scene_radiance, sky_radiance
import numpy as np
from numpy.typing import NDArray

CONTRAST_LOG = 3.912  # ln 50: Koschmieder's visual range is where 2 % of the contrast is left
GREEN = 550.0  # nm, at which a visual range is told


@dataclass(frozen=True)
class Surroundings:
    """
    The air, and what is behind the light.

    Parameters
    ----------
    visibility : float
        Visual range, km: 50 in very clear air, 23 in clear air, 10 in haze, 1 in thin fog.
    light : str
        One of `LEVELS`: how much light is on the scene.
    albedo : float
        Part of it that the scene behind the light sends back.
    sky : bool
        The light is seen before the sky, and not before a scene.
    texture : float
        Standard deviation of the scene's pattern as a part of its mean.

    Raises
    ------
    OpticsError
        For an impossible number.

    Examples
    --------
    What clear air and haze let through over 1 km:

    >>> for visibility in (23.0, 10.0):
    ...     print(round(Surroundings(visibility).transmittance(1000.0, 630.0), 2))
    0.87
    0.72

    """

    visibility: float = 23.0
    light: str = 'sun'
    albedo: float = 0.3
    sky: bool = False
    texture: float = 0.2

    def __post_init__(self) -> None:
        above_zero({'the visibility, km,': self.visibility})
        parts({'the albedo': self.albedo})
        if self.light not in LEVELS:
            raise OpticsError(f'the light is {self.light}; it must be one of {", ".join(LEVELS)}')
        if not self.texture >= 0.0:
            raise OpticsError(f'the texture is {self.texture:g}; it must be 0 or more')

    def transmittance(self, distance: float, wavelength: float) -> float:
        """
        Return the part of a light that the air lets through.

        With Koschmieder's visual range V, the extinction at other wavelengths after Kruse
        (Kruse, McGlauchlin and McQuistan, Elements of Infrared Technology, 1962):

            T = exp(-3.912 R / V (wavelength / 550 nm)^-q)

        with q = 1.6 above 50 km, 1.3 above 6 km, and 0.585 V^(1/3), V in km, below.

        Parameters
        ----------
        distance : float
            R, m.
        wavelength : float
            nm.

        """
        km = self.visibility
        exponent = 1.6 if km > 50.0 else 1.3 if km > 6.0 else 0.585 * km ** (1.0 / 3.0)
        extinction = CONTRAST_LOG / km * (wavelength / GREEN) ** -exponent  # 1/km
        return exp(-1e-3 * distance * extinction)

    def radiance(self) -> NDArray[np.float64]:
        """
        Return the spectral radiance behind the light, (61,) W/m^2/sr/nm at `WAVELENGTHS`.

        What haze takes from a far scene it gives back as light of its own, so that the distance
        is left out.
        """
        level = LEVELS[self.light]
        return sky_radiance(level) if self.sky else scene_radiance(self.albedo, level)

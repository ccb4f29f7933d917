"""Sunlight by wavelength: what a scene and the sky send into a camera."""

from __future__ import annotations

from math import cos, pi, radians

import numpy as np
from numpy.typing import NDArray

# ASTM G173-03, air mass 1.5: spectral irradiance of a surface tilted by 37 degrees towards the sun
# ("global tilt") and of one that faces it, without the sky ("direct + circumsolar"). Means over
# the 10 nm about each wavelength, W/m^2/nm.
WAVELENGTHS = np.arange(400.0, 1001.0, 10.0)  # nm
STEP = 10.0  # nm
GLOBAL = np.array([
    0.995, 1.165, 1.222, 1.127, 1.347, 1.499, 1.564, 1.554, 1.598, 1.511,
    1.543, 1.559, 1.489, 1.532, 1.534, 1.542, 1.513, 1.493, 1.504, 1.447,
    1.466, 1.471, 1.443, 1.409, 1.447, 1.401, 1.354, 1.414, 1.394, 1.208,
    1.291, 1.306, 1.099, 1.116, 1.220, 1.238, 0.786, 1.082, 1.167, 1.116,
    1.083, 1.034, 0.876, 0.931, 1.001, 0.961, 0.984, 0.940, 0.938, 0.904,
    0.705, 0.675, 0.702, 0.465, 0.305, 0.336, 0.414, 0.611, 0.652, 0.742,
    0.735,
])
DIRECT = np.array([
    0.751, 0.899, 0.963, 0.904, 1.098, 1.238, 1.308, 1.314, 1.365, 1.301,
    1.338, 1.359, 1.305, 1.348, 1.355, 1.367, 1.346, 1.334, 1.347, 1.299,
    1.320, 1.325, 1.302, 1.274, 1.308, 1.268, 1.226, 1.281, 1.263, 1.097,
    1.172, 1.185, 1.001, 1.018, 1.113, 1.131, 0.721, 0.994, 1.072, 1.027,
    0.998, 0.955, 0.812, 0.863, 0.927, 0.891, 0.913, 0.874, 0.873, 0.842,
    0.660, 0.633, 0.658, 0.437, 0.287, 0.317, 0.391, 0.575, 0.613, 0.698,
    0.691,
])
# The sun stands 48.19 degrees from the zenith (air mass 1.5), so that its rays meet the tilted
# surface at this angle.
INCIDENCE = radians(48.19 - 37.0)
# Light on the scene as a part of that of full sun, 110,000 lx: thick clouds, civil twilight
# (10 lx) and a clear night with some moon (0.01 lx). Orders of magnitude, in sunlight's colour.
LEVELS = {'sun': 1.0, 'overcast': 0.1, 'dusk': 1e-4, 'night': 1e-7}


def scene_radiance(albedo: float, level: float = 1.0) -> NDArray[np.float64]:
    """
    Return the spectral radiance of a matt surface in the light of the sun and the sky.

    A Lambertian surface sends back albedo x E evenly over the hemisphere:

        L = albedo E / pi

    Parameters
    ----------
    albedo : float
        Part of the light that it sends back: grass 0.2, concrete 0.3, snow 0.8.
    level : float
        Of the light, see `LEVELS`.

    Returns
    -------
    (61,) array
        W/m^2/sr/nm, at `WAVELENGTHS`.

    Examples
    --------
    Snow and grass in the sun, at 550 nm:

    >>> snow, grass = (np.interp(550.0, WAVELENGTHS, scene_radiance(part)) for part in (0.8, 0.2))
    >>> round(float(snow), 2), round(float(grass), 2)  # W/m^2/sr/nm
    (0.39, 0.1)

    """
    return np.asarray(albedo * level * GLOBAL / pi)


def sky_radiance(level: float = 1.0) -> NDArray[np.float64]:
    """
    Return the spectral radiance of the clear sky, the mean of it away from the sun.

    What of the light on the tilted surface does not come straight from the sun, over a hemisphere
    that is even (the little that the ground sends back with it):

        L = (E_global - E_direct cos incidence) / pi

    Parameters
    ----------
    level : float
        Of the light, see `LEVELS`.

    Returns
    -------
    (61,) array
        W/m^2/sr/nm, at `WAVELENGTHS`. Near the horizon a sky is two to four times as bright.

    Examples
    --------
    A clear sky is brighter in the blue than in the red:

    >>> blue, red = np.interp([450.0, 650.0], WAVELENGTHS, sky_radiance())
    >>> round(float(blue / red), 1)
    1.8

    """
    return np.asarray(level * (GLOBAL - DIRECT * cos(INCIDENCE)) / pi)

"""From metres to pixels: how wide and how bright a light at a range is seen, and where."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import nan

from blob_tracker.camera import CameraModel
from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.spot import draw_light, Spot
from blob_tracker.simulation.waveforms import always, Waveform
import numpy as np
from numpy.typing import NDArray

STEP_RAD = 1e-4  # rad between the rays that tell the scale of the picture about a place


@dataclass(frozen=True)
class Optics:
    """
    A lens: where, how wide and how bright the image of a light is.

    Parameters
    ----------
    camera : CameraModel
        Focal length and distortion.
    blur : float
        Standard deviation of the image of a point, px.

    Examples
    --------
    A ball of 50 mm at 10 m and at 1 m, before a lens of 600 px:

    >>> from blob_tracker.camera import pinhole_matrix
    >>> optics = Optics(CameraModel(640, 480, pinhole_matrix(600.0, 640, 480)), blur=1.0)
    >>> for distance in (10.0, 1.0):
    ...     spot = optics.spot((0.0, 0.0, distance), diameter=0.05, luminance=150.0)
    ...     print(round(spot.sigma, 1), round(spot.amplitude))  # px, DN
    1.2 54
    7.6 147

    """

    camera: CameraModel
    blur: float = 1.0

    def spot(
        self, place: tuple[float, float, float], diameter: float, luminance: float
    ) -> Spot:
        """
        Return the image of a ball of light.

        A disc of the diameter D has the standard deviation D / 4 along each axis. At the range R
        its image has D f / 4 R, with f the local scale of the picture in px/rad, and the blur
        adds its variance. The light in the image falls with 1 / R^2:

            sigma^2 = blur^2 + (D f / 4 R)^2,    amplitude = luminance (D f / 4 R)^2 / sigma^2

        so that the peak of a light that is not resolved falls with 1 / R^2, and that of a near
        one does not change.

        Parameters
        ----------
        place : (float, float, float)
            X right, Y down, Z forward in the optical frame, m.
        diameter : float
            m.
        luminance : float
            Peak of its image where it is near, DN.

        Returns
        -------
        Spot
            Of the picture, px and DN; NaN where the lens has no picture of the place.

        """
        ray = np.array(place, dtype=float)
        distance = np.linalg.norm(ray)
        ray /= distance
        across = np.cross(ray, (0.0, 1.0, 0.0) if abs(ray[1]) < 0.7 else (1.0, 0.0, 0.0))
        across /= np.linalg.norm(across)
        steps = 0.5 * STEP_RAD * np.array([across, -across, np.cross(ray, across)])
        steps = np.vstack([steps, -steps[2:]])
        (x, y), first, second, third, fourth = self.camera.project(np.vstack([ray, ray + steps]))
        (a, b), (c, d) = (first - second) / STEP_RAD, (third - fourth) / STEP_RAD  # px/rad
        area = a * d - b * c
        if not np.isfinite(area):
            return Spot(nan, nan, nan, nan)
        own = 0.25 * diameter / distance * np.sqrt(abs(area))
        sigma = np.hypot(self.blur, own)
        return Spot(float(x), float(y), float(sigma), float(luminance * (own / sigma) ** 2))


@dataclass(frozen=True)
class SpatialLight:
    """
    A ball of light in space, seen through a lens: it grows as it comes near.

    Parameters
    ----------
    optics : Optics
        The lens; its camera model is that of the scene's frames.
    place : callable
        From a time, s, to X, Y and Z in the optical frame, m.
    diameter : float
        m.
    luminance : float
        Peak of its image where it is near and its waveform is 1, DN.
    waveform : callable
        From times, s, to parts of the luminance, see `waveforms`.
    profile : Profile
        Shape of its image, see `profiles`.

    Examples
    --------
    A ball of 50 mm that comes nearer by 2 m/s:

    >>> from blob_tracker.camera import pinhole_matrix
    >>> optics = Optics(CameraModel(640, 480, pinhole_matrix(600.0, 640, 480)))
    >>> ball = SpatialLight(optics, lambda time: (0.0, 0.0, 5.0 - 2.0 * time), 0.05, 150.0)
    >>> [round(ball.spot(time).sigma, 1) for time in (0.0, 2.0)]  # px
    [1.8, 7.6]

    """

    optics: Optics
    place: Callable[[float], tuple[float, float, float]]
    diameter: float
    luminance: float
    waveform: Waveform = always
    profile: Profile = Gaussian()

    def spot(self, time: float) -> Spot:
        """Return its image at a time, px; NaN where it has none."""
        return self.optics.spot(self.place(time), self.diameter, self.luminance)

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add the light, see `draw_light`."""
        draw_light(self, picture, shot)

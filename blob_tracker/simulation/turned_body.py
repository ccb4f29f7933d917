"""A body with lights that someone turns before one camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

SWINGS = 4  # that are added up for each angle and each coordinate
SLOWEST_HZ, FASTEST_HZ = 0.05, 0.6
SWAY_M = 0.1  # standard deviation of the place along each axis


@dataclass(frozen=True)
class TurnedBody:
    """
    A body, and how it is moved.

    Parameters
    ----------
    places : (n, 3) array
        Of its lights, m.
    distance : float
        From the camera, m.
    turning : float
        Standard deviation of its turn about each of two axes across the line of sight, rad; about
        that line it is turned as far.
    sway : float
        Standard deviation of its place along each axis, m.

    """

    places: Array
    distance: float = 2.0
    turning: float = 0.5
    sway: float = SWAY_M

    def seen(
        self, rng: np.random.Generator, *, seconds: float = 15.0, rate: float = 20.0,
        sigma: float = 1e-4, at_once: bool = False, lit: float = 1.0,
    ) -> list[tuple[Array, Array, Array]]:
        """
        Return what the camera sees of each light.

        Parameters
        ----------
        rng : numpy Generator
            Draws the motion and the noise.
        seconds, rate : float
            Length of the recording, s, and frames a second.
        sigma : float
            Standard deviation of a bearing, rad.
        at_once : bool
            Whether all lights have the stamp of the frame; else each is seen within half of it.
        lit : float
            Share of the frames in which a light is lit.

        Returns
        -------
        list of ((m,) array, (m, 2) array, (m, 2, 2) array)
            Of each light: stamps, s; azimuth and elevation, rad; their covariance, rad^2.

        """
        frequencies = rng.uniform(SLOWEST_HZ, FASTEST_HZ, (6, SWINGS))
        phases = rng.uniform(0.0, 2.0 * np.pi, (6, SWINGS))
        size = np.sqrt(2.0 / SWINGS) * np.repeat([self.sway, self.turning], 3)
        frames = np.arange(0.0, seconds, 1.0 / rate)
        found = []
        for place in self.places:
            late = 0.0 if at_once else 0.5 / rate
            times = frames + rng.uniform(0.0, 1.0, len(frames)) * late
            times = times[rng.uniform(size=len(times)) < lit]
            angles = 2.0 * np.pi * frequencies[:, :, None] * times + phases[:, :, None]
            moved = size[:, None] * np.sin(angles).sum(axis=1)
            points = Rotation.from_rotvec(moved[3:].T).apply(place) + moved[:3].T
            points[:, 2] += self.distance
            x, y, z = points.T
            seen = np.stack([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))], axis=1)
            seen += sigma * rng.standard_normal(seen.shape)
            covariance = np.broadcast_to(sigma**2 * np.eye(2), (len(times), 2, 2))
            found.append((times, seen, covariance))
        return found


def places_error(
    found: Array, covariance: Array, size_sigma: float, true: Array
) -> tuple[float, int, float]:
    """
    Return by how much the places of a body's lights are off, whatever their frame.

    Parameters
    ----------
    found : (n, 3) array
        Places in any frame, m.
    covariance : (3 n, 3 n) array
        Of them among each other, m^2.
    size_sigma : float
        Standard deviation of the size that all of them share, over the size.
    true : (n, 3) array
        Where they are, m.

    Returns
    -------
    squared : float
        The squared error over the covariance.
    degrees : int
        Its mean where that is true: three for each light, less the six of the frame.
    rms : float
        Of the error of a coordinate, m.

    """
    found, true = found - found.mean(axis=0), true - true.mean(axis=0)
    left, _, right = np.linalg.svd(found.T @ true)
    turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    error = (true @ turn.T - found).ravel()
    beside = size_sigma * found.ravel()
    values, vectors = np.linalg.eigh(covariance + np.outer(beside, beside))
    degrees = true.size - 6
    along = vectors[:, -degrees:].T @ error
    squared = float((along**2 / values[-degrees:]).sum())
    return squared, degrees, float(np.sqrt((error**2).mean()))

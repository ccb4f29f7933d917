"""A light, or a wand of two, that someone waves before the cameras of a rig."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIDDLE_M = np.array([0.0, 0.0, 3.0])  # of where it is waved
REACH_M = np.array([0.35, 0.25, 0.5])  # of each of the swings that are added up
SWINGS = 6
SLOWEST_HZ, FASTEST_HZ = 0.1, 0.9


@dataclass(frozen=True)
class RigCamera:
    """
    A camera of the rig.

    Parameters
    ----------
    position : (3,) array
        Of its optical centre, m; y is down, z ahead.
    rate : float
        Frames a second.
    offset : float
        By which its clock is ahead, s.
    roll : float
        About its optical axis, which looks at the middle of the waving, rad.
    field : float
        Angle from the axis, across and up, that it sees to, rad.

    """

    position: Sequence[float]
    rate: float = 30.0
    offset: float = 0.0
    roll: float = 0.0
    field: float = 0.6

    @property
    def rotation(self) -> Array:
        """Return the turn that takes components in the optical frame to the room's."""
        ahead = MIDDLE_M - np.asarray(self.position)
        ahead = ahead / np.linalg.norm(ahead)
        across = np.cross([0.0, 1.0, 0.0], ahead)
        across = across / np.linalg.norm(across)
        level = np.stack([across, np.cross(ahead, across), ahead], axis=1)
        sine, cosine = np.sin(self.roll), np.cos(self.roll)
        return level @ np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


class WavedLight:
    """
    The path of a hand, sums of slow swings, and of a stick that it holds by the middle.

    Parameters
    ----------
    rng : numpy Generator
        Draws the swings.
    wand : float
        Distance of the lights at both ends of the stick, m; 0 for one light.

    """

    def __init__(self, rng: np.random.Generator, wand: float = 0.0) -> None:
        self.lights = 2 if wand > 0.0 else 1
        self._wand = wand
        self._frequencies = rng.uniform(SLOWEST_HZ, FASTEST_HZ, (3, SWINGS))
        self._phases = rng.uniform(0.0, 2.0 * np.pi, (3, SWINGS))
        self._reach = REACH_M[:, None] * rng.uniform(0.3, 0.7, (3, SWINGS))
        self._turning = rng.uniform(SLOWEST_HZ, 0.4, 2), rng.uniform(0.0, 2.0 * np.pi, 2)

    def position(self, times: Array, light: int = 0) -> Array:
        """Return where a light is, (n, 3), m."""
        angles = 2.0 * np.pi * self._frequencies[:, :, None] * times + self._phases[:, :, None]
        hand = MIDDLE_M + (self._reach[:, :, None] * np.sin(angles)).sum(axis=1).T
        turn, rise = 2.0 * np.pi * self._turning[0][:, None] * times + self._turning[1][:, None]
        rise = np.sin(rise)
        along = np.stack(
            [np.cos(rise) * np.cos(turn), np.sin(rise), np.cos(rise) * np.sin(turn)], axis=1
        )
        return np.asarray(hand + (0.5 - light) * self._wand * along)

    def seen(
        self, camera: RigCamera, light: int, seconds: float, sigma: float,
        rng: np.random.Generator,
    ) -> tuple[Array, Array, Array]:
        """
        Return what a camera sees of a light.

        Returns
        -------
        (n,) array, (n, 2) array, (n, 2, 2) array
            Stamps of its clock, s; azimuth and elevation with noise, rad; their covariance,
            rad^2, of standard deviations about `sigma`.

        """
        times = np.arange(rng.uniform(0.0, 1.0 / camera.rate), seconds, 1.0 / camera.rate)
        x, y, z = ((self.position(times, light) - np.asarray(camera.position)) @ camera.rotation).T
        angles = np.stack([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))], axis=1)
        kept = np.abs(angles).max(axis=1) < camera.field
        sigmas = sigma * rng.uniform(0.7, 1.4, len(times))
        angles = angles + sigmas[:, None] * rng.standard_normal(angles.shape)
        covariance = sigmas[:, None, None] ** 2 * np.eye(2)
        return times[kept] + camera.offset, angles[kept], covariance[kept]

"""A camera that a pan/tilt turns before a light that stands still, as rays and joint angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

PAN_HZ, TILT_HZ = 0.11, 0.27  # of the swings: not in step
JOINTS_HZ = 50.0
REST_S = 1.0  # of the joints' angles before and after the rays


@dataclass(frozen=True)
class PannedCamera:
    """
    How the camera sits on the pan/tilt.

    Parameters
    ----------
    pan_axis, tilt_axis : (3,) arrays
        Unit vectors in the optical frame at both angles 0.
    pan_point, tilt_point : (3,) arrays
        On these axes, m.
    light : (3,) array
        Where the light is in that frame, m.
    clock : float
        How late the stamps of the rays are, s.
    swing : float
        Amplitude of both joints, rad.

    """

    pan_axis: Array
    tilt_axis: Array
    pan_point: Array
    tilt_point: Array
    light: Array
    clock: float = 0.0
    swing: float = 0.3

    def seen(
        self, rng: np.random.Generator, *, seconds: float = 20.0, rate: float = 20.0,
        sigma: float = 1e-4,
    ) -> tuple[tuple[Array, Array, Array], tuple[Array, Array]]:
        """
        Return the rays, and pan and tilt with their stamps.

        Returns
        -------
        ((n,), (n, 2), (n, 2, 2) arrays), ((m,), (m, 2) arrays)
            Stamps, s, angles of the rays, rad, and covariances; stamps and angles of the joints.

        """
        times = np.arange(0.0, seconds, 1.0 / rate) + rng.uniform(0.0, 0.01)
        pan, tilt = self._turns(times).T
        local = Rotation.from_rotvec(-pan[:, None] * self.pan_axis).apply(
            self.light - self.pan_point) + self.pan_point - self.tilt_point
        x, y, z = (
            Rotation.from_rotvec(-tilt[:, None] * self.tilt_axis).apply(local) + self.tilt_point
        ).T
        angles = np.stack([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))], axis=1)
        angles += sigma * rng.standard_normal(angles.shape)
        covariance = np.broadcast_to(sigma**2 * np.eye(2), (len(times), 2, 2))
        ticks = np.arange(-REST_S, seconds + REST_S, 1.0 / JOINTS_HZ)
        return (times + self.clock, angles, covariance), (ticks, self._turns(ticks))

    def _turns(self, times: Array) -> Array:
        return self.swing * np.sin(2.0 * np.pi * np.outer(times, [PAN_HZ, TILT_HZ]))

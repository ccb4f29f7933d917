"""The rays of cameras: their directions, what is near to all, and what is seen of a point."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.kernel import Array
from blob_tracker.tracking.camera_pose import CameraPose
import numpy as np


def direction(azimuth: float, elevation: float) -> Array:
    """Return the unit vector of the optical frame in a direction, rad."""
    level = math.cos(elevation)
    return np.array(
        [level * math.sin(azimuth), -math.sin(elevation), level * math.cos(azimuth)]
    )


def tangents(azimuth: float, elevation: float) -> Array:
    """Return the (3, 2) derivative of the direction by both angles."""
    sine, cosine = math.sin(azimuth), math.cos(azimuth)
    return np.array([
        [math.cos(elevation) * cosine, -math.sin(elevation) * sine],
        [0.0, -math.cos(elevation)],
        [-math.cos(elevation) * sine, -math.sin(elevation) * cosine],
    ])


def nearest_point(directions: Array, centres: Array) -> Array:
    """Return the point with the least squared distance from all rays."""
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    return np.linalg.solve(across.sum(axis=0), np.einsum('iab,ib->a', across, centres))


def linearised(
    position: Array, seen: Array, poses: Sequence[CameraPose]
) -> tuple[Array, Array, Array]:
    """
    Return what each camera sees of a position.

    Returns
    -------
    (n, 2) array, (n, 2, 3) array, (n, 2, 2) array
        Residuals, rad, their derivative J by the position, rad/m, less its sign, and the
        covariance E of the angles by the errors of the pose, rad^2.

    """
    residuals, jacobians, errors = [], [], []
    for angles, pose in zip(seen, poses, strict=True):
        x, y, z = pose.rotation.T @ (position - pose.position)
        level = math.hypot(x, z)
        square = level**2 + y**2
        by_local = np.array([
            [z / level**2, 0.0, -x / level**2],
            [x * y / (level * square), -level / square, z * y / (level * square)],
        ])
        jacobian = by_local @ pose.rotation.T
        # [p]x, the derivative of the local position by a turn of the camera.
        turned = by_local @ np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        residual = angles - (math.atan2(x, z), math.atan2(-y, level))
        residual[0] = math.remainder(residual[0], math.tau)
        residuals.append(residual)
        jacobians.append(jacobian)
        errors.append(
            pose.position_sigma**2 * jacobian @ jacobian.T
            + pose.rotation_sigma**2 * turned @ turned.T
        )
    return np.array(residuals), np.array(jacobians), np.array(errors)

"""The rays of cameras: their directions, what is near to all, and what is seen of a point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.tracking.camera_pose import CameraPose
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np

TURN_RAD = 2.0 * np.pi


class Rays(NamedTuple):
    """
    Rays of cameras, one of each.

    Parameters
    ----------
    seen : (n, 2) array
        Azimuth and elevation in each camera's optical frame, rad.
    noise : (n, 2, 2) array
        Their covariance, rad^2.
    rotations : (n, 3, 3) array
        Take components in the optical frames to those in the reference.
    centres : (n, 3) array
        Where the cameras are in the reference, m.
    directions : (n, 3) array
        Unit vectors of the rays in the reference.
    of_poses : (n, n, 6, 6) array
        Covariance of the cameras' poses: of each turn about its own axes, rad, and position, m,
        with each other's.
    strayed : (n, n) array
        Covariance of what the light strays from where it is, seen across each ray, rad^2.

    """

    seen: Array
    noise: Array
    rotations: Array
    centres: Array
    directions: Array
    of_poses: Array
    strayed: Array

    @classmethod
    def of(
        cls, bearings: Sequence[Bearing], poses: Sequence[CameraPose], shared: Array | None,
        strayed: Array | None,
    ) -> Rays:
        """Return the rays of bearings, one of each camera; see `triangulate`."""
        count = len(poses)
        seen = MRAD * np.array([[each.azimuth, each.elevation] for each in bearings])
        rotations = np.array([pose.rotation for pose in poses])
        return cls(
            seen,
            MRAD**2 * np.array([each.covariance for each in bearings]),
            rotations,
            np.array([pose.position for pose in poses]),
            (rotations @ directions(seen)[..., None])[..., 0],
            _of_poses(poses) if shared is None
            else _of_poses(poses) + shared.reshape(count, 6, count, 6).transpose(0, 2, 1, 3),
            np.zeros((count, count)) if strayed is None else strayed,
        )

    def some(self, which: Sequence[int]) -> Rays:
        """Return those of some cameras."""
        chosen = list(which)
        return Rays(
            self.seen[chosen], self.noise[chosen], self.rotations[chosen], self.centres[chosen],
            self.directions[chosen], self.of_poses[np.ix_(chosen, chosen)],
            self.strayed[np.ix_(chosen, chosen)],
        )


def _of_poses(poses: Sequence[CameraPose]) -> Array:
    """Return the covariance of poses whose errors are independent."""
    covariance = np.zeros((len(poses), len(poses), 6, 6))
    for number, pose in enumerate(poses):
        variances = 3 * [pose.rotation_sigma**2] + 3 * [pose.position_sigma**2]
        np.fill_diagonal(covariance[number, number], variances)
    return covariance


def directions(angles: Array) -> Array:
    """Return the (..., 3) unit vectors of the optical frame in (..., 2) directions, rad."""
    azimuth, elevation = angles[..., 0], angles[..., 1]
    level = np.cos(elevation)
    return np.stack(
        [level * np.sin(azimuth), -np.sin(elevation), level * np.cos(azimuth)], axis=-1
    )


def tangents(angles: Array) -> Array:
    """Return the (..., 3, 2) derivatives of the directions by both angles."""
    azimuth, elevation = angles[..., 0], angles[..., 1]
    sine, cosine = np.sin(azimuth), np.cos(azimuth)
    level, height = np.cos(elevation), np.sin(elevation)
    across = np.stack([level * cosine, np.zeros_like(level), -level * sine], axis=-1)
    upward = np.stack([-height * sine, -level, -height * cosine], axis=-1)
    return np.stack([across, upward], axis=-1)


def angles_of(places: Array) -> Array:
    """Return azimuth and elevation of (n, 3) places in the optical frame, rad, (n, 2)."""
    x, y, z = places.T
    return np.stack([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))], axis=1)


def by_place_of(places: Array) -> Array:
    """Return the (n, 2, 3) derivatives of azimuth and elevation by (n, 3) places."""
    x, y, z = places.T
    level = np.hypot(x, z)
    square = level**2 + y**2
    return np.stack([
        np.stack([z / level**2, np.zeros_like(x), -x / level**2], axis=1),
        np.stack([x * y / level, -level, z * y / level], axis=1) / square[:, None],
    ], axis=1)


def nearest_point(rays: Rays) -> Array:
    """Return the point with the least squared distance from all rays."""
    across = np.eye(3) - rays.directions[:, :, None] * rays.directions[:, None, :]
    return np.asarray(np.linalg.solve(
        across.sum(axis=0), (across @ rays.centres[:, :, None]).sum(axis=0)[:, 0]
    ))


def linearised(position: Array, rays: Rays) -> tuple[Array, Array, Array, Array]:
    """
    Return what each camera sees of a position.

    Returns
    -------
    (2 n,) array, (2 n, 3) array, (2 n, 2 n) array, (2 n, 2 n) array
        Residuals, rad, their derivative J by the position, rad/m, less its sign, and the
        covariances of the angles by the errors of the poses and by what the light strays, rad^2.

    """
    to_local = np.swapaxes(rays.rotations, 1, 2)
    local = (to_local @ (position - rays.centres)[:, :, None])[:, :, 0]
    x, y, z = local.T
    none = np.zeros_like(x)
    by_local = by_place_of(local)
    by_place = by_local @ to_local
    # [p]x is the derivative of the local position by a turn of the camera.
    turned = by_local @ np.array([[none, -z, y], [z, none, -x], [-y, x, none]]).transpose(2, 0, 1)
    by_pose = np.concatenate([turned, -by_place], axis=2)
    residuals = rays.seen - angles_of(local)
    residuals[:, 0] -= TURN_RAD * np.round(residuals[:, 0] / TURN_RAD)
    errors = by_pose[:, None] @ rays.of_poses @ np.swapaxes(by_pose, 1, 2)
    # Over the distances: it is the same way in space that all see.
    across = by_place * np.linalg.norm(local, axis=1)[:, None, None]
    strayed = rays.strayed[:, :, None, None] * (across[:, None] @ np.swapaxes(across, 1, 2))
    size = 2 * len(x)
    return (
        residuals.ravel(), by_place.reshape(size, 3),
        errors.transpose(0, 2, 1, 3).reshape(size, size),
        strayed.transpose(0, 2, 1, 3).reshape(size, size),
    )

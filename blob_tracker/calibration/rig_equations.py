"""The equations of a rig: rays linearised by poses, clocks and the path, the path eliminated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from blob_tracker.calibration.light_path import LightPath, ORDER
from blob_tracker.calibration.path_equations import (
    add_band, Linear, restraint, times_restraint, windows_of,
)
from blob_tracker.calibration.rays import Rays
from blob_tracker.tracking.rays import angles_of, by_place_of
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

OF_CAMERA = 7  # turn about its own axes, position, clock
TIGHT = 1e-6  # of a length that is kept, over itself: nothing else is known as well
RIGID = 1e-4  # of a wand's length: what the spline of each end may err by


@dataclass(frozen=True)
class Measured:
    """
    All rays in a row.

    Parameters
    ----------
    camera, light : (n,) arrays
        Numbers.
    times : (n,) array
        Of each camera's clock, s.
    angles : (n, 2) array
        rad.
    roots : (n, 2, 2) array
        Make residuals independent with unit variance.

    """

    camera: NDArray[np.intp]
    light: NDArray[np.intp]
    times: Array
    angles: Array
    roots: Array

    @staticmethod
    def of(rays: Sequence[Sequence[Rays]]) -> Measured:
        """Return the rays of each camera to each light in a row."""
        parts = [
            (camera, light, each)
            for camera, of_camera in enumerate(rays) for light, each in enumerate(of_camera)
        ]
        covariance = np.concatenate([each.covariance for _, _, each in parts])
        return Measured(
            np.concatenate([np.full(len(each.times), camera) for camera, _, each in parts]),
            np.concatenate([np.full(len(each.times), light) for _, light, each in parts]),
            np.concatenate([each.times for _, _, each in parts]),
            np.concatenate([each.angles for _, _, each in parts]),
            np.linalg.inv(np.linalg.cholesky(covariance)),
        )


@dataclass(frozen=True)
class Unknown:
    """
    What is fitted.

    Parameters
    ----------
    rotations, positions, offsets : (c, 3, 3), (c, 3), (c,) arrays
        Of the cameras.
    coefficients : (k, l, 3) array
        Of the path of each light.
    extent : float
        Of the path, in the unit of the positions.

    """

    rotations: Array
    positions: Array
    offsets: Array
    coefficients: Array
    extent: float

    @staticmethod
    def through(
        path: LightPath, lights: Sequence[tuple[Array, Array]], rotations: Array,
        positions: Array, offsets: Array,
    ) -> Unknown:
        """Return the unknown with the paths nearest to places at instants of the first clock."""
        extent = float(np.mean([places.std(axis=0).max() for _, places in lights]))
        paths = []
        for times, places in lights:
            number, share = path.place(times)
            inside = number >= 0
            band = restraint(path, np.ones(1))
            right = np.zeros((path.size, 3))
            weights = 10.0 * path.weights(share[inside])
            add_band(band, number[inside, None] + np.arange(ORDER), weights)
            np.add.at(
                right, number[inside, None] + np.arange(ORDER),
                10.0 * weights[:, :, None] * places[inside, None, :],
            )
            paths.append(cho_solve_banded((cholesky_banded(band, lower=True), True), right))
        return Unknown(rotations, positions, offsets, np.stack(paths, axis=1), extent)

    def scaled(self, factor: float) -> Unknown:
        """Return it in another unit of length."""
        return replace(
            self, positions=factor * self.positions, extent=factor * self.extent,
            coefficients=factor * self.coefficients,
        )

    def moved(self, step: tuple[Array, Array]) -> Unknown:
        """Return it after a step of the cameras and of the path."""
        of_first = np.zeros(OF_CAMERA)
        of_cameras = np.concatenate([of_first, step[0]]).reshape(-1, OF_CAMERA)
        turns = Rotation.from_rotvec(of_cameras[:, :3]).as_matrix()
        return replace(
            self,
            rotations=self.rotations @ turns,
            positions=self.positions + of_cameras[:, 3:6],
            offsets=self.offsets + of_cameras[:, 6],
            coefficients=self.coefficients + step[1].reshape(self.coefficients.shape),
        )

    def rod_length(self) -> float:
        """Return the median distance of the two lights."""
        between = self.coefficients[:, 0] - self.coefficients[:, 1]
        return float(np.median(np.linalg.norm(between, axis=1)))

    def middles(self, path: LightPath) -> Array:
        """Return where the lights were at the middle of each interval, (m, 3)."""
        weights = path.weights(np.array([0.5]))[0]
        places = np.einsum('k,mkla->mla', weights, self.coefficients[windows_of(path)])
        return np.asarray(places.reshape(-1, 3))


@dataclass(frozen=True)
class Equations:
    """
    Chi-square of a rig and its derivatives.

    Parameters
    ----------
    measured : Measured
        The rays.
    path : LightPath
        The pieces of time that are fitted.
    pair : (int, int), optional
        Two cameras whose distance stays as it is: rays alone tell no scale.
    rod : float, optional
        Distance of the two lights, which tells it.
    restraint : float
        Standard deviation of the third differences of the path, over its extent.

    """

    measured: Measured
    path: LightPath
    pair: tuple[int, int] | None
    rod: float | None
    restraint: float

    def chi2_of_rays(self, unknown: Unknown) -> Array:
        """Return the chi-square of each ray, (n,); NaN outside the pieces."""
        residuals, _, _ = self._residuals(unknown)
        return np.asarray((residuals**2).sum(axis=1))

    def chi2(self, unknown: Unknown, weight: Array) -> float:
        """Return the chi-square of the rays, each with its weight, and of the wand."""
        total = float(np.nansum(weight * self.chi2_of_rays(unknown)))
        if self.rod is not None:
            total += float((self._rod_residuals(unknown)[0] ** 2).sum())
        return total

    def freedom(self, unknown: Unknown, weight: Array) -> int:
        """Return the degrees of freedom of that."""
        seen = int(np.isfinite(self.chi2_of_rays(unknown)[weight > 0.0]).sum())
        cameras = OF_CAMERA * (len(unknown.positions) - 1)
        known = 1 if self.rod is None else int(self.path.intervals.sum())
        return 2 * seen + known - cameras - unknown.coefficients.size

    def covariance(self, unknown: Unknown, weight: Array) -> Array:
        """Return the (7 c, 7 c) covariance of the cameras; the first one's is 0."""
        count = OF_CAMERA * len(unknown.positions)
        covariance = np.zeros((count, count))
        covariance[OF_CAMERA:, OF_CAMERA:] = self.linear(unknown, weight).covariance()
        return covariance

    def linear(self, unknown: Unknown, weight: Array) -> Linear:
        """Return the normal equations about a place, each ray with its weight of 0 to 1."""
        residuals, number, (by_place, by_camera, weights) = self._residuals(unknown, derive=True)
        used = (weight > 0.0) & (number >= 0)
        root = np.sqrt(weight[used])
        rest = root[:, None] * residuals[used]
        lights = unknown.coefficients.shape[1]
        count = OF_CAMERA * len(unknown.positions)
        size = unknown.coefficients.size
        band = restraint(
            self.path, np.full(3 * lights, 1.0 / (self.restraint * unknown.extent))
        )
        right_path = -times_restraint(
            self.path, unknown.coefficients, 1.0 / (self.restraint * unknown.extent)
        )
        # Of the path: (n, 2, 4, 3) derivatives by four coefficients of three components each.
        by_path = (root[:, None, None] * by_place[used])[:, :, None, :] * (
            weights[used][:, None, :, None]
        )
        columns = (
            ((number[used, None] + np.arange(ORDER)) * lights
             + self.measured.light[used, None])[:, :, None] * 3 + np.arange(3)
        ).reshape(len(by_path), 3 * ORDER)
        by_path = by_path.reshape(len(by_path), 2, 3 * ORDER)
        for row in range(2):
            add_band(band, columns, by_path[:, row])
        np.add.at(
            right_path, columns, np.einsum('nrk,nr->nk', by_path, rest)
        )
        cameras, both = np.zeros((count, count)), np.zeros((count, size))
        right_cameras = np.zeros(count)
        for camera in range(1, len(unknown.positions)):
            mine = self.measured.camera[used] == camera
            derivative = root[mine, None, None] * by_camera[used][mine]
            place = slice(OF_CAMERA * camera, OF_CAMERA * (camera + 1))
            cameras[place, place] = np.einsum('nri,nrj->ij', derivative, derivative)
            right_cameras[place] = np.einsum('nri,nr->i', derivative, rest[mine])
            crossed = np.einsum('nri,nrk->nki', derivative, by_path[mine])
            part = np.zeros((size, OF_CAMERA))
            np.add.at(part, columns[mine], crossed)
            both[place] = part.T
        if self.pair is not None:
            one, other = self.pair
            between = unknown.positions[one] - unknown.positions[other]
            length = float(np.linalg.norm(between))
            along = np.zeros(count)
            along[OF_CAMERA * one + 3:OF_CAMERA * one + 6] = between / length
            along[OF_CAMERA * other + 3:OF_CAMERA * other + 6] = -between / length
            cameras += np.outer(along, along) / (TIGHT * length) ** 2
        if self.rod is not None:
            off, derivative, rod_columns = self._rod_residuals(unknown)
            add_band(band, rod_columns, derivative)
            np.add.at(right_path, rod_columns, derivative * off[:, None])
        free = slice(OF_CAMERA, None)
        return Linear(
            cameras[free, free], both[free], band, right_cameras[free], right_path
        )

    def _residuals(
        self, unknown: Unknown, *, derive: bool = False
    ) -> tuple[Array, NDArray[np.intp], tuple[Array, Array, Array]]:
        """Return whitened residuals, the first coefficient of each, and the derivatives."""
        camera = self.measured.camera
        number, share = self.path.place(self.measured.times - unknown.offsets[camera])
        four = unknown.coefficients[
            np.maximum(number, 0)[:, None] + np.arange(ORDER), self.measured.light[:, None]
        ]
        weights = self.path.weights(share)
        places = np.einsum('nk,nka->na', weights, four)
        rotations = unknown.rotations[camera]
        seen = np.einsum('nba,nb->na', rotations, places - unknown.positions[camera])
        rest = self.measured.angles - angles_of(seen)
        rest[:, 0] = np.remainder(rest[:, 0] + np.pi, 2.0 * np.pi) - np.pi
        rest[number < 0] = np.nan
        roots = self.measured.roots
        residuals = np.einsum('nij,nj->ni', roots, rest)
        if not derive:
            return residuals, number, (weights, weights, weights)
        by_local = roots @ by_place_of(seen)
        by_place = np.einsum('nrb,nab->nra', by_local, rotations)
        x, y, z = seen.T
        none = np.zeros_like(x)
        crossed = np.stack([
            np.stack([none, -z, y], axis=1), np.stack([z, none, -x], axis=1),
            np.stack([-y, x, none], axis=1),
        ], axis=1)
        velocity = np.einsum('nk,nka->na', self.path.rates(share), four)
        by_camera = np.concatenate([
            by_local @ crossed, -by_place, -np.einsum('nra,na->nr', by_place, velocity)[..., None],
        ], axis=2)
        return residuals, number, (by_place, by_camera, weights)

    def _rod_residuals(self, unknown: Unknown) -> tuple[Array, Array, NDArray[np.intp]]:
        """Return residuals of the wand's length amid each interval, and their derivatives."""
        assert self.rod is not None
        windows = windows_of(self.path)
        weights = self.path.weights(np.array([0.5]))[0]
        ends = np.einsum('k,mkla->mla', weights, unknown.coefficients[windows])
        between = ends[:, 0] - ends[:, 1]
        length = np.linalg.norm(between, axis=1)
        sigma = RIGID * self.rod
        signs = np.array([1.0, -1.0])
        derivative = (
            weights[None, :, None, None] * signs[None, None, :, None]
            * (between / length[:, None])[:, None, None, :] / sigma
        )
        columns = (
            (windows[:, :, None] * 2 + np.arange(2))[..., None] * 3 + np.arange(3)
        )
        count = len(windows)
        return (
            (self.rod - length) / sigma, derivative.reshape(count, -1),
            columns.reshape(count, -1),
        )

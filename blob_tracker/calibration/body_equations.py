"""The equations of a body's lights: rays linearised by the places and the body's motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

from blob_tracker.calibration.light_path import LightPath, ORDER
from blob_tracker.calibration.path_equations import (
    add_band, Linear, restraint, THIRD_DIFFERENCE, windows_of,
)
from blob_tracker.calibration.rays import Rays
from blob_tracker.tracking.rays import angles_of, by_place_of
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

OF_POSE = 6  # turn about the body's own axes, position
CLOSE = 10.0  # weight of a pose that the path goes through, over that of its third differences


@dataclass(frozen=True)
class Measured:
    """
    All rays in a row, and the poses of the body that each has to do with.

    Parameters
    ----------
    light : (n,) array
        Numbers.
    angles : (n, 2) array
        Azimuth and elevation, rad.
    roots : (n, 2, 2) array
        Make residuals independent with unit variance.
    number : (n,) array
        The first of k poses that follow each other; -1 outside of the path.
    weights : (n, k) array
        Of these poses, a sum of 1.

    """

    light: NDArray[np.intp]
    angles: Array
    roots: Array
    number: NDArray[np.intp]
    weights: Array

    @staticmethod
    def along(rays: list[Rays], path: LightPath) -> Measured:
        """Return the rays of each light in a row along a path."""
        number, share = path.place(np.concatenate([each.times for each in rays]))
        return Measured(
            np.concatenate([np.full(len(each.times), light) for light, each in enumerate(rays)]),
            np.concatenate([each.angles for each in rays]),
            np.linalg.inv(np.linalg.cholesky(np.concatenate([each.covariance for each in rays]))),
            number, path.weights(share),
        )


@dataclass(frozen=True)
class Unknown:
    """
    What is fitted.

    Parameters
    ----------
    places : (l, 3) array
        Of the lights on the body.
    turns : (k, 4) array
        Unit quaternions (x, y, z, w) that take the body's axes to the optical ones.
    positions : (k, 3) array
        Of the body's origin in the optical frame.

    """

    places: Array
    turns: Array
    positions: Array

    @staticmethod
    def through(
        path: LightPath, places: Array, times: Array, turns: Array, positions: Array
    ) -> Unknown:
        """Return the unknown with the path nearest to poses at instants."""
        number, share = path.place(times)
        inside = number >= 0
        alike = turns[inside]
        steps = np.sign((alike[1:] * alike[:-1]).sum(axis=1))  # q and -q are one turn
        alike = alike * np.concatenate([[1.0], np.cumprod(steps)])[:, None]
        band = restraint(path, np.ones(1))
        columns = number[inside, None] + np.arange(ORDER)
        weights = CLOSE * path.weights(share[inside])
        add_band(band, columns, weights)
        right = np.zeros((path.size, 7))
        known = CLOSE * np.concatenate([alike, positions[inside]], axis=1)
        np.add.at(right, columns, weights[:, :, None] * known[:, None, :])
        found = cho_solve_banded((cholesky_banded(band, lower=True), True), right)
        size = np.linalg.norm(found[:, :4], axis=1, keepdims=True)
        return Unknown(places, found[:, :4] / size, found[:, 4:])

    def scaled(self, factor: float) -> Unknown:
        """Return it in another unit of length."""
        return replace(self, places=factor * self.places, positions=factor * self.positions)

    def moved(self, step: tuple[Array, Array]) -> Unknown:
        """Return it after a step of the places and of the path."""
        of_path = step[1].reshape(-1, OF_POSE)
        turns = Rotation.from_quat(self.turns) * Rotation.from_rotvec(of_path[:, :3])
        return Unknown(
            self.places + step[0].reshape(-1, 3),
            _alike(turns.as_quat(), self.turns), self.positions + of_path[:, 3:],
        )


@dataclass(frozen=True)
class Equations:
    """
    Chi-square of a body that moves, and its derivatives.

    Parameters
    ----------
    measured : Measured
        The rays.
    path : LightPath, optional
        Whose third differences are restrained; none where each pose is by itself.
    restraints : (2,) array
        Their standard deviations, of the turn, rad, and of the position.

    """

    measured: Measured
    path: LightPath | None
    restraints: Array

    def chi2_of_rays(self, unknown: Unknown) -> Array:
        """Return the chi-square of each ray, (n,); NaN outside of the path."""
        residuals, _ = self._residuals(unknown)
        return np.asarray((residuals**2).sum(axis=1))

    def chi2(self, unknown: Unknown, weight: Array) -> float:
        """Return that of all, each ray with its weight of 0 to 1."""
        return float(np.nansum(weight * self.chi2_of_rays(unknown)))

    def freedom(self, unknown: Unknown, weight: Array) -> int:
        """Return the degrees of freedom of that: neither place, turn nor size are among them."""
        used = int((weight > 0.0).sum())
        return 2 * used - OF_POSE * len(unknown.turns) - unknown.places.size + 7

    def linear(self, unknown: Unknown, weight: Array) -> Linear:
        """Return the normal equations about a place."""
        residuals, (by_light, by_pose) = self._residuals(unknown, derive=True)
        measured = self.measured
        used = (weight > 0.0) & (measured.number >= 0)
        root = np.sqrt(weight[used])[:, None]
        rest = root * residuals[used]
        by_light = root[:, :, None] * by_light[used]
        count, poses = 3 * len(unknown.places), by_pose.shape[2]
        by_path = (root[:, :, None, None] * by_pose[used]).reshape(len(rest), 2, poses * OF_POSE)
        columns = OF_POSE * measured.number[used, None] + np.arange(poses * OF_POSE)
        size = OF_POSE * len(unknown.turns)
        band = np.zeros((poses * OF_POSE, size))
        right_path = np.zeros(size)
        if self.path is not None:
            weights = np.repeat(1.0 / self.restraints, 3)
            band = restraint(self.path, weights)
            right_path = -_pull(self.path, unknown, weights)
        for row in range(2):
            add_band(band, columns, by_path[:, row])
        np.add.at(right_path, columns, np.einsum('nrk,nr->nk', by_path, rest))
        outer, both = np.zeros((count, count)), np.zeros((count, size))
        right_outer = np.zeros(count)
        for light in range(len(unknown.places)):
            mine = measured.light[used] == light
            place = slice(3 * light, 3 * light + 3)
            derivative = by_light[mine]
            outer[place, place] = np.einsum('nri,nrj->ij', derivative, derivative)
            right_outer[place] = np.einsum('nri,nr->i', derivative, rest[mine])
            part = np.zeros((size, 3))
            np.add.at(part, columns[mine], np.einsum('nri,nrk->nki', derivative, by_path[mine]))
            both[place] = part.T
        free = loose(unknown.places)
        outer += float(np.trace(outer)) / count * free @ free.T
        return Linear(outer, both, band, right_outer, right_path)

    def _residuals(
        self, unknown: Unknown, *, derive: bool = False
    ) -> tuple[Array, tuple[Array, Array]]:
        """Return whitened residuals, and their derivatives by the light and by the poses."""
        measured = self.measured
        weights = measured.weights
        poses = np.maximum(measured.number, 0)[:, None] + np.arange(weights.shape[1])
        turns = unknown.turns[poses]
        mean = np.einsum('nk,nkq->nq', weights, turns)
        size = np.linalg.norm(mean, axis=1)
        rotations = Rotation.from_quat(mean).as_matrix()
        places = unknown.places[measured.light]
        seen = np.einsum('nab,nb->na', rotations, places)
        seen += np.einsum('nk,nka->na', weights, unknown.positions[poses])
        rest = measured.angles - angles_of(seen)
        rest[:, 0] = np.remainder(rest[:, 0] + np.pi, 2.0 * np.pi) - np.pi
        rest[measured.number < 0] = np.nan
        residuals = np.einsum('nij,nj->ni', measured.roots, rest)
        if not derive:
            return residuals, (weights, weights)
        by_place = measured.roots @ by_place_of(seen)
        by_light = by_place @ rotations
        by_turn = -by_light @ _crossed(places)
        # q* q_i of each pose: what a turn of it about its own axes does to the mean.
        vectors, real = _relative(mean / size[:, None], turns)
        share = (weights / size[:, None])[:, :, None, None] * (
            real[..., None, None] * np.eye(3) + _crossed(vectors)
        )
        by_pose = np.concatenate([
            np.einsum('nra,nkab->nrkb', by_turn, share),
            by_place[:, :, None, :] * weights[:, None, :, None],
        ], axis=3)
        return residuals, (by_light, by_pose)


def loose(places: Array) -> Array:
    """
    Return what rays do not tell of places: where the body's own frame is, and its size.

    Parameters
    ----------
    places : (l, 3) array
        Of the lights.

    Returns
    -------
    (3 l, 7) array
        Orthonormal: three shifts, three turns about the middle, and the size.

    """
    beside = places - places.mean(axis=0)
    shifts = np.tile(np.eye(3), (len(places), 1))
    turns = -_crossed(beside).reshape(-1, 3)
    return np.asarray(np.linalg.qr(np.column_stack([shifts, turns, beside.ravel()]))[0])


def _pull(path: LightPath, unknown: Unknown, weights: Array) -> Array:
    """Return the gradient of the third differences' half chi-square, flat."""
    windows = windows_of(path)
    # About the second of four poses turns add up as vectors, nearly.
    middle = unknown.turns[windows[:, 1]]
    vectors, _ = _relative(middle, _alike(unknown.turns[windows], middle[:, None]))
    poses = np.concatenate([2.0 * vectors, unknown.positions[windows]], axis=2)
    bends = weights * np.einsum('k,mka->ma', THIRD_DIFFERENCE, poses)
    gradient = np.zeros((path.size, OF_POSE))
    np.add.at(
        gradient, windows, THIRD_DIFFERENCE[None, :, None] * (weights * bends)[:, None, :]
    )
    return gradient.ravel()


def _alike(turns: Array, other: Array) -> Array:
    """Return quaternions, or less them, whichever is nearer to others."""
    return np.where((turns * other).sum(axis=-1, keepdims=True) < 0.0, -turns, turns)


def _relative(one: Array, others: Array) -> tuple[Array, Array]:
    """Return vector and real part of one* others, for (n, 4) and (n, k, 4) quaternions."""
    vector, real = one[:, None, :3], one[:, None, 3:]
    its_vector, its_real = others[..., :3], others[..., 3:]
    return (
        real * its_vector - its_real * vector - np.cross(vector, its_vector),
        (real * its_real)[..., 0] + (vector * its_vector).sum(axis=-1),
    )


def _crossed(vectors: Array) -> Array:
    """Return the matrices [v]x that make the cross product of (..., 3) vectors."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    none = np.zeros_like(x)
    return np.stack([
        np.stack([none, -z, y], axis=-1), np.stack([z, none, -x], axis=-1),
        np.stack([-y, x, none], axis=-1),
    ], axis=-2)

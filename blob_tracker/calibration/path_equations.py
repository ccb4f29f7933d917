"""Least chi-square of rays along a path in time, which is eliminated, and without strays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

from blob_tracker.calibration.light_path import LightPath, ORDER
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

Array = NDArray[np.float64]

THIRD_DIFFERENCE = np.array([1.0, -3.0, 3.0, -1.0])
ITERATIONS = 20  # of a round
ROUNDS = 15  # of leaving out strays
LEAST_DAMPING, MOST_DAMPING = 1e-12, 1e9
MEDIAN_OF_TWO = 1.386  # of chi-square with two degrees of freedom
CONVERGED = 1e-4  # of chi-square: a step that gains less is the last
GATE = 25.0  # chi-square of a ray, 4 in a million if it is one of the light
EQUAL_GAIN = 1e-9  # of chi-square: less is rounding


class Unknown(Protocol):
    """What is fitted: of the path, and what is none."""

    def moved(self: U, step: tuple[Array, Array]) -> U:
        """Return it after a step of what is no path and one of the path."""


U = TypeVar('U', bound=Unknown)
U_contra = TypeVar('U_contra', bound=Unknown, contravariant=True)


class Equations(Protocol[U_contra]):
    """Chi-square of rays and its derivatives."""

    def chi2_of_rays(self, unknown: U_contra) -> Array:
        """Return the chi-square of each ray, (n,); NaN outside the pieces of the path."""

    def chi2(self, unknown: U_contra, weight: Array) -> float:
        """Return that of all, each ray with its weight of 0 to 1."""

    def linear(self, unknown: U_contra, weight: Array) -> Linear:
        """Return the normal equations about a place."""


class Tally(NamedTuple):
    """
    How the rays of several sources fit.

    Parameters
    ----------
    used, left_out : (n,) arrays
        How many rays of each source were used, and how many were left out.
    chi2 : (n,) array
        That of the rays that were used.

    """

    used: NDArray[np.intp]
    left_out: NDArray[np.intp]
    chi2: Array


def tally(source: NDArray[np.intp], of_rays: Array, weight: Array, count: int) -> Tally:
    """
    Return how the rays of each of `count` sources fit.

    Parameters
    ----------
    source : (m,) array
        Of each ray.
    of_rays : (m,) array
        Chi-square of each; NaN for one that counts for nothing.
    weight : (m,) array
        0 for those that were left out.
    count : int
        How many sources there are.

    """
    seen, kept = np.isfinite(of_rays), weight > 0.0
    used, left_out = (
        np.bincount(source[chosen & seen], minlength=count) for chosen in (kept, ~kept)
    )
    chosen = kept & seen
    chi2 = np.bincount(source[chosen], weights=of_rays[chosen], minlength=count)
    return Tally(used, left_out, np.asarray(chi2, float))


@dataclass(frozen=True)
class Linear:
    """Normal equations: of what is no path, of both, and of the path as a band, lower form."""

    outer: Array
    both: Array
    band: Array
    right_outer: Array
    right_path: Array

    def step(self, damping: float) -> tuple[Array, Array]:
        """Return the step of what is no path and that of the path, with damped diagonals."""
        band = self.band.copy()
        band[0] *= 1.0 + damping
        factor = (cholesky_banded(band, lower=True), True)
        by_path = cho_solve_banded(factor, np.column_stack([self.both.T, self.right_path]))
        reduced = self.outer - self.both @ by_path[:, :-1]
        reduced[np.diag_indices_from(reduced)] += damping * np.diag(self.outer)
        of_outer = np.linalg.solve(reduced, self.right_outer - self.both @ by_path[:, -1])
        of_path = by_path[:, -1] - by_path[:, :-1] @ of_outer
        return of_outer, of_path

    def covariance(self) -> Array:
        """Return the inverse of the information about what is no path, whatever that is."""
        factor = (cholesky_banded(self.band, lower=True), True)
        return np.linalg.inv(self.outer - self.both @ cho_solve_banded(factor, self.both.T))


def without_strays(equations: Equations[U], unknown: U) -> tuple[U, float, Array]:
    """
    Return the parameters of least chi-square, that, and the weights of the rays, 0 or 1.

    Rays beyond the gate weigh the less the further they are off, and are left out in the end,
    when the others have found their places: where a part of the path began wrong, its own rays
    are beyond the gate at first.
    """
    of_rays = equations.chi2_of_rays(unknown)
    near = np.zeros(len(of_rays), dtype=bool)
    for soft in (True, False):
        for _ in range(ROUNDS):
            scale = max(float(np.nanmedian(of_rays)) / MEDIAN_OF_TWO, 1.0)
            far = GATE * scale / np.fmax(of_rays, GATE * scale)
            weight = far if soft else (of_rays <= GATE).astype(float)
            unknown, chi2, done = adjusted(equations, unknown, weight)
            of_rays = equations.chi2_of_rays(unknown)
            before, near = near, of_rays <= GATE
            if done and (near == before).all():
                break
    return unknown, chi2, weight


def adjusted(
    equations: Equations[U], unknown: U, weight: Array
) -> tuple[U, float, bool]:
    """Return the parameters of least chi-square, that, and whether it is the least."""
    damping = 1e-3
    chi2 = equations.chi2(unknown, weight)
    for _ in range(ITERATIONS):
        system = equations.linear(unknown, weight)
        while True:
            moved = unknown.moved(system.step(damping))
            after = equations.chi2(moved, weight)
            if after < chi2 * (1.0 + EQUAL_GAIN):
                break
            damping *= 10.0
            if damping > MOST_DAMPING:
                return unknown, chi2, True
        gained, unknown, chi2 = chi2 - after, moved, min(after, chi2)
        damping = max(0.1 * damping, LEAST_DAMPING)
        if gained < CONVERGED:
            return unknown, chi2, True
    return unknown, chi2, False


def windows_of(path: LightPath) -> NDArray[np.intp]:
    """Return the four coefficients of each interval, (m, 4)."""
    before = np.concatenate([[0], np.cumsum(path.intervals + ORDER - 1)[:-1]])
    firsts = np.concatenate(
        [start + np.arange(count) for start, count in zip(before, path.intervals, strict=True)]
    )
    return firsts[:, None] + np.arange(ORDER)


def restraint(path: LightPath, weights: Array) -> Array:
    """
    Return the band of the third differences' information, a weight for each component.

    It is far too little to bend a path that is seen, and enough for the ends of a piece.
    """
    components = len(weights)
    band = np.zeros((ORDER * components, path.size * components))
    windows = windows_of(path)
    for part, weight in enumerate(weights.tolist()):
        add_band(
            band, windows * components + part,
            np.broadcast_to(weight * THIRD_DIFFERENCE, windows.shape),
        )
    return band


def times_restraint(path: LightPath, coefficients: Array, weight: float) -> Array:
    """Return the gradient of the third differences' half chi-square, flat."""
    difference = weight * THIRD_DIFFERENCE
    windows = windows_of(path)
    bends = np.einsum('k,mkla->mla', difference, coefficients[windows])
    gradient = np.zeros_like(coefficients)
    np.add.at(gradient, windows, difference[None, :, None, None] * bends[:, None])
    return gradient.ravel()


def add_band(band: Array, columns: NDArray[np.intp], rows: Array) -> None:
    """Add each row's outer product with itself to a matrix in lower banded form."""
    for one in range(columns.shape[1]):
        for other in range(one, columns.shape[1]):
            low = np.minimum(columns[:, one], columns[:, other])
            apart = np.abs(columns[:, other] - columns[:, one])
            np.add.at(band, (apart, low), rows[:, one] * rows[:, other])

"""Bearings of known motions, and what a consistent filter's errors and innovations keep to."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.simulation.platform_motion import Ride
from blob_tracker.tracking import Tracker
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

Array = NDArray[np.float64]
CONFIDENCE = 0.95


def nanoseconds(times: Array) -> list[int]:
    """Return stamps of times in s."""
    return [int(each) for each in np.rint(1e9 * times)]


def measured(times: Array, angles: Array, sigma: float, seed: int) -> list[Bearing]:
    """Return bearings of (n, 2) angles in mrad, with noise of sigma mrad on each."""
    noise = sigma * np.random.default_rng([seed, 77]).standard_normal(angles.shape)
    return [
        Bearing(azimuth, elevation, sigma**2 * np.eye(2), stamp)
        for (azimuth, elevation), stamp in zip((angles + noise).tolist(), nanoseconds(times))
    ]


def integrated(times: Array, order: int, noise: float, seed: int, first: float = 0.0) -> Array:
    """
    Return (n, 2, order) angles and derivatives, the last of them integrated white noise.

    Drawn with the exact covariance of each step, from the noise's integral alone.
    """
    random = np.random.default_rng([seed, 5])
    state = np.zeros((2, order))
    state[:, 1] = first * random.standard_normal(2)
    states = [state]
    for dt in np.diff(times):
        powers = np.array([dt**k / np.prod(np.arange(1, k + 1)) for k in range(order)])
        transition = np.zeros((order, order))
        for k in range(order):
            transition[k, k:] = powers[:order - k]
        # The integral of f f' with f the noise's way into each derivative: t^k / k!.
        degree = np.arange(order)[::-1]
        factorial = np.array([np.prod(np.arange(1, k + 1)) for k in degree])
        total = degree[:, None] + degree + 1
        added = noise**2 * dt**total / total / factorial[:, None] / factorial
        root = np.linalg.cholesky(added)
        state = state @ transition.T + random.standard_normal((2, order)) @ root.T
        states.append(state)
    return np.array(states)


def of_rays(rays: Array) -> Array:
    """Return (n, 2) azimuth and elevation of (n, 3) vectors in an optical frame, mrad."""
    across = np.hypot(rays[:, 0], rays[:, 2])
    return MRAD_PER_RAD * np.stack(
        [np.arctan2(rays[:, 0], rays[:, 2]), np.arctan2(-rays[:, 1], across)], axis=1
    )


def rays_of(angles: Array) -> Array:
    """Return (n, 3) unit vectors of (n, 2) azimuth and elevation, mrad."""
    azimuth, elevation = angles.T / MRAD_PER_RAD
    return np.stack([
        np.sin(azimuth) * np.cos(elevation), -np.sin(elevation),
        np.cos(azimuth) * np.cos(elevation),
    ], axis=1)


def seen_from(ride: Ride, times: Array, level: Array) -> Array:
    """Return (n, 2) angles on a vehicle of (n, 2) angles in the level frame, mrad."""
    return of_rays(np.einsum('nji,nj->ni', ride.rotations(times), rays_of(level)))


def followed(
    tracker: Tracker, bearings: Sequence[Bearing], truth: Array, skip: int = 10
) -> tuple[Array, Array]:
    """
    Return normalised innovations (n, 2), and the NEES (n,) of the angles, without the first.

    The first bearings tell of the prior, which is none of the motion's.
    """
    innovations, nees = [], []
    for index, bearing in enumerate(bearings):
        track = tracker.update(bearing)
        if index >= skip:
            assert tracker.innovation is not None
            innovations.append([tracker.innovation.first, tracker.innovation.second])
            error = track.state[:2] - truth[index]
            nees.append(error @ np.linalg.solve(track.angle_covariance, error))
    return np.array(innovations), np.array(nees)


def bounds(freedom: int) -> tuple[float, float]:
    """Return the 95 % bounds of a sum of so many squared standard normals."""
    low, high = chi2.interval(CONFIDENCE, freedom)
    return float(low), float(high)


def share_within(nees: Array, freedom: int) -> float:
    """
    Return the share of instants at which the mean NEES of the runs is within its 95 % bounds.

    Parameters
    ----------
    nees : (runs, n) array
        Of each run and instant.
    freedom : int
        Degrees of freedom of one.

    """
    low, high = bounds(freedom * len(nees))
    total = nees.sum(axis=0)
    return float(np.mean((low <= total) & (total <= high)))


def autocorrelation(innovations: Array, lags: int = 10) -> Array:
    """Return how normalised innovations, (runs, n, 2), go with those up to so many lags before."""
    power = np.mean(innovations**2)
    return np.array([
        np.mean(innovations[:, lag:] * innovations[:, :-lag]) / power
        for lag in range(1, lags + 1)
    ])


def portmanteau(innovations: Array, lags: int = 10) -> float:
    """
    Return Ljung and Box's sum over its 95 % bound: below 1 where the innovations are white.

    N (N + 2) sum r_k^2 / (N - k), chi-square with so many degrees of freedom as lags.
    """
    correlation = autocorrelation(innovations, lags)
    counts = np.array([innovations[:, lag:].size for lag in range(1, lags + 1)])
    # With the runs apart, r_k has the variance 1 / counts.
    return float(np.sum(counts * correlation**2) / chi2.ppf(CONFIDENCE, lags))

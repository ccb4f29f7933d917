"""The filter beside a batch solution that knows no recursion."""

from __future__ import annotations

from blob_tracker.tracking import MODELS, Tracker
from blob_tracker.tracking.hypothesis import FIRST_ACCELERATION_MRAD_S2, FIRST_RATE_MRAD_S
from blob_tracker.tracking.kalman import initiated, Measurement, predicted, Step, updated
from blob_tracker.tracking.models import fill_step
from blob_tracker.types import Bearing
import numpy as np
import pytest
import scipy

GAPS = (0.031, 0.002, 0.11, 0.033, 0.4, 0.017, 0.033, 0.025, 0.2, 0.033)  # s
SCALE = 1e-3  # mrad: of the noise; the path is thirty times as long


def step_of(size: int, dt: float, density: float) -> tuple[np.ndarray, np.ndarray]:
    """Return transition and process noise by Van Loan's matrix exponential."""
    drift = np.diag(np.ones(size - 2), 2)
    noise = np.zeros((size, size))
    noise[-2:, -2:] = density * np.eye(2)
    zero = np.zeros((size, size))
    both = scipy.linalg.expm(dt * np.block([[-drift, noise], [zero, drift.T]]))
    transition = both[size:, size:].T
    return transition, transition @ both[:size, size:]


@pytest.mark.parametrize('size', [4, 6])
@pytest.mark.parametrize('dt', [0.0, 0.001, 0.033, 2.0])
def test_steps_are_exact(size: int, dt: float) -> None:
    """For any interval; to the rounding of the exponential."""
    transition, noise = np.empty((size, size)), np.empty((size, size))
    fill_step(dt, 7.0, transition, noise)
    exact_transition, exact_noise = step_of(size, dt, 7.0)
    np.testing.assert_allclose(transition, exact_transition, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(noise, exact_noise, rtol=1e-9, atol=1e-15)


def most_likely(
    size: int, density: float, bearings: list[Bearing]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the last state and its covariance: least squares over all states at once."""
    count = len(bearings)
    rows, right = [], []

    def add(block: np.ndarray, place: int, value: np.ndarray, covariance: np.ndarray,
            second: np.ndarray | None = None) -> None:
        """Add equations of unit variance for one state, or it and the one after it."""
        whiten = np.linalg.inv(np.linalg.cholesky(covariance))
        row = np.zeros((len(block), count * size))
        row[:, place * size:(place + 1) * size] = block
        if second is not None:
            row[:, (place + 1) * size:(place + 2) * size] = second
        rows.append(whiten @ row)
        right.append(whiten @ value)

    prior = np.diag(([FIRST_RATE_MRAD_S] * 2 + [FIRST_ACCELERATION_MRAD_S2] * 2)[:size - 2])**2
    add(np.eye(size)[2:], 0, np.zeros(size - 2), prior)
    for index, bearing in enumerate(bearings):
        seen = np.array([bearing.azimuth, bearing.elevation])
        add(np.eye(size)[:2], index, seen, bearing.covariance)
        if index:
            dt = 1e-9 * (bearing.stamp_ns - bearings[index - 1].stamp_ns)
            transition, noise = step_of(size, dt, density)
            add(-transition, index - 1, np.zeros(size), noise, np.eye(size))
    matrix = np.concatenate(rows)
    # Columns of like size, and Householder's QR: the unknowns are apart by orders of magnitude.
    scale = np.linalg.norm(matrix, axis=0)
    q, r = np.linalg.qr(matrix / scale)
    solution = np.linalg.solve(r, q.T @ np.concatenate(right)) / scale
    root = np.linalg.inv(r) / scale[:, None]
    return solution[-size:], (root @ root.T)[-size:, -size:]


@pytest.mark.parametrize('model', list(MODELS))
def test_filter_is_the_most_likely_state(model: str) -> None:
    """
    Of all that is known, at each bearing, with irregular intervals and covariances that differ.

    The path is so short that the sphere is flat to the tolerance, a tenth of a thousandth of a
    standard deviation; and no shorter, for the first motion's deviation over the bearings' is
    what both have to carry through rounding.
    """
    random = np.random.default_rng(3)
    stamps = np.cumsum(np.rint(1e9 * np.array(GAPS))).astype(int)
    bearings = []
    for stamp in stamps:
        root = SCALE * random.uniform(0.3, 3.0) * np.array([[1.0, 0.0], [0.6, 0.5]])
        azimuth, elevation = 30.0 * SCALE * random.standard_normal(2)
        bearings.append(Bearing(azimuth, elevation, root @ root.T, int(stamp)))
    tracker = Tracker(model, acceleration=300.0 * SCALE, jerk=1000.0 * SCALE, gate_sigma=np.inf)
    density = (SCALE * {4: 300.0, 6: 1000.0}[MODELS[model].size])**2
    for count, bearing in enumerate(bearings, 1):
        track = tracker.update(bearing)
        state, covariance = most_likely(MODELS[model].size, density, bearings[:count])
        deviation = np.sqrt(np.diag(covariance))
        np.testing.assert_allclose((track.state - state) / deviation, 0.0, atol=1e-4)
        outer = np.outer(deviation, deviation)
        np.testing.assert_allclose(track.covariance / outer, covariance / outer, atol=1e-4)


@pytest.mark.parametrize('size', [4, 6])
def test_covariance_stays_symmetric_and_positive(size: int) -> None:
    """Over steps in which bearings are a million times better than what is predicted."""
    camera = np.eye(3)
    state = initiated(Measurement(0.0, 0.0, 1e-8, 0.0, 1e-8, camera), 1e4, 1e6, size)
    for index in range(2000):
        dt = 1e-4 if index % 7 else 0.5
        state = predicted(state, Step(dt, 1e6, camera, 0.0))
        measurement = Measurement(0.0, 0.0, 1e-8, 0.9e-8, 1e-8, camera)
        passed, state, _ = updated(state, measurement, np.inf)
        assert passed
        np.testing.assert_array_equal(state.covariance, state.covariance.T)
        scale = np.sqrt(np.diag(state.covariance))
        assert np.linalg.eigvalsh(state.covariance / np.outer(scale, scale)).min() > 0.0

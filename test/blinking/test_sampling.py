"""Samples have the mean and the spread of what they are drawn from."""

from __future__ import annotations

from blob_tracker.blinking.sampling import spread
import numpy as np
import pytest


def test_a_gaussian_with_a_correlation() -> None:
    """Of 8000 samples, some ten of which are as good as one, to a tenth of sigma."""
    covariance = np.array([[4.0, 0.9], [0.9, 0.25]])
    inverse = np.linalg.inv(covariance)

    def nats(some: np.ndarray) -> np.ndarray:
        away = some - [3.0, -1.0]
        return -0.5 * np.einsum('ki,ij,kj->k', away, inverse, away)

    samples = spread(nats, np.array([2.5, -1.1]), np.array([0.1, 0.1]))
    np.testing.assert_allclose(samples.mean(axis=0), [3.0, -1.0], atol=0.1 * 2.0)
    np.testing.assert_allclose(np.cov(samples.T), covariance, rtol=0.2, atol=0.1)


def test_a_flat_top() -> None:
    """Of which a derivative tells nothing: sigma is a width over the root of 12."""
    samples = spread(
        lambda some: np.where((np.abs(some) < 1.0).all(axis=1), 0.0, -np.inf),
        np.zeros(1), np.array([0.05]),
    )
    assert samples.std() == pytest.approx(2.0 / np.sqrt(12.0), rel=0.1)

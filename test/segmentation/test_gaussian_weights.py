"""Weights by recurrence are those of the exponential."""

from __future__ import annotations

from blob_tracker.segmentation.gaussian_weights import fill_weights, VECTOR
import numpy as np
import pytest


@pytest.mark.parametrize('count, first, middle, sigma', [
    (8, 3, 6.3, 0.7), (14, 0, 6.9, 1.6), (65, 0, 31.2, 8.0), (1, 5, 5.4, 0.32), (0, 0, 3.0, 1.0),
])
def test_weights_are_gaussian_and_padded(
    count: int, first: int, middle: float, sigma: float
) -> None:
    """To 1e-12 of themselves; 0 beyond the window, up to whole vectors."""
    out = np.full((3, count + VECTOR), np.nan)
    padded, norm = fill_weights(out, count, first, middle, sigma)
    d = first + np.arange(count) - middle
    w = np.exp(-0.5 * (d / sigma) ** 2)
    assert padded % VECTOR == 0 and count <= padded < count + VECTOR
    np.testing.assert_allclose(out[:, :count], [w, w * d, w * d * d], rtol=1e-12, atol=0.0)
    assert not out[:, count:padded].any()
    assert norm == pytest.approx(float((w * w).sum()), rel=1e-12)

"""The values of a Gaussian are those of NumPy's exp."""

from __future__ import annotations

from blob_tracker.segmentation.gaussian_values import gaussian_values
import numpy as np


def test_values_are_those_of_exp() -> None:
    """To a few roundings near the middle, to 1e-13 where all but nothing is left."""
    distances2 = np.linspace(0.0, 1390.0, 40000).reshape(200, 200)
    values, true = gaussian_values(distances2), np.exp(-0.5 * distances2)
    assert values.shape == (200, 200)
    near = distances2 < 25.0
    np.testing.assert_allclose(values[near], true[near], rtol=4e-15)
    np.testing.assert_allclose(values, true, rtol=1e-13)


def test_what_is_far_has_no_value() -> None:
    """However far: there is no overflow."""
    one, *none = gaussian_values(np.array([[0.0, 1e4, 1e12, np.inf]]))[0]
    assert one == 1.0
    assert 0.0 <= max(none) < 1e-300

"""The thesis' tables for the noise-free cases, to the last digit printed."""

from blob_tracker.location import locate_batch
from blob_tracker.location.centroid import centroid_1d
from blob_tracker.location.pulse import sampled_profile
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

GRID = np.arange(-0.5, 0.5, 0.02)  # 50 steps, half open


def pulses(size, s):
    """Return (2500, size, size) pulses of 255 DN, sampled, and their places along x."""
    middle = (size - 1) / 2
    profile = sampled_profile(size, middle + GRID, s / np.sqrt(2.0))[0]
    stack = 255.0 * profile[:, None, :, None] * profile[None, :, None, :]
    return stack.reshape(-1, size, size), middle + np.tile(GRID, GRID.size)


# Of each row: mean and largest error. One unit in the last place is the order of the sums.
@pytest.mark.parametrize(('size', 's', 'mean', 'largest'), [
    (5, 1, 0.001163, 0.002726),
    (5, 3, 0.155783, 0.311926),
    (7, 5, 0.179298, 0.358669),
    (9, 3, 0.045871, 0.092642),
    (15, 10, 0.169693, 0.339409),
    (25, 15, 0.154235, 0.308484),
])
def test_table_3_3(size, s, mean, largest):
    """Reproduce the centroid's spatial sampling errors."""
    stack, x = pulses(size, s)
    error = np.abs(centroid_1d(stack.sum(axis=1)) - x)
    np.testing.assert_allclose([error.mean(), error.max()], [mean, largest], atol=1.01e-6)


@pytest.mark.parametrize(('size', 's', 'mean', 'largest', 'snr'), [
    (5, 1, 0.002002, 0.008130, 234.13),
    (5, 3, 0.155814, 0.312500, 614.60),
    (15, 3, 0.002009, 0.007288, 230.29),
    (25, 15, 0.154231, 0.308663, 601.04),
])
def test_table_3_4(size, s, mean, largest, snr):
    """Reproduce the centroid's errors on rounded pulses."""
    stack, x = pulses(size, s)
    rounded = np.rint(stack)
    error = np.abs(centroid_1d(rounded.sum(axis=1)) - x)
    np.testing.assert_allclose([error.mean(), error.max()], [mean, largest], atol=1.01e-6)
    ratio = (rounded**2).sum(axis=(1, 2)) / ((rounded - stack) ** 2).sum(axis=(1, 2))
    assert np.sqrt(ratio).mean() == pytest.approx(snr, abs=0.0101)


@pytest.mark.parametrize(('size', 's', 'mean', 'largest'), [
    (5, 1, 0.0132, 0.0461),
    (5, 3, 0.0011, 0.0049),
    (7, 5, 0.0013, 0.0056),
    (9, 3, 0.0027, 0.0124),
    (15, 3, 0.0156, 0.0501),
    (15, 7, 0.0012, 0.0054),
    (25, 15, 0.0011, 0.0063),
])
def test_table_4_4(size, s, mean, largest):
    """Reproduce the circular log-linear fit's errors on rounded pulses."""
    stack, x = pulses(size, s)
    found = locate_batch(
        np.rint(stack), np.zeros_like(stack), method='gaussian_linear',
        noise=SensorNoise(gain=np.inf, read_noise=0.0),
    )
    assert found.ok.all()
    error = np.abs(found.x - x)
    np.testing.assert_allclose([error.mean(), error.max()], [mean, largest], atol=1.01e-4)

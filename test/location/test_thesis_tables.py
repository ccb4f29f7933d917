"""The thesis' tables for the noise-free cases, every row, to the last digit printed."""

from blob_tracker.location import locate_batch
from blob_tracker.location.centroid import centroid_1d
from blob_tracker.studies.printed import load
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

# The reading that gives the printed digits: 50 steps, half open, each added to the last; 255 DN,
# sampled about the window's middle; |error|; its variance with n - 1; the SNR
# of Table 3.4 from the unrounded pulse, that of Table 4.4 from the rounded one above zero.
GRID = np.cumsum([-0.5] + 49 * [0.02])

# Columns whose last digit is one off (0 mean, 1 variance, 2 largest, 3 SNR); why is not known.
# The thesis' Table 4.3 shows errors of single precision, large enough for all of these, but no
# order of single-precision sums, logarithms or solutions that was tried gives just these rows.
ONE_OFF_3_3 = {
    (5, 15): [2], (7, 3): [0], (9, 15): [2], (15, 1): [2], (15, 10): [2], (25, 1): [2],
    (25, 3): [2], (25, 7): [2],
}
ONE_OFF_3_4 = {(5, 15): [0], (9, 7): [0], (25, 1): [3]}
ONE_OFF_4_4 = {
    (5, 10): [2], (5, 15): [2], (7, 15): [2], (15, 10): [2], (15, 15): [2], (25, 7): [2],
    (25, 10): [2], (25, 15): [2],
}


def rows(name):
    """Return window, s, mean error, its variance, largest error and SNR as they are printed."""
    return [(int(row[0]), int(row[1]), *row[3:]) for row in load(name).rows]


def pulses(size, s):
    """Return (2500, size, size) pulses of 255 DN, sampled, and their places along x."""
    # From the middle, not from the first pixel: the sum would be rounded, and tip halves over.
    distance = np.arange(size) - (size - 1) / 2 - GRID[:, None]
    profile = np.exp(-((distance / s) ** 2))
    stack = 255.0 * profile[:, None, :, None] * profile[None, :, None, :]
    return stack.reshape(-1, size, size), (size - 1) / 2 + np.tile(GRID, GRID.size)


def printed(error, decimals, *ratio):
    """Return mean, variance and largest error as the thesis prints them, and a mean SNR."""
    columns = [error.mean(), error.var(ddof=1), error.max()]
    return [f'{value:.{decimals}f}' for value in columns] + [
        f'{np.sqrt(square).mean():.2f}' for square in ratio
    ]


def assert_printed(found, row, one_off):
    """Agree in every digit, or in all but the last of the columns named."""
    size, s, *expected = row
    differ = [k for k, (mine, theirs) in enumerate(zip(found, expected)) if mine != theirs]
    assert differ == one_off.get((size, s), []), (found, expected)
    for k in differ:
        unit = 10.0 ** -len(expected[k].partition('.')[2])
        assert float(found[k]) == pytest.approx(float(expected[k]), abs=1.01 * unit)


@pytest.mark.parametrize('row', rows('table_3_3'))
def test_table_3_3(row):
    """Reproduce the centroid's spatial sampling errors."""
    stack, x = pulses(*row[:2])
    error = np.abs(centroid_1d(stack.sum(axis=1)) - x)
    assert_printed(printed(error, 6), row, ONE_OFF_3_3)


@pytest.mark.parametrize('row', rows('table_3_4'))
def test_table_3_4(row):
    """Reproduce the centroid's errors on rounded pulses."""
    stack, x = pulses(*row[:2])
    rounded = np.rint(stack)
    error = np.abs(centroid_1d(rounded.sum(axis=1)) - x)
    ratio = (stack**2).sum(axis=(1, 2)) / ((rounded - stack) ** 2).sum(axis=(1, 2))
    assert_printed(printed(error, 6, ratio), row, ONE_OFF_3_4)


@pytest.mark.parametrize('row', rows('table_4_4'))
def test_table_4_4(row):
    """Reproduce the circular log-linear fit's errors on rounded pulses."""
    stack, x = pulses(*row[:2])
    rounded = np.rint(stack)
    found = locate_batch(
        rounded, np.zeros_like(stack), method='gaussian_linear',
        noise=SensorNoise(gain=np.inf, read_noise=0.0),
    )
    assert found.ok.all()
    left_out = np.where(rounded > 0.0, rounded - stack, 0.0)
    ratio = (rounded**2).sum(axis=(1, 2)) / (left_out**2).sum(axis=(1, 2))
    assert_printed(printed(np.abs(found.x - x), 4, ratio), row, ONE_OFF_4_4)

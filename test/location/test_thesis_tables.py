"""The thesis' tables for the noise-free cases, every row, to the last digit printed."""

from blob_tracker.location import locate_batch
from blob_tracker.location.centroid import centroid_1d
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

# The reading that gives the printed digits: 50 steps, half open, each added to the last; 255 DN,
# sampled about the window's middle; |error|; its variance with n - 1; the SNR
# of Table 3.4 from the unrounded pulse, that of Table 4.4 from the rounded one above zero.
GRID = np.cumsum([-0.5] + 49 * [0.02])

# Window, s, mean error, its variance, largest error (and the SNR).
TABLE_3_3 = [
    (5, 1, '0.001163', '0.000001', '0.002726'),
    (5, 3, '0.155783', '0.008134', '0.311926'),
    (5, 5, '0.212230', '0.015069', '0.424483'),
    (5, 7, '0.230174', '0.017724', '0.460351'),
    (5, 10, '0.240140', '0.019292', '0.480280'),
    (5, 15, '0.245583', '0.020176', '0.491167'),
    (7, 1, '0.000209', '0.000000', '0.000326'),
    (7, 3, '0.093916', '0.002970', '0.188595'),
    (7, 5, '0.179298', '0.010758', '0.358669'),
    (7, 7, '0.211646', '0.014986', '0.423303'),
    (7, 10, '0.230596', '0.017789', '0.461193'),
    (7, 15, '0.241229', '0.019467', '0.482459'),
    (9, 1, '0.000207', '0.000000', '0.000324'),
    (9, 3, '0.045871', '0.000715', '0.092642'),
    (9, 5, '0.142188', '0.006769', '0.284530'),
    (9, 7, '0.188871', '0.011935', '0.377770'),
    (9, 10, '0.218352', '0.015950', '0.436708'),
    (9, 15, '0.235521', '0.018557', '0.471043'),
    (15, 1, '0.000207', '0.000000', '0.000325'),
    (15, 3, '0.001304', '0.000001', '0.002724'),
    (15, 5, '0.046061', '0.000714', '0.092441'),
    (15, 7, '0.110298', '0.004073', '0.220712'),
    (15, 10, '0.169693', '0.009634', '0.339409'),
    (15, 15, '0.211174', '0.014918', '0.422350'),
    (25, 1, '0.000207', '0.000000', '0.000325'),
    (25, 3, '0.000000', '0.000000', '0.000001'),
    (25, 5, '0.001341', '0.000001', '0.002724'),
    (25, 7, '0.020949', '0.000148', '0.042029'),
    (25, 10, '0.080094', '0.002148', '0.160261'),
    (25, 15, '0.154235', '0.007959', '0.308484'),
]
TABLE_3_4 = [
    (5, 1, '0.002002', '0.000002', '0.008130', '234.13'),
    (5, 3, '0.155814', '0.008136', '0.312500', '614.60'),
    (5, 5, '0.212240', '0.015072', '0.425139', '767.24'),
    (5, 7, '0.230175', '0.017722', '0.460684', '825.07'),
    (5, 10, '0.240130', '0.019292', '0.481005', '857.97'),
    (5, 15, '0.245582', '0.020182', '0.491679', '877.34'),
    (7, 1, '0.002002', '0.000002', '0.008130', '227.27'),
    (7, 3, '0.093942', '0.002970', '0.189631', '469.71'),
    (7, 5, '0.179298', '0.010762', '0.359141', '668.66'),
    (7, 7, '0.211644', '0.014984', '0.424132', '761.44'),
    (7, 10, '0.230592', '0.017790', '0.461886', '820.70'),
    (7, 15, '0.241229', '0.019469', '0.482809', '856.87'),
    (9, 1, '0.002002', '0.000002', '0.008130', '227.27'),
    (9, 3, '0.045897', '0.000717', '0.093344', '369.98'),
    (9, 5, '0.142193', '0.006771', '0.285008', '573.80'),
    (9, 7, '0.188873', '0.011933', '0.378235', '693.39'),
    (9, 10, '0.218347', '0.015953', '0.437348', '780.44'),
    (9, 15, '0.235517', '0.018561', '0.471504', '836.23'),
    (15, 1, '0.002002', '0.000002', '0.008130', '227.27'),
    (15, 3, '0.002009', '0.000002', '0.007288', '230.29'),
    (15, 5, '0.046082', '0.000714', '0.093278', '368.52'),
    (15, 7, '0.110287', '0.004071', '0.221035', '500.71'),
    (15, 10, '0.169694', '0.009637', '0.339730', '640.32'),
    (15, 15, '0.211178', '0.014919', '0.422685', '756.94'),
    (25, 1, '0.002002', '0.000002', '0.008130', '227.28'),
    (25, 3, '0.002009', '0.000002', '0.007288', '223.62'),
    (25, 5, '0.001490', '0.000001', '0.006546', '229.91'),
    (25, 7, '0.021036', '0.000150', '0.042724', '310.20'),
    (25, 10, '0.080107', '0.002148', '0.160762', '437.58'),
    (25, 15, '0.154231', '0.007959', '0.308663', '601.04'),
]
TABLE_4_4 = [
    (5, 1, '0.0132', '0.0001', '0.0461', '254.09'),
    (5, 3, '0.0011', '0.0000', '0.0049', '614.61'),
    (5, 5, '0.0020', '0.0000', '0.0086', '767.25'),
    (5, 7, '0.0035', '0.0000', '0.0195', '825.08'),
    (5, 10, '0.0071', '0.0000', '0.0298', '857.98'),
    (5, 15, '0.0149', '0.0001', '0.0593', '877.36'),
    (7, 1, '0.0132', '0.0001', '0.0461', '254.09'),
    (7, 3, '0.0013', '0.0000', '0.0055', '469.71'),
    (7, 5, '0.0013', '0.0000', '0.0056', '668.67'),
    (7, 7, '0.0020', '0.0000', '0.0099', '761.45'),
    (7, 10, '0.0036', '0.0000', '0.0179', '820.71'),
    (7, 15, '0.0077', '0.0000', '0.0295', '856.88'),
    (9, 1, '0.0132', '0.0001', '0.0461', '254.09'),
    (9, 3, '0.0027', '0.0000', '0.0124', '369.98'),
    (9, 5, '0.0011', '0.0000', '0.0056', '573.81'),
    (9, 7, '0.0013', '0.0000', '0.0057', '693.40'),
    (9, 10, '0.0024', '0.0000', '0.0091', '780.45'),
    (9, 15, '0.0045', '0.0000', '0.0201', '836.23'),
    (15, 1, '0.0132', '0.0001', '0.0461', '254.09'),
    (15, 3, '0.0156', '0.0002', '0.0501', '248.81'),
    (15, 5, '0.0032', '0.0000', '0.0147', '368.53'),
    (15, 7, '0.0012', '0.0000', '0.0054', '500.72'),
    (15, 10, '0.0012', '0.0000', '0.0046', '640.33'),
    (15, 15, '0.0020', '0.0000', '0.0100', '756.94'),
    (25, 1, '0.0132', '0.0001', '0.0461', '254.09'),
    (25, 3, '0.0156', '0.0002', '0.0501', '248.81'),
    (25, 5, '0.0082', '0.0000', '0.0335', '248.34'),
    (25, 7, '0.0069', '0.0000', '0.0233', '310.32'),
    (25, 10, '0.0017', '0.0000', '0.0068', '437.58'),
    (25, 15, '0.0011', '0.0000', '0.0063', '601.04'),
]

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


@pytest.mark.parametrize('row', TABLE_3_3)
def test_table_3_3(row):
    """Reproduce the centroid's spatial sampling errors."""
    stack, x = pulses(*row[:2])
    error = np.abs(centroid_1d(stack.sum(axis=1)) - x)
    assert_printed(printed(error, 6), row, ONE_OFF_3_3)


@pytest.mark.parametrize('row', TABLE_3_4)
def test_table_3_4(row):
    """Reproduce the centroid's errors on rounded pulses."""
    stack, x = pulses(*row[:2])
    rounded = np.rint(stack)
    error = np.abs(centroid_1d(rounded.sum(axis=1)) - x)
    ratio = (stack**2).sum(axis=(1, 2)) / ((rounded - stack) ** 2).sum(axis=(1, 2))
    assert_printed(printed(error, 6, ratio), row, ONE_OFF_3_4)


@pytest.mark.parametrize('row', TABLE_4_4)
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

"""The line of variance over level: its scatter is its covariance, a bend grows it."""

from __future__ import annotations

from blob_tracker.calibration.noise_line import fit_noise_line, NoiseLine, QUANTISATION
from blob_tracker.location.noise import pixel_variance
import numpy as np
import pytest

LEVELS = np.array([0.0, 20.0, 50.0, 90.0, 150.0])
TRUE = 2.0 + 0.25 * LEVELS  # DN^2: gain 4 e-/DN
SCATTERS = np.full(5, 2.0 / 5000.0)  # Gaussian noise, 5,000 values each


def test_scatter_of_the_fits_is_their_covariance() -> None:
    """Over 2,000 draws, and on the mean."""
    random = np.random.default_rng(1)
    fits = [
        fit_noise_line(
            LEVELS, TRUE * (1 + np.sqrt(SCATTERS) * random.standard_normal(5)), SCATTERS
        )
        for _ in range(2000)
    ]
    found = np.array([(each.slope, each.foot) for each in fits])
    expected = fit_noise_line(LEVELS, TRUE, SCATTERS)
    # 2,000 draws tell a variance to 3.2 %; the 1 % of misfits that chance makes grow little.
    np.testing.assert_allclose(np.cov(found.T), expected.covariance, rtol=0.13)
    np.testing.assert_allclose(found.mean(axis=0), [0.25, 2.0], rtol=0.003)
    # And so for gain and read noise.
    noises = np.array([(each.gain, each.read_noise) for each in fits])
    np.testing.assert_allclose(np.cov(noises.T), expected.noise_covariance, rtol=0.13)


def test_a_point_beside_the_line_grows_the_sigmas() -> None:
    """By the root of chi-square per degree of freedom."""
    good = fit_noise_line(LEVELS, TRUE, SCATTERS)
    bent = fit_noise_line(LEVELS, TRUE * [1.0, 1.1, 1.1, 1.0, 1.0], SCATTERS)
    assert good.fits and not bent.fits
    assert bent.covariance[0, 0] > 0.5 * bent.chi2 / bent.dof * good.covariance[0, 0]


@pytest.mark.parametrize('black_level', [0.0, 5.0, 30.0, 240.0])
def test_its_noise_has_its_variance(black_level: float) -> None:
    """Whatever the black level: it is made up for by read noise while that lasts."""
    line = fit_noise_line(LEVELS + black_level, TRUE, SCATTERS)
    np.testing.assert_allclose(pixel_variance(LEVELS + black_level, line.noise), TRUE)
    # 2 DN^2 of dark variance are 1/4 DN^2 for each of 8 DN of black level.
    assert (line.noise.black_level == 0.0) == (black_level < 7.0)
    assert (line.noise.read_noise == 0.0) == (black_level > 7.0)


@pytest.mark.parametrize(('above', 'mean'), [(0.5, 1.06), (2.0, 0.9), (20.0, 1.0)])
def test_sigma_of_a_faint_read_noise(above: float, mean: float) -> None:
    """Where its square is `above` sigmas of the foot, the root of the foot is no straight line."""
    random = np.random.default_rng(2)
    squared = []
    for drawn in random.standard_normal(4000):
        foot = QUANTISATION + above + drawn
        line = NoiseLine(0.25, foot, np.diag([1e-6, 1.0]), 3.0, 3)
        squared.append((line.read_noise - np.sqrt(above)) ** 2 / line.noise_covariance[1, 1])
    # 4,000 draws of a chi-square tell its mean to 2.2 %; its tail is heavier here.
    assert np.mean(squared) == pytest.approx(mean, abs=0.1)


def test_no_read_noise_has_a_finite_sigma() -> None:
    """A foot below 1/12 is a read noise of 0, with a sigma."""
    line = fit_noise_line(LEVELS[1:], TRUE[1:] - 2.0, SCATTERS[1:])
    assert line.gain == pytest.approx(4.0)
    assert line.noise.read_noise == 0.0
    assert line.noise.black_level == pytest.approx(4.0 / 12.0)
    assert 0.0 < line.noise_covariance[1, 1] < 1.0


def test_one_level_is_no_line() -> None:
    """Said in a sentence."""
    with pytest.raises(ValueError, match='3 points at one level'):
        fit_noise_line(np.ones(3), np.ones(3), np.ones(3))

"""K as EMVA 1288 defines it: right, with a true sigma, and not at odds with the weighted line."""

from __future__ import annotations

from blob_tracker.calibration.frame_pair import Pair
from blob_tracker.calibration.photon_transfer import photon_transfer, PhotonTransfer
from blob_tracker.calibration.system_gain import system_gain
import numpy as np
import pytest

K, BLACK, DARK_VARIANCE = 1.0 / 3.6, 20.0, 9.1  # DN/e-, DN, DN^2
SATURATION = 4095
LEVELS = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.95)  # of full scale; the last is beyond 70 %
COUNT = 100_000  # px: a variance is known to 0.45 %
SEEDS = 200


def pairs_of(
    seed: int, bend: float = 0.0, darks: int = 4, scatter: float = 0.0, count: int = COUNT
) -> list[Pair]:
    """
    Return the statistics of pairs of a sensor, with the chance of `count` pixels.

    Its response loses a part, `bend`, of itself at full scale, e (1 - bend e), and its variance
    goes with the square of the slope of that. `scatter` is what each light is off by besides.
    """
    random = np.random.default_rng(seed)
    pairs = []
    for level in (*(0.0,) * darks, *LEVELS):
        above = (SATURATION - BLACK) * level * (1.0 - bend * level)
        shot = K * (SATURATION - BLACK) * level * (1.0 - 2.0 * bend * level) ** 2
        variance = DARK_VARIANCE + shot * (1.0 + scatter * random.standard_normal())
        variance *= 1.0 + np.sqrt(2.0 / count) * random.standard_normal()
        mean = BLACK + above + np.sqrt(variance / 2.0 / count) * random.standard_normal()
        pairs.append(Pair(
            dark=level == 0.0, exposure=level, mean=mean, variance=variance, kurtosis=3.0,
            spatial_variance=0.5, correlation=0.0, at_highest=1e-5, at_zero=0.0, count=count,
            step=1, highest=min(round(mean + 4.5 * np.sqrt(variance)), SATURATION),
        ))
    return pairs


def found_of(pairs: list[Pair]) -> tuple[PhotonTransfer, float, float]:
    """Return the photon transfer, K and its sigma."""
    found = photon_transfer(pairs)
    assert found.system_gain is not None
    return found, *found.system_gain


def mean_square(values: list[float]) -> float:
    """Return the mean of the squares."""
    return float(np.mean(np.square(values)))


def test_a_linear_sensor() -> None:
    """K is 1 / gain within its sigma, which one dark pair for all levels is part of."""
    for darks in (1, 4):
        draws = [found_of(pairs_of(seed, darks=darks)) for seed in range(SEEDS)]
        errors = [(gain - K) / sigma for _, gain, sigma in draws]
        # The mean of 200 squares of a Gaussian lies within three of its sigmas of 1.
        assert abs(mean_square(errors) - 1.0) < 3.0 * np.sqrt(2.0 / SEEDS)
        for _, gain, _ in draws:
            assert gain == pytest.approx(K, rel=0.02)


@pytest.mark.parametrize('bend', [0.03, -0.03, 0.06])
def test_a_response_that_bends(bend: float) -> None:
    """The two slopes differ, and neither is told better than that."""
    draws = [found_of(pairs_of(seed, bend)) for seed in range(SEEDS)]
    e = np.array(LEVELS[:-1])
    mean, shot = e * (1.0 - bend * e), e * (1.0 - 2.0 * bend * e) ** 2
    expected = K * (mean @ shot) / (mean @ mean)
    slopes, apart = [], []
    for found, gain, sigma in draws:
        # Four sigma of chance.
        assert gain == pytest.approx(expected, rel=0.015)
        line_sigma = np.sqrt(found.line.covariance[0, 0])
        slopes.append((found.line.slope - K) / line_sigma)
        apart += [(found.line.slope - gain) / line_sigma, (found.line.slope - gain) / sigma]
    assert np.mean([not found.line.fits for found, _, _ in draws]) > 0.95
    # The standard's K lies at one sigma of the line's slope and the other way round.
    assert max(map(abs, apart)) < 2.0
    # What it is in the dark lies as far again to the other side.
    assert mean_square(slopes) < 2.5**2


@pytest.mark.parametrize('darks', [4, 40])
def test_dark_frames_that_agree_hide_no_bright_ones_that_do_not(darks: int) -> None:
    """Where each light is off by 3 %, the sigmas of both slopes are true."""
    draws = [found_of(pairs_of(seed, darks=darks, scatter=0.03)) for seed in range(SEEDS)]
    slopes = [(each.line.slope - K) / np.sqrt(each.line.covariance[0, 0]) for each, _, _ in draws]
    gains = [(gain - K) / sigma for _, gain, sigma in draws]
    # Sigmas from seven points scatter: of Student's t with 6 degrees of freedom it is 1.5.
    assert 0.5 < mean_square(slopes) < 2.0
    assert 0.5 < mean_square(gains) < 2.0


def test_what_it_needs() -> None:
    """Dark frames, and two levels below 70 % of saturation."""
    pairs = pairs_of(0)
    bright = [each for each in pairs if not each.dark]
    darks = [each for each in pairs if each.dark]
    assert system_gain(bright, []) is None
    assert system_gain(bright[-1:], darks) is None
    assert photon_transfer(bright).system_gain is None

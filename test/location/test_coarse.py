"""Wide windows are explained at a coarser pitch, and answered in the sensor's pixels."""

from __future__ import annotations

import math

from blob_tracker.location.coarse import coarse, fine, WIDEST
from blob_tracker.location.hypotheses import History, Motion, Pair
from blob_tracker.location.noise import pixel_variance
from blob_tracker.location.pair_model import one_pulse, to_fit
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
import pytest
from scipy.special import erfc
from support.lights import BACKGROUND, located, NOISE, PEAK

SIDE = 149  # px: three of them are one
LIMIT = 4095.0  # DN


def gaussian(x: float, y: float, sigma: float) -> np.ndarray:
    """Return the mean of a wide light, DN."""
    return BACKGROUND + PEAK * pixel_integrated_gaussian((SIDE, SIDE), x, y, sigma)


def test_a_coarse_pulse_is_the_fine_one() -> None:
    """Place, covariance, levels and width come back, of one and the same noise."""
    random = np.random.default_rng(3)
    x, y, sigma = 71.3, 76.2, 20.0
    lit = expose(gaussian(x, y, sigma), NOISE, random).astype(float)
    unlit = expose(np.full_like(lit, BACKGROUND), NOISE, random).astype(float)
    theta = np.array([x, y, PEAK, BACKGROUND, sigma])
    pair = Pair(lit, unlit, NOISE, LIMIT)
    summed, start = coarse(pair, theta)
    assert summed.pitch == 3 and summed.pixels.shape == (2, SIDE // 3, SIDE // 3)
    top, coarse_top = one_pulse(pair, theta), one_pulse(summed, start)
    assert top is not None and coarse_top is not None
    one, other = to_fit(pair, top), fine(to_fit(summed, coarse_top), summed.pitch)
    # The sums keep nearly all that the pixels say: two fits of the same noise differ by little.
    deviation = math.sqrt(one.covariance[0, 0])
    assert other.x == pytest.approx(one.x, abs=0.2 * deviation)
    assert other.y == pytest.approx(one.y, abs=0.2 * deviation)
    np.testing.assert_allclose(other.covariance, one.covariance, atol=0.02 * deviation**2)
    for name in ('amplitude', 'background', 'sigma', 'snr'):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=0.01), name
    assert other.chi2 == pytest.approx(1.0, abs=0.1)  # of 5000 sums: 0.02


def test_what_is_known_is_told_in_the_pitch() -> None:
    """Motion and place shrink with the pixels, and the noise is that of a sum."""
    motion = Motion(np.array([6.0, -3.0]), 1.5, np.array([4.0, 1.0]))
    flat = np.full((SIDE, SIDE + 1), 50.0)
    summed, _ = coarse(Pair(flat, None, NOISE, LIMIT, History(motion)), None)
    assert summed.motion is not None and summed.motion.place is not None
    np.testing.assert_allclose(summed.motion.flash, (2.0, -1.0))
    assert summed.motion.deviation == pytest.approx(0.5)
    # The middle of the first sum is the second pixel.
    np.testing.assert_allclose(summed.motion.place, (1.0, 0.0))
    np.testing.assert_allclose(
        pixel_variance(9.0 * flat, summed.noise), 9.0 * pixel_variance(flat, NOISE)
    )


def test_one_clipped_pixel_clips_its_sum() -> None:
    """And no other one."""
    lit = np.full((SIDE, SIDE), 50.0)
    lit[7, 4] = LIMIT
    summed, _ = coarse(Pair(lit, lit, NOISE, LIMIT), None)
    for usable in summed.usable:
        assert np.argwhere(~usable).tolist() == [[2, 1]]


def test_a_window_of_usual_size_stays() -> None:
    """Up to WIDEST along its shorter side nothing is summed."""
    pair = Pair(np.zeros((WIDEST, 400)), None, SensorNoise(1.0, 1.0), LIMIT)
    assert coarse(pair, None)[0] is pair


def test_a_wide_disc_is_told_in_pixels_of_the_sensor() -> None:
    """Its radius, and a place and a covariance that hold."""
    radius = 50.0

    def disc(shape: tuple[int, int], x: float, y: float) -> np.ndarray:
        rows, columns = np.indices(shape)
        return 0.5 * PEAK * erfc((np.hypot(columns - x, rows - y) - radius) / math.sqrt(2.0))

    result = located(disc, SIDE, 20)
    assert result.said('disc of radius 50') + result.said('ring of radius 50') > 0.9
    # A third above the bound of the pixels, 0.0033 px; of 40 errors it is known to 11 %.
    assert result.rms < 1.35 * 1.33 * 0.0033
    assert 0.9 < result.nees < 3.3

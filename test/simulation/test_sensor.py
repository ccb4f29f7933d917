"""Noise of the stated variance, pixels that differ, full wells, full scale, the same bits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from blob_tracker.simulation import expose, Sensor
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SILENT = SensorNoise(gain=np.inf, read_noise=0.0)
DEEP = Sensor(SensorNoise(gain=5.0, read_noise=2.0, black_level=50.0), bits=12)
SHAPE = (250, 400)


def frames(sensor: Sensor, level: float, count: int = 2) -> np.ndarray:
    """Return frames of an even light."""
    random = np.random.default_rng(2)
    mean = np.full(SHAPE, sensor.noise.black_level + level, dtype=np.float32)
    return np.array([sensor.expose(mean, random) for _ in range(count)], dtype=float)


@pytest.mark.parametrize('mean', [20.0, 150.0])
def test_variance_is_that_of_the_noise_model(mean: float) -> None:
    """It is m / gain + read_noise^2 + 1/12, within 4 sigma of the sampling error of 1e5 pixels."""
    noise = SensorNoise(gain=10.0, read_noise=1.5)
    pixels = expose(np.full((250, 400), mean), noise, np.random.default_rng(2)).astype(float)
    expected = mean / noise.gain + noise.read_noise**2 + 1 / 12
    assert pixels.mean() == pytest.approx(mean, abs=4 * np.sqrt(expected / pixels.size))
    assert pixels.var() == pytest.approx(expected, rel=4 * np.sqrt(2 / pixels.size))


def test_full_scale_clips_and_sets_the_type() -> None:
    """8 bits up to 255, 16 above; nothing wraps."""
    noise = SensorNoise(gain=np.inf, read_noise=0.0)
    random = np.random.default_rng(0)
    mean = np.array([[-5.0, 12.4, 300.0, 5000.0]])
    assert expose(mean, noise, random).tolist() == [[0, 12, 255, 255]]
    deep = expose(mean, noise, random, saturation=4095)
    assert deep.dtype == np.uint16
    assert deep.tolist() == [[0, 12, 300, 4095]]


def test_a_sensor_of_the_defaults_is_the_plain_noise_bit_by_bit() -> None:
    """What is not asked for costs nothing and changes nothing."""
    mean = np.random.default_rng(1).uniform(0.0, 300.0, (60, 80))
    sensor = Sensor()
    expected = expose(mean, sensor.noise, np.random.default_rng(5))
    np.testing.assert_array_equal(sensor.expose(mean, np.random.default_rng(5)), expected)


@pytest.mark.parametrize('sensor', [DEEP, replace(DEEP, full_well=1e5, prnu=1e-9)],
                         ids=['noise in one draw', 'charge and read-out apart'])
def test_the_photon_transfer_curve_has_the_slope_of_the_gain(sensor: Sensor) -> None:
    """Variance over mean is 1 / gain, and the rest read noise and quantisation (EMVA 1288)."""
    levels = np.array([100.0, 500.0, 1000.0, 2000.0, 3000.0])
    variances = []
    for level in levels:
        first, second = frames(sensor, level)
        variances.append((first - second).var() / 2.0)
    slope, rest = np.polyfit(levels, variances, 1, w=1.0 / np.array(variances))
    # Each variance of 10^5 pixels is good to 0.45 %: the slope to 0.5 %, the rest to 0.3 DN^2.
    assert slope == pytest.approx(1.0 / 5.0, rel=0.02)
    assert rest == pytest.approx(4.0 + 1.0 / 12.0, abs=1.0)


def test_prnu_grows_with_the_signal_and_dsnu_does_not() -> None:
    """The scatter of the pixels' own means; both frames have the same pattern."""
    sensor = replace(DEEP, prnu=0.01, dsnu=3.0)
    for level in (0.0, 3000.0):
        first, second = frames(sensor, level)
        shared = np.mean((first - first.mean()) * (second - second.mean()))
        # 10^5 pixels tell a variance to 0.45 %, plus what is left of 700 DN^2 of temporal noise.
        assert shared == pytest.approx(9.0 + (0.01 * level) ** 2, rel=0.03)
    other = frames(replace(sensor, seed=2), 3000.0)[1]
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 4.0 / np.sqrt(first.size)


def test_a_full_well_clips_charge_and_its_noise_before_the_read_out() -> None:
    """Above it there is read noise alone."""
    pixels = frames(replace(DEEP, full_well=5.0 * 1000.0), 2000.0)[0]
    assert pixels.mean() == pytest.approx(1050.0, abs=4.0 * np.sqrt(4.1 / pixels.size))
    assert pixels.var() == pytest.approx(4.0 + 1 / 12, rel=4.0 * np.sqrt(2 / pixels.size))


def test_blooming_keeps_the_light_that_a_drain_loses() -> None:
    """A spot of 5 wells: the sum of the picture is that of the light, or less."""
    mean = np.zeros((60, 40), dtype=np.float32)
    mean[28:31, 18:21] = 5000.0
    well = Sensor(SensorNoise(gain=10.0, read_noise=0.0), bits=12, full_well=10_000.0)
    sums = {
        blooming: replace(well, blooming=blooming).expose(mean, np.random.default_rng(1)).sum()
        for blooming in (True, False)
    }
    # 45,000 DN with a shot noise of 67, then 100 pixels rounded.
    assert sums[True] == pytest.approx(45_000, abs=4.0 * 67.0)
    assert sums[False] == 9 * 1000


@pytest.mark.parametrize('gamma', [0.45, 1.0, 2.2])
def test_gamma_bends_between_0_and_full_scale(gamma: float) -> None:
    """Both ends stay; in between it is the power, to the rounding."""
    mean = np.linspace(0.0, 4095.0, 64).reshape(8, 8)
    found = Sensor(SILENT, bits=12, gamma=gamma).expose(mean, np.random.default_rng(1))
    expected = 4095.0 * (mean / 4095.0) ** gamma
    assert found.astype(float) == pytest.approx(expected, abs=0.502)


def test_stages_take_the_read_out_signal_in_their_order() -> None:
    """Whole frames of float32, noise and black level in them; gamma and clipping come after."""
    seen = []

    def halve(signal: np.ndarray) -> np.ndarray:
        seen.append(signal.copy())
        return 0.5 * signal

    def add(signal: np.ndarray) -> np.ndarray:
        signal += 7.0
        return signal

    sensor = replace(DEEP, stages=(halve, add))
    mean = np.full((40, 50), 5000.0)
    plain = DEEP.read_out(mean, np.random.default_rng(3))
    found = sensor.expose(mean, np.random.default_rng(3))
    assert seen[0].dtype == np.float32
    np.testing.assert_array_equal(seen[0], plain)
    assert plain.max() > 4095
    np.testing.assert_array_equal(found, np.rint(0.5 * plain + 7.0))


@pytest.mark.parametrize('wrong, words', [
    ({'bits': 17}, '17 bits; it must be 1 to 16'),
    ({'fill_factor': 1.1}, 'the fill factor is 1.1'),
    ({'row_time': -1.0}, 'row_time is -1.0 s'),
    ({'full_well': 0.0}, 'the full well is 0.0 e-'),
    ({'noise': SILENT, 'full_well': 1e4}, 'the gain must be finite'),
    ({'gamma': 0.0}, 'gamma is 0.0'),
])
def test_what_cannot_be_is_named(wrong: dict[str, Any], words: str) -> None:
    """With what would be right."""
    with pytest.raises(ValueError, match=words):
        Sensor(**wrong)

"""Lights through a shutter: each row has its own time, and the truth that of the light's row."""

from __future__ import annotations

from dataclasses import dataclass, replace

from blob_tracker.simulation import Comatic, Light, periodic, Scene, Sensor, ThreeGaussians
from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.spot import draw_light, Spot
from blob_tracker.simulation.waveforms import always, Waveform
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray
import pytest

ROW_TIME, RATE, SIGMA = 1e-4, 60.0, 4.0
ROLLING = Sensor(SensorNoise(np.inf, 0.0), bits=16, row_time=ROW_TIME)


@dataclass(frozen=True)
class Straight:
    """A light that goes straight on, px and px/s."""

    x: float
    y: float
    speed_x: float
    speed_y: float
    waveform: Waveform = always
    profile: Profile = Gaussian()

    def spot(self, time: float) -> Spot:
        """Return its image."""
        return Spot(self.x + self.speed_x * time, self.y + self.speed_y * time, SIGMA, 20_000.0)

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add it."""
        draw_light(self, picture, shot)


def scene_of(light: Straight | Light, sensor: Sensor = ROLLING, rate: float = RATE) -> Scene:
    """Return a dark scene of 160 x 120 px."""
    return Scene(
        light, width=160, height=120, rate=rate, exposure=0.1, background=0.0, texture=0.0,
        sensor=sensor,
    )


def centroid(image: np.ndarray) -> tuple[float, float]:
    """Return the centre of gravity, px."""
    rows, columns = np.indices(image.shape)
    total = image.sum(dtype=float)
    return (image * columns).sum() / total, (image * rows).sum() / total


def test_a_light_that_moves_across_is_skewed_by_velocity_times_row_time() -> None:
    """From one row to the next its middle moves by v t: 0.3 px here."""
    speed = 3000.0
    image = scene_of(Straight(80.0, 60.0, speed, 0.0)).frame(0).astype(float)
    rows = np.arange(52, 69)
    middles = (image[rows] * np.arange(160)).sum(axis=1) / image[rows].sum(axis=1)
    slope, _ = np.polyfit(rows, middles, 1)
    assert slope == pytest.approx(speed * ROW_TIME, rel=1e-3)


@pytest.mark.parametrize('y', [25.0, 60.0, 95.0])
@pytest.mark.parametrize('speed_x, speed_y', [(3000.0, 0.0), (-900.0, 300.0)])
def test_the_truth_is_the_place_at_the_time_of_its_row(
    y: float, speed_x: float, speed_y: float
) -> None:
    """Rows above the middle are earlier; the centre of gravity is the truth, skewed or not."""
    light = Straight(80.0, y, speed_x, speed_y)
    scene = scene_of(light)
    truth = scene.truth(0)
    assert truth.x - light.x == pytest.approx(speed_x * ROW_TIME * (truth.y - 59.5), abs=1e-5)
    # Down the picture it moves at 0.03 of the shutter's speed: drawn out, not displaced, but for
    # the light of the rows far from it, 0.03^2 sigma.
    assert centroid(scene.frame(0)) == pytest.approx((truth.x, truth.y), abs=0.01)


def test_at_rest_a_rolling_shutter_sees_what_a_global_one_does() -> None:
    """To the bit."""
    light = Light(80.3, 40.6, 3.0, 9000.0, profile=Comatic(1.0, 0.4))
    np.testing.assert_array_equal(
        scene_of(light).frame(1), scene_of(light, replace(ROLLING, row_time=0.0)).frame(1)
    )


def test_a_flash_that_begins_within_the_read_out_is_cut() -> None:
    """It lights at the time 0 of the middle row: those above are dark, those below are lit."""
    light = Straight(80.0, 59.5, 0.0, 0.0, periodic(5.0, 0.5))
    scene = scene_of(light, rate=80.0)
    image = scene.frame(0).astype(float)
    whole = scene_of(replace(light, waveform=always)).frame(0)
    # A row's own exposure is 1.25 ms, 12.5 rows long: between dark and lit it is in part.
    assert image[:52].max() == 0.0
    np.testing.assert_array_equal(image[67:], whole[67:])
    middle = 0.5 * (image[59, 80] / whole[59, 80] + image[60, 80] / whole[60, 80])
    assert middle == pytest.approx(0.5, abs=1.0 / 64)
    assert scene.truth(0).amplitude == pytest.approx(10_000.0, rel=0.02)


@pytest.mark.parametrize('profile', [Gaussian(2.0, 0.5), Comatic(1.2, 1.0), ThreeGaussians()])
def test_any_shape_stands_where_the_truth_says(profile: Profile) -> None:
    """The centre of gravity of the frame, rounded to 1 of 20,000 DN."""
    scene = scene_of(Light(80.3, 59.2, 1.5, 20_000.0, profile=profile))
    truth = scene.truth(0)
    assert centroid(scene.frame(0)) == pytest.approx((truth.x, truth.y), abs=2e-3)
    assert (truth.amplitude, truth.sigma) == (20_000.0, 1.5)


def test_the_fill_factor_of_the_sensor_is_seen() -> None:
    """A point-like pixel sees the full peak, a whole one its mean."""
    light = Light(80.0, 60.0, 1.0, 10_000.0)
    peaks = [
        int(scene_of(light, Sensor(ROLLING.noise, 16, fill_factor=part)).frame(0)[60, 80])
        for part in (1.0, 0.25, 0.0)
    ]
    # exp(-r^2 / 2) over a square of side a: 1 - a^2 / 12 + 7 a^4 / 1440.
    assert peaks == pytest.approx([9215, 9795, 10_000], abs=3)


def test_a_read_out_longer_than_a_frame_is_refused() -> None:
    """With both times."""
    with pytest.raises(ValueError, match='120 rows of 0.001 s take 0.12 s, longer than a frame'):
        scene_of(Light(80.0, 60.0, 1.0, 1.0), replace(ROLLING, row_time=1e-3))

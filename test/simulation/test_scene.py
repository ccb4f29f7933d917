"""Scenes: the same bits for the same seed, the truth true, noise of the sensor's variance."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.simulation import (
    Drifting, Glints, HotPixels, in_step, Light, PassingObject, Scene, Sensor, sinusoid, Stepping,
    SunDisc,
)
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SILENT = Sensor(SensorNoise(gain=np.inf, read_noise=0.0))
LIGHT = Light(60.2, 44.7, 3.0, 150.0, in_step(60.0), reach_x=20.0, reach_y=10.0)
EMPTY = Scene(width=120, height=90, texture=0.0)
QUIET = replace(EMPTY, target=LIGHT, background=0.0, sensor=SILENT)
FULL = replace(
    QUIET,
    elements=(
        PassingObject(10.0, 20.0, 20.0, 10.0, 90.0, 3.0),
        Light(90.0, 70.0, 2.0, 60.0, sinusoid(100.0, 0.7)),
        Glints(),
        SunDisc(100.0, 20.0, radius=5.0),
        HotPixels(),
    ),
    camera=Drifting(3.0, radius=20.0, turn=1.0),
    sensor=Sensor(row_time=2e-5, prnu=0.01, dsnu=0.3, full_well=9_000.0, blooming=True),
    texture=8.0,
)


def centroid(image: np.ndarray) -> tuple[float, float]:
    """Return the centre of gravity, px."""
    rows, columns = np.mgrid[:image.shape[0], :image.shape[1]]
    total = image.sum(dtype=float)
    return (image * columns).sum() / total, (image * rows).sum() / total


def test_same_seed_same_bits_in_any_order() -> None:
    """A frame depends on its index and the seeds alone, with everything in it."""
    backwards = {index: replace(FULL).frame(index) for index in (7, 4, 0)}
    for index, image in backwards.items():
        np.testing.assert_array_equal(FULL.frame(index), image)
    assert (replace(FULL, seed=2).frame(4) != FULL.frame(4)).any()


@pytest.mark.parametrize('camera', [
    None, Stepping(4.0, -3.0, turn=5.0), Drifting(5.0, radius=15.0, shake=1.0, turn=2.0),
])
def test_light_stands_where_the_truth_says(camera) -> None:
    """Without wall and noise the centre of gravity is the truth, from a moving camera too."""
    scene = replace(QUIET, camera=camera)
    for index in range(0, 40, 2):
        truth = scene.truth(index)
        assert truth.lit and not scene.truth(index + 1).lit
        # Rounding moves the sum of 200 pixels by less than 0.01 px.
        assert centroid(scene.frame(index)) == pytest.approx((truth.x, truth.y), abs=0.01)
        assert scene.frame(index + 1).max() == 0


def test_the_stamp_is_that_of_the_first_row() -> None:
    """The truth of a moving light is its place when its row is exposed: stamp + row x row_time."""
    light = Light(60.0, 45.0, 2.0, 200.0, reach_x=30.0, reach_y=30.0, period=0.5)
    row_time = 1e-4
    scene = replace(QUIET, target=light, sensor=replace(SILENT, row_time=row_time))
    for index in range(8):
        truth = scene.truth(index)
        spot = light.spot((scene.stamp_ns(index) - 10**9) / 1e9 + truth.y * row_time)
        assert (truth.x, truth.y) == pytest.approx((spot.x, spot.y), abs=0.01)


def test_wall_moves_by_whole_pixels_as_a_roll() -> None:
    """Three to the right and two up in the even frames, nothing interpolated."""
    scene = replace(EMPTY, texture=8.0, sensor=SILENT, camera=Stepping(3.0, -2.0))
    np.testing.assert_array_equal(scene.frame(2)[:-2, 3:], scene.frame(1)[2:, :-3])


def test_wall_moves_by_parts_of_a_pixel_without_a_trace() -> None:
    """Half a pixel there and back through a band-limited shift is what the camera saw at rest."""
    scene = replace(EMPTY, width=256, height=256, texture=8.0, sensor=replace(SILENT, bits=16))
    bright = replace(scene, background=4000.0, texture=800.0)
    still = bright.frame(0).astype(float)
    moved = replace(bright, camera=Stepping(0.5, 0.0)).frame(0).astype(float)
    shift = np.exp(2j * np.pi * np.fft.fftfreq(256) * 0.5)
    back = np.fft.ifft(np.fft.fft(moved * np.hanning(256), axis=1) * shift, axis=1).real
    want = still * np.interp(np.arange(256) + 0.5, np.arange(256), np.hanning(256))
    # Texture of 800 DN. Interpolated between whole pixels the finest of it, 1 px wide, would be
    # smoothed by 9 DN.
    assert np.std((back - want)[:, 20:-20]) < 3.0


def test_noise_is_that_of_the_sensor_and_new_in_every_frame() -> None:
    """It is m / gain + read_noise^2 + 1/12, and two frames have nothing in common."""
    scene = Scene(width=400, height=300, texture=0.0)
    frames = np.stack([scene.frame(index).astype(float) for index in range(12)])
    # The level goes from 0.75 to 1.25 of 40 DN along the rows; 12 frames tell it to 8 %, whose
    # mean over 120,000 pixels is good to 0.2 %.
    mean = frames.mean(axis=0)
    expected = (mean / 40.0 + 0.7**2 + 1.0 / 12.0).mean()
    assert frames.var(axis=0, ddof=1).mean() == pytest.approx(expected, rel=0.01)
    noise = (frames - mean).reshape(12, -1)
    correlation = np.corrcoef(noise) + np.eye(12) * -1.0
    # -1/11, because their own mean was taken off; 4 sigma of 120,000 pixels.
    assert np.abs(correlation + (1 - np.eye(12)) / 11.0).max() < 4.0 / np.sqrt(120_000)


def test_no_target_is_nowhere() -> None:
    """NaN, and not lit."""
    truth = EMPTY.truth(2)
    assert np.isnan([truth.x, truth.y]).all() and not truth.lit
    assert not replace(QUIET, target=replace(LIGHT, amplitude=0.0)).truth(2).lit


def test_sixteen_bits() -> None:
    """Above 255 DN of full scale."""
    assert replace(EMPTY, sensor=Sensor(bits=12)).frame(0).dtype == np.uint16

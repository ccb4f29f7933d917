"""A light in metres: its place through the lens, its size and brightness with the range."""

from __future__ import annotations

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.simulation import Optics, Scene, Sensor, SpatialLight
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

FOCAL = 800.0
PINHOLE = CameraModel(640, 480, pinhole_matrix(FOCAL, 640, 480))
LENS = CameraModel(640, 480, pinhole_matrix(FOCAL, 640, 480), np.array([-0.3, 0.1, 0.0, 0.0, 0.0]))


def test_place_is_that_of_the_camera_model() -> None:
    """Distortion and all."""
    place = (0.35, -0.2, 1.4)
    expected = LENS.project(np.array([place]))[0]
    assert Optics(LENS).spot(place, 0.02, 100.0)[:2] == pytest.approx(tuple(expected))


@pytest.mark.parametrize('distance', [0.5, 5.0, 50.0])
def test_size_is_blur_and_perspective(distance: float) -> None:
    """A disc of D has D f / 4 R, which adds to the blur as variances do."""
    spot = Optics(PINHOLE, blur=0.8).spot((0.0, 0.0, distance), 0.05, 100.0)
    own = 0.05 * FOCAL / (4.0 * distance)
    assert spot.sigma == pytest.approx(np.hypot(0.8, own), rel=1e-6)


def test_unresolved_light_falls_with_the_square_of_the_range() -> None:
    """All of its light always does; a near one keeps its peak."""
    optics = Optics(PINHOLE, blur=1.0)
    spots = [optics.spot((0.0, 0.0, distance), 0.05, 100.0) for distance in (100.0, 200.0)]
    # Own sigma of 0.1 px beside a blur of 1 px: the peak is 1 % short of the law.
    assert spots[0].amplitude / spots[1].amplitude == pytest.approx(4.0, rel=0.01)
    light = [spot.amplitude * spot.sigma**2 for spot in spots]
    assert light[0] / light[1] == pytest.approx(4.0, rel=1e-9)
    assert optics.spot((0.0, 0.0, 0.1), 0.05, 100.0).amplitude == pytest.approx(100.0, rel=1e-3)


def test_scale_at_the_border_is_that_of_the_lens() -> None:
    """Of a pinhole 1 / cos^3 of the angle in area; barrel distortion makes it smaller."""
    place = (0.6, 0.0, 0.8)  # cos of the angle is 0.8
    near, off = (
        Optics(PINHOLE, blur=1e-6).spot(each, 0.05, 100.0).sigma
        for each in ((0.0, 0.0, 1.0), place)
    )
    assert off / near == pytest.approx(0.8**-1.5, rel=1e-6)
    assert Optics(LENS, blur=1e-6).spot(place, 0.05, 100.0).sigma < off


def test_a_light_that_comes_near_grows_tenfold() -> None:
    """In the frames too: the light in the picture grows with the square of its size."""
    light = SpatialLight(
        Optics(PINHOLE, blur=0.01), lambda time: (0.02, 0.01, 10.0 - 9.0 * time), 0.1, 2000.0
    )
    scene = Scene(
        light, rate=1.0, background=0.0, texture=0.0,
        sensor=Sensor(SensorNoise(np.inf, 0.0), bits=16),
    )
    far, near = scene.truth(0), scene.truth(1)
    assert near.sigma / far.sigma == pytest.approx(10.0, rel=1e-3)
    sums = [scene.mean(index).sum(dtype=float) for index in (0, 1)]
    assert sums[1] / sums[0] == pytest.approx(100.0, rel=2e-3)
    rows, columns = np.indices((480, 640))
    image = scene.mean(1).astype(float)
    seen = (image * columns).sum() / sums[1], (image * rows).sum() / sums[1]
    assert seen == pytest.approx((near.x, near.y), abs=1e-3)


def test_a_light_behind_the_camera_is_not_seen() -> None:
    """Its truth is NaN and unlit, and nothing is in the picture."""
    light = SpatialLight(Optics(PINHOLE), lambda time: (0.0, 0.0, -1.0), 0.1, 100.0)
    scene = Scene(light, background=0.0, texture=0.0)
    truth = scene.truth(0)
    assert np.isnan([truth.x, truth.y]).all() and not truth.lit
    assert scene.mean(0).max() == 0.0

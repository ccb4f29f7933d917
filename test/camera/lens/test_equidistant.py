"""equidistant: OpenCV's numbers, an exact way back, and rays from behind the lens."""

from __future__ import annotations

import dataclasses

from blob_tracker.camera import LensError
from blob_tracker.camera.lens.equidistant import image, slopes
from hypothesis import given, settings, strategies
import numpy as np
import pytest
from support.camera_models import EQUIDISTANT, opencv_pixels, rays_at


def lens(*coefficients: float) -> np.ndarray:
    """Return how far from the axis, in focal lengths, rays at 0, 1 ... 179 degrees are imaged."""
    model = dataclasses.replace(
        EQUIDISTANT, matrix=np.eye(3), distortion=np.array(coefficients)
    )
    angles = np.radians(np.arange(180.0))
    return model.project(rays_at(angles, 0.0 * angles))[:, 0]


def test_pixels_are_those_of_opencv() -> None:
    """The same to rounding, up to 80 degrees from the axis."""
    azimuth, elevation = np.meshgrid(np.linspace(-1.4, 1.4, 15), np.linspace(-1.0, 1.0, 11))
    rays = 2.0 * rays_at(azimuth.ravel(), elevation.ravel())
    pixels = EQUIDISTANT.project(rays)
    np.testing.assert_allclose(pixels, opencv_pixels(EQUIDISTANT, rays), rtol=0, atol=1e-9)


def test_without_coefficients_the_angle_is_the_distance() -> None:
    """It is r = theta, past 90 degrees as before; four zeros are the same."""
    np.testing.assert_allclose(lens(), np.radians(np.arange(180.0)), rtol=1e-14)
    np.testing.assert_array_equal(lens(0.0, 0.0, 0.0, 0.0), lens())


def test_no_picture_beyond_the_fold() -> None:
    """With k1 = -1/12, r = theta - theta^3 / 12 turns back at theta = 2: 114.6 degrees."""
    distances = lens(-1.0 / 12.0, 0.0, 0.0, 0.0)
    assert np.isfinite(distances[:115]).all()
    assert np.isnan(distances[115:]).all()
    model = dataclasses.replace(EQUIDISTANT, distortion=np.array([-1.0 / 12.0, 0.0, 0.0, 0.0]))
    reach = 205.0 * 4.0 / 3.0  # at theta = 2
    assert model.angles(319.5 + reach - 1e-6, 239.5)[0] == pytest.approx(2000.0, abs=0.2)
    with pytest.raises(LensError, match='no ray leads to the pixel'):
        model.angles(319.5 + reach + 1e-6, 239.5)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    coefficients=strategies.tuples(
        *(strategies.floats(-limit, limit) for limit in (0.1, 0.05, 0.02, 0.005))
    ),
    focal_length=strategies.floats(150.0, 2000.0),
)
def test_way_back(coefficients: tuple[float, ...], focal_length: float) -> None:
    """Ray -> pixel -> ray -> pixel below 1e-9 px, wherever the lens sees."""
    model = dataclasses.replace(
        EQUIDISTANT,
        matrix=np.array([[focal_length, 0.4, 330.0], [0, 1.01 * focal_length, 225.0], [0, 0, 1]]),
        distortion=np.array(coefficients),
    )
    theta, phi = np.meshgrid(np.radians(np.linspace(0.0, 140.0, 15)), np.linspace(-3.1, 3.1, 7))
    directions = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    ).reshape(-1, 3)
    pixels = model.project(directions)
    seen = np.isfinite(pixels).all(axis=1)
    assert seen.sum() >= 7  # those on the axis
    for direction, pixel in zip(directions[seen], pixels[seen]):
        ray, _ = model.unproject(*pixel)
        assert np.abs(model.project(ray[None])[0] - pixel).max() < 1e-9
        # Where r hardly grows, a pixel's last digit is many of the ray's.
        assert np.abs(ray - direction).max() < 1e-6


@pytest.mark.parametrize('degrees', [-109.0, -91.0, -90.0, 90.0, 100.0, 109.0])
def test_azimuth_past_90_degrees(degrees: float) -> None:
    """A light beside and behind the camera has its own azimuth, not its mirror image's."""
    ray = rays_at(np.radians([degrees]), np.array([0.2]))
    azimuth, elevation, _ = EQUIDISTANT.angles(*EQUIDISTANT.project(ray)[0])
    assert azimuth == pytest.approx(1e3 * np.radians(degrees), abs=1e-9)
    assert elevation == pytest.approx(200.0, abs=1e-9)


def test_straight_up_has_no_azimuth() -> None:
    """At 90 degrees of elevation every azimuth is the same direction."""
    model = dataclasses.replace(EQUIDISTANT, matrix=np.eye(3), distortion=np.zeros(0))
    azimuth, elevation, _ = model.angles(0.0, -1.5)
    assert (azimuth, elevation) == (0.0, pytest.approx(1500.0))
    # cos(pi / 2) is 6e-17 in doubles: nearer to the zenith than any light.
    _, elevation, derivative = model.angles(0.0, -np.pi / 2)
    assert elevation == pytest.approx(500.0 * np.pi)
    assert abs(derivative[0, 0]) > 1e12  # mrad/px: the azimuth's covariance says that it is none


@pytest.mark.parametrize('k1', [0.1, 0.0, -0.05])
def test_the_rays_of_many_places_at_once(k1: float) -> None:
    """As `image` has them, up to the rim; what is behind the lens is all but aside."""
    matrix = np.array([[300.0, 0.0, 640.0], [0.0, 320.0, 480.0], [0.0, 0.0, 1.0]])
    coefficients = np.array([k1, 0.0, 0.0, 0.0])
    theta = np.radians([0.0, 20.0, 75.0, 80.0, 85.0, 89.0])
    rays = np.stack([0.6 * np.sin(theta), -0.8 * np.sin(theta), np.cos(theta)], axis=1)
    places = image(rays, tuple(coefficients)) * (300.0, 320.0) + (640.0, 480.0)
    assert slopes(places, matrix, coefficients) == pytest.approx(
        rays[:, :2] / rays[:, 2:], rel=1e-9, abs=1e-12
    )
    theta = np.radians(95.0)
    behind = image(np.array([[np.sin(theta), 0.0, np.cos(theta)]]), tuple(coefficients))
    assert slopes(behind * 300.0 + (640.0, 480.0), matrix, coefficients)[0, 0] > 1e5

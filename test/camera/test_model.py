"""Exact angles, a derivative that is one, and a covariance that follows it."""

from __future__ import annotations

import dataclasses
from math import atan2, hypot

from blob_tracker.camera import CalibrationError, CameraModel, LensError, pinhole_matrix
from blob_tracker.resources import config_path
from blob_tracker.types import Location
import numpy as np
import pytest
from support.camera_models import MODELS, PINHOLE, rays_at


def location(x: float, y: float, covariance: np.ndarray | None = None) -> Location:
    """Return a location at a pixel."""
    covariance = 0.01 * np.eye(2) if covariance is None else covariance
    return Location(x, y, covariance, 100.0, 20.0, 2.0, 50.0, 1.0, 0, stamp_ns=42)


def test_axis_and_signs() -> None:
    """On the axis both angles are 0; right is positive azimuth, up positive elevation."""
    axis = PINHOLE.bearing(location(319.5, 239.5))
    assert (axis.azimuth, axis.elevation, axis.stamp_ns) == (0.0, 0.0, 42)
    assert PINHOLE.bearing(location(400, 239.5)).azimuth > 0
    assert PINHOLE.bearing(location(319.5, 100)).elevation > 0


def test_pinhole_angles_are_exact() -> None:
    """Equal to the definition to rounding, far from the small-angle approximation."""
    x, y = (12.25 - 319.5) / 600, (470.75 - 239.5) / 600
    bearing = PINHOLE.bearing(location(12.25, 470.75))
    assert bearing.azimuth == pytest.approx(1e3 * atan2(x, 1), abs=1e-9)
    assert bearing.elevation == pytest.approx(1e3 * atan2(-y, hypot(x, 1)), abs=1e-9)


@pytest.mark.parametrize('name', MODELS)
def test_derivative_is_the_limit_of_differences(name: str) -> None:
    """The inverse of that of the way forward, taken by differences of the sixth order."""
    model = MODELS[name]
    # h^6 f^(7) / 140 and the rounding of a pixel over h are both below 1e-10 of the derivative.
    step = 2e-3  # rad
    weights = np.array([-1.0, 9.0, -45.0, 45.0, -9.0, 1.0]) / (60.0 * step)
    offsets = step * np.array([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0])
    for pixel in ((-0.5, -0.5), (30.0, 40.0), (320.0, 240.0), (601.5, 433.25), (639.5, 0.0)):
        azimuth, elevation, derivative = model.angles(*pixel)
        azimuth, elevation = 1e-3 * azimuth, 1e-3 * elevation
        still = np.zeros(6)
        by_azimuth = weights @ model.project(rays_at(azimuth + offsets, elevation + still))
        by_elevation = weights @ model.project(rays_at(azimuth + still, elevation + offsets))
        product = 1e-3 * derivative @ np.column_stack([by_azimuth, by_elevation])
        np.testing.assert_allclose(product, np.eye(2), rtol=0, atol=1e-9)


# A corner of each, where the distortion is strongest.
@pytest.mark.parametrize('name', MODELS)
def test_covariance_follows_the_derivative(name: str) -> None:
    """The scatter of bearings of scattered pixels is the covariance: NEES of 2 in the mean."""
    random = np.random.default_rng(11)
    covariance = np.array([[0.04, 0.01], [0.01, 0.02]])
    count = 4000
    model, corner = MODELS[name], (635.0, 3.0)
    centre = model.bearing(location(*corner, covariance))
    pixels = random.multivariate_normal(corner, covariance, count)
    angles = np.array([model.angles(*pixel)[:2] for pixel in pixels])
    errors = angles - [centre.azimuth, centre.elevation]
    nees = np.einsum('ni,ij,nj->n', errors, np.linalg.inv(centre.covariance), errors).mean()
    # chi-square of 2 n degrees of freedom over n: 95 % within 1.96 * 2 / sqrt(n).
    assert abs(nees - 2.0) < 1.96 * 2.0 / np.sqrt(count)


def test_corners_are_strongly_distorted() -> None:
    """So the corner of the test above is one: 20 px or more from where the ideal lens has it."""
    for name in ('plumb_bob', 'rational', 'prism', 'tilted', 'skewed', 'equidistant'):
        ideal = dataclasses.replace(MODELS[name], distortion=np.zeros(0), distortion_model='')
        ray, _ = MODELS[name].unproject(635.0, 3.0)
        moved = ideal.project(ray[None])[0] - [635.0, 3.0]
        assert not np.hypot(*moved) < 20.0, name  # NaN: the ideal lens cannot see it at all


def test_field_of_view_of_the_thesis() -> None:
    """6 mm lens on 6.41 mm of sensor: 56.22 degrees (Table 2.1) give a focal length of 600 px."""
    model = CameraModel.from_field_of_view(641, 489, 56.22)
    assert model.matrix[0, 0] == pytest.approx(600.0, rel=1e-4)  # the table's four digits
    edge = model.angles(-0.5, 244.0)[0]
    assert edge == pytest.approx(-1e3 * np.radians(56.22 / 2))


def test_pixels_of_an_analogue_camera_are_not_square() -> None:
    """Those of PAL are wider than high: a degree is more of them down than across."""
    model = CameraModel.from_field_of_view(720, 576, 40.0, 54 / 59)
    assert model.matrix[1, 1] / model.matrix[0, 0] == pytest.approx(59 / 54)
    assert model.angles(719.5, 287.5)[0] == pytest.approx(1e3 * np.radians(20.0))


@pytest.mark.parametrize(
    'change, sentence',
    [
        ({'width': 0}, 'must be positive'),
        ({'matrix': np.zeros((3, 3))}, 'focal lengths are 0 and 0'),
        ({'matrix': np.diag([-600.0, 600.0, 1.0])}, 'must be above 0'),
        ({'matrix': np.diag([np.nan, 600.0, 1.0])}, 'finite'),
        ({'matrix': np.eye(2)}, '3 x 3'),
        ({'matrix': 600.0 * np.eye(3)}, 'end in 1'),
        ({'matrix': np.tri(3)}, 'K must be 0 below its diagonal'),
        ({'rectification': np.eye(2)}, 'R must be 3 x 3'),
        ({'projection': np.full((3, 4), np.nan)}, 'P must be 3 x 4 finite'),
        ({'distortion_model': 'equidistant'}, '0 or 4 coefficients, not 5'),
        ({'distortion': np.full(5, np.nan)}, 'finite'),
        ({'distortion': np.zeros(3)}, 'coefficients, not 3'),
        (
            {'distortion_model': '', 'distortion': np.array([-0.1, 0.0, 0.0, 0.0, 0.0])},
            '^there are 5 distortion coefficients and no distortion model; name theirs: plumb_bob',
        ),
        ({'distortion_model': 'fancy'}, "no distortion model 'fancy'; there is plumb_bob"),
    ],
)
def test_impossible_calibration_is_refused(change: dict, sentence: str) -> None:
    """Each impossible value has its sentence."""
    with pytest.raises(CalibrationError, match=sentence):
        dataclasses.replace(PINHOLE, **change)


@pytest.mark.parametrize('count', [0, 4, 5, 8])
def test_zeros_of_no_model_are_no_distortion(count: int) -> None:
    """As some drivers fill them in."""
    model = dataclasses.replace(PINHOLE, distortion_model='', distortion=np.zeros(count))
    assert model.angles(100.0, 50.0)[:2] == PINHOLE.angles(100.0, 50.0)[:2]
    assert model.distortion.size == 0


@pytest.mark.parametrize('degrees', [0.0, -3.0, 180.0, float('nan')])
def test_impossible_field_of_view_is_refused(degrees: float) -> None:
    """A flat or folded lens has no focal length."""
    with pytest.raises(CalibrationError, match='field of view'):
        CameraModel.from_field_of_view(640, 480, degrees)


def test_pixel_without_a_ray_is_refused() -> None:
    """Where the distortion folds over, no angle is made up."""
    folded = dataclasses.replace(PINHOLE, distortion=np.array([-1.0, 0.0, 0.0, 0.0, 0.0]))
    # r (1 - r^2) turns back at r = 1 / sqrt(3), where it is 2 / (3 sqrt(3)).
    reach = 600.0 * 2.0 / 3.0**1.5
    for x in np.arange(0.0, 640.0, 8.0):
        for y in np.arange(0.0, 480.0, 8.0):
            offset = np.hypot(x - 319.5, y - 239.5)
            if offset > reach:
                with pytest.raises(LensError, match='no ray leads to the pixel'):
                    folded.angles(x, y)
            elif offset < 0.98 * reach:
                azimuth, elevation, _ = folded.angles(x, y)
                assert azimuth * (x - 319.5) > 0  # on the side on which it is seen
                assert elevation * (239.5 - y) > 0


def test_sample_calibration_is_read() -> None:
    """The file that is shipped is the simulated camera."""
    model = CameraModel.from_file(config_path('camera_info.yaml'))
    assert (model.width, model.height, model.name) == (640, 480, 'simulated')
    np.testing.assert_array_equal(model.matrix, PINHOLE.matrix)


@pytest.mark.parametrize('place, value', [
    ((0, 0), 1e300), ((1, 1), 5e-324), ((0, 2), 1e30), ((1, 2), -1e30), ((0, 1), 1e300),
])
def test_a_finite_matrix_of_no_lens_gives_no_bearing(
    place: tuple[int, int], value: float
) -> None:
    """Numbers that run over would be an angle of 0 or 90 degrees with no variance."""
    matrix = pinhole_matrix(600.0, 640, 480)
    matrix[place] = value
    with pytest.raises(LensError, match='out of all proportion'):
        CameraModel(640, 480, matrix).angles(300.0, 200.0)


@pytest.mark.parametrize('x, y', [(0.0, 0.0), (100.3, 400.8), (319.5, 239.5), (639.0, 10.0)])
@pytest.mark.parametrize('distortion, kind', [
    (np.array([-0.2, 0.05, 0.001, -0.002, 0.0]), 'plumb_bob'),
    (np.array([0.05, -0.01, 0.002, 0.0]), 'equidistant'),
])
def test_place_is_the_way_back_of_angles(
    x: float, y: float, distortion: np.ndarray, kind: str
) -> None:
    """To a millionth of a pixel, with the derivative of a small turn."""
    model = dataclasses.replace(PINHOLE, distortion=distortion, distortion_model=kind)
    azimuth, elevation, _ = model.angles(x, y)
    back_x, back_y, derivative = model.place(azimuth, elevation)
    assert (back_x, back_y) == pytest.approx((x, y), abs=1e-6)
    turned = [
        (np.array(model.place(azimuth + da, elevation + de)[:2])
         - model.place(azimuth - da, elevation - de)[:2]) / 2e-3
        for da, de in ((1e-3, 0.0), (0.0, 1e-3))
    ]
    np.testing.assert_allclose(derivative, np.transpose(turned), rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize('azimuth, elevation', [
    (2000.0, 0.0), (3141.0, 0.0), (0.0, 1600.0), (np.nan, 0.0), (0.0, np.inf),
])
def test_a_direction_without_a_picture_is_refused(azimuth: float, elevation: float) -> None:
    """Behind a pinhole camera, or none at all."""
    with pytest.raises(LensError, match='the lens has no picture|out of all proportion'):
        PINHOLE.place(azimuth, elevation)

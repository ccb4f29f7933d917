"""double_sphere, eucm and ocamcalib: their authors' equations, a way back."""

from __future__ import annotations

import dataclasses

from blob_tracker.camera import CameraModel, LensError
from blob_tracker.camera.lens import LENSES
from hypothesis import given, settings, strategies
import numpy as np
import pytest
from support.camera_models import DOUBLE_SPHERE, EUCM, OCAMCALIB, PINHOLE, rays_at

ALL = {'double_sphere': DOUBLE_SPHERE, 'eucm': EUCM, 'ocamcalib': OCAMCALIB}
AZIMUTH, ELEVATION = (
    each.ravel() for each in np.meshgrid(np.linspace(-1.7, 1.7, 15), np.linspace(-1.0, 1.0, 11)))
RAYS = 2.0 * rays_at(AZIMUTH, ELEVATION)


def matrix_of(model: CameraModel) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy."""
    return tuple(model.matrix[[0, 1, 0, 1], [0, 1, 2, 2]])


def test_double_sphere_is_that_of_its_authors() -> None:
    """Usenko et al., eq. 40 to 42."""
    (fx, fy, cx, cy), (xi, alpha) = matrix_of(DOUBLE_SPHERE), DOUBLE_SPHERE.distortion
    x, y, z = RAYS.T
    d1 = np.sqrt(x**2 + y**2 + z**2)
    d2 = np.sqrt(x**2 + y**2 + (xi * d1 + z)**2)
    below = alpha * d2 + (1 - alpha) * (xi * d1 + z)
    np.testing.assert_allclose(
        DOUBLE_SPHERE.project(RAYS), np.stack([fx * x / below + cx, fy * y / below + cy], 1))


def test_eucm_is_that_of_its_authors() -> None:
    """Khomutenko et al., eq. 5 and 6; with beta 1 it is Mei's, of which xi is known."""
    (fx, fy, cx, cy), (alpha, beta) = matrix_of(EUCM), EUCM.distortion
    x, y, z = RAYS.T
    below = alpha * np.sqrt(beta * (x**2 + y**2) + z**2) + (1 - alpha) * z
    np.testing.assert_allclose(
        EUCM.project(RAYS), np.stack([fx * x / below + cx, fy * y / below + cy], 1))
    xi = 0.8
    unified = dataclasses.replace(EUCM, distortion=np.array([xi / (1 + xi), 1.0])).project(RAYS)
    below = (z + xi * np.sqrt(x**2 + y**2 + z**2)) / (1 + xi)
    np.testing.assert_allclose(unified, np.stack([fx * x / below + cx, fy * y / below + cy], 1))


def test_ocamcalib_is_that_of_its_authors() -> None:
    """Its cam2world: of a row and a column, whose third axis looks back into the camera."""
    f, _, column_0, row_0 = matrix_of(OCAMCALIB)
    c, d, e, *powers = OCAMCALIB.distortion
    pol = [-f, *(-f * power / f**(i + 1) for i, power in enumerate(powers))]
    for row, column in ((0.0, 0.0), (240.0, 320.0), (400.0, 600.0), (30.5, 333.0)):
        invdet = 1 / (c - d * e)
        xp = invdet * ((row - row_0) - d * (column - column_0))
        yp = invdet * (-e * (row - row_0) + c * (column - column_0))
        zp = np.polyval(pol[::-1], np.hypot(xp, yp))
        expected = np.array([yp, xp, -zp]) / np.linalg.norm([xp, yp, zp])
        found = OCAMCALIB.unproject(column, row)[0]
        np.testing.assert_allclose(found / np.linalg.norm(found), expected, atol=1e-14)


@pytest.mark.parametrize('name', ALL)
def test_rays_behind_the_camera(name: str) -> None:
    """They are seen past 90 degrees; where no picture is, no ray leads back."""
    model = ALL[name]
    beside = model.project(rays_at(np.radians([0.0, 95.0, 179.95]), np.zeros(3)))
    assert beside[0] == pytest.approx(model.matrix[:2, 2])
    assert np.isfinite(beside[1]).all()
    assert np.isnan(beside[2]).all()
    assert model.angles(*beside[1])[0] == pytest.approx(1e3 * np.radians(95.0))
    far = dataclasses.replace(model, matrix=np.diag([1e-2, 1e-2, 1.0]))
    with pytest.raises(LensError, match='no ray leads to the pixel'):
        far.angles(639.0, 479.0)


@pytest.mark.parametrize('name', ALL)
def test_without_coefficients_it_is_a_pinhole(name: str) -> None:
    """As with every model."""
    model = dataclasses.replace(PINHOLE, distortion=np.zeros(0), distortion_model=name)
    rays = rays_at(np.linspace(-1.0, 1.0, 9), np.linspace(-0.5, 0.5, 9))
    np.testing.assert_allclose(model.project(rays), PINHOLE.project(rays), atol=1e-9)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    first=strategies.floats(-0.4, 0.9), second=strategies.floats(0.05, 0.95),
    focal_length=strategies.floats(150.0, 2000.0), name=strategies.sampled_from(sorted(ALL)),
)
def test_way_back(first: float, second: float, focal_length: float, name: str) -> None:
    """Ray -> pixel -> ray -> pixel below 1e-9 px, wherever the lens sees."""
    coefficients = {
        'double_sphere': [first, second], 'eucm': [second, 1.0 + first],
        'ocamcalib': [1.0 + 0.01 * first, 0.01 * second, -0.003, 0.0, -second, first, 0.1],
    }[name]
    model = dataclasses.replace(
        PINHOLE,
        matrix=np.array([[focal_length, 0.4, 330.0], [0, 1.01 * focal_length, 225.0], [0, 0, 1]]),
        distortion=np.array(coefficients), distortion_model=name,
    )
    theta, phi = np.meshgrid(np.radians(np.linspace(0.0, 85.0, 8)), np.linspace(-3.1, 3.1, 5))
    directions = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    ).reshape(-1, 3)
    pixels = model.project(directions)
    seen = np.isfinite(pixels).all(axis=1)
    assert seen.sum() >= 5  # those on the axis
    for direction, pixel in zip(directions[seen], pixels[seen]):
        ray, _ = model.unproject(*pixel)
        # A pixel so far out has fewer digits behind the point.
        assert np.abs(model.project(ray[None])[0] - pixel).max() < 1e-9 + 1e-12 * abs(pixel).max()
        assert np.abs(ray / np.linalg.norm(ray) - direction).max() < 1e-6


@pytest.mark.parametrize('name', ALL)
def test_many_places_at_once(name: str) -> None:
    """`slopes` gives what `ray` does."""
    model = ALL[name]
    places = np.array([[320.0, 240.0], [400.0, 100.0]])
    lens = LENSES[name]
    for place, found in zip(places, lens.slopes(places, model.matrix, model.distortion)):
        ray = model.unproject(*place)[0]
        np.testing.assert_allclose(found, ray[:2] / ray[2], atol=1e-12)

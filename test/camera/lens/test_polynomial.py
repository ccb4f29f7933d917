"""plumb_bob and rational_polynomial: OpenCV's numbers, and a way back that is exact."""

from __future__ import annotations

import dataclasses

from blob_tracker.camera import LensError
from blob_tracker.camera.lens import polynomial
from hypothesis import given, settings, strategies
import numpy as np
from numpy.typing import NDArray
import pytest
from support.camera_models import MODELS, opencv_pixels, PINHOLE

GRID = np.stack(np.meshgrid(np.linspace(-0.5, 639.5, 9), np.linspace(-0.5, 479.5, 9)), -1)
PIXELS = GRID.reshape(-1, 2)


def drawn(*limits: float) -> strategies.SearchStrategy[tuple[float, ...]]:
    """Return coefficients, each within plus and minus its limit."""
    return strategies.tuples(*(strategies.floats(-limit, limit) for limit in limits))


# As calibrations come out, from a long lens to a wide one: k1 k2 p1 p2 k3. A rational lens is
# nearly a plumb_bob one: what is in the denominator is in the numerator too, but for a part.
PLUMB_BOB = drawn(0.5, 0.4, 0.005, 0.005, 0.2)
RATIONAL = strategies.tuples(PLUMB_BOB, drawn(1.0, 0.5, 0.1)).map(
    lambda c: (c[0][0] + c[1][0], c[0][1] + c[1][1], c[0][2], c[0][3], c[0][4] + c[1][2], *c[1])
)
PRISM = strategies.tuples(RATIONAL, drawn(0.01, 0.01, 0.01, 0.01)).map(lambda c: c[0] + c[1])
TILTED = strategies.tuples(PRISM, drawn(0.1, 0.1)).map(lambda c: c[0] + c[1])


def test_the_ray_is_the_same_with_and_without_the_compiler(
    monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the last bit: it is a kernel with Python's own arithmetic."""
    polynomial.compile_lens()
    monkeypatch.setattr(polynomial, '_distorted_inside', polynomial._distorted)
    plain = getattr(polynomial._climbed, 'py_func', polynomial._climbed)
    random = np.random.default_rng(5)
    padded = (-0.3, 0.13, 1e-3, -1e-3, 0.02, 0.1, 0.01, 1e-3, 1e-3, 2e-3, 1e-3, -1e-3)
    for x, y in random.uniform(-0.8, 0.8, (200, 2)).tolist():
        for fold2 in (1.0, 0.3):
            told = x, y, 0.5 * x, 0.5 * y, fold2, padded
            assert polynomial._climbed(*told) == plain(*told)


@pytest.mark.parametrize('name', ['pinhole', 'plumb_bob', 'rational', 'prism', 'tilted'])
def test_pixels_are_those_of_opencv(name: str) -> None:
    """The same to rounding, all over a cone of 35 degrees about the axis."""
    x, y = np.meshgrid(np.linspace(-0.7, 0.7, 15), np.linspace(-0.7, 0.7, 15))
    rays = 3.0 * np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])
    pixels = MODELS[name].project(rays)
    np.testing.assert_allclose(pixels, opencv_pixels(MODELS[name], rays), rtol=0, atol=1e-10)


def check_way_back(
    coefficients: tuple[float, ...], focal_length: float, distortion_model: str
) -> None:
    """Go from rays to pixels and from these to rays, both ways, where a ray has a pixel."""
    model = dataclasses.replace(
        PINHOLE,
        matrix=np.array([[focal_length, 0, 330.0], [0, 1.01 * focal_length, 225.0], [0, 0, 1]]),
        distortion=np.array(coefficients),
        distortion_model=distortion_model,
    )
    # Rays that the lens without distortion would spread over the image and a fifth beyond.
    tangents = 1.2 * (PIXELS - [330.0, 225.0]) / focal_length
    rays = np.column_stack([tangents, np.ones(len(tangents))])
    pixels = model.project(rays)
    seen = np.isfinite(pixels).all(axis=1)
    assert np.isfinite(pixels[len(rays) // 2]).all()  # that in the middle
    # A ray of 0.5 % nearer to the axis than one that is seen: clear of the fold itself.
    rays = rays[seen] * [0.995, 0.995, 1.0]
    pixels = model.project(rays)
    inside = ((pixels > -0.5) & (pixels < [639.5, 479.5])).all(axis=1)
    for given_ray, pixel in zip(rays[inside], pixels[inside]):
        ray, _ = model.unproject(*pixel)
        back = model.project(ray[None])[0]
        assert np.abs(back - pixel).max() < 1e-9
        # The lens' own ray, not another onto the same pixel: near a fold many are close by.
        assert np.abs(ray - given_ray).max() < 1e-6


@settings(max_examples=150, deadline=None, derandomize=True)
@given(coefficients=PLUMB_BOB, focal_length=strategies.floats(300.0, 5000.0))
def test_way_back_of_plumb_bob(coefficients: tuple[float, ...], focal_length: float) -> None:
    """Below 1e-9 px for any realistic lens."""
    check_way_back(coefficients, focal_length, 'plumb_bob')


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    coefficients=strategies.one_of(RATIONAL, PRISM, TILTED),
    focal_length=strategies.floats(300.0, 5000.0),
)
def test_way_back_of_rational_polynomial(
    coefficients: tuple[float, ...], focal_length: float
) -> None:
    """Below 1e-9 px with 8, 12 and 14 coefficients."""
    check_way_back(coefficients, focal_length, 'rational_polynomial')


@pytest.mark.parametrize('name', MODELS)
def test_every_pixel_of_the_image_comes_back(name: str) -> None:
    """Pixel -> ray -> pixel below 1e-9 px, up to the image's outer edge."""
    model = MODELS[name]
    for pixel in PIXELS:
        ray, _ = model.unproject(*pixel)
        np.testing.assert_allclose(model.project(ray[None])[0], pixel, rtol=0, atol=1e-9)


def folded(distortion: list[float], distortion_model: str = 'plumb_bob') -> NDArray[np.float64]:
    """Return how far from the axis, px, the rays of a cone of 80 degrees are imaged."""
    model = dataclasses.replace(
        PINHOLE, distortion=np.array(distortion), distortion_model=distortion_model
    )
    tangents = np.tan(np.radians(np.linspace(0.0, 80.0, 801)))
    rays = np.column_stack([tangents, 0.0 * tangents, np.ones(801)])
    return model.project(rays)[:, 0] - 319.5


@pytest.mark.parametrize(
    'distortion, name, degrees',
    [
        # r (1 - r^2) turns back at r = 1 / sqrt(3).
        ([-1.0, 0.0, 0.0, 0.0, 0.0], 'plumb_bob', 30.0),
        # r (1 - r^2 + r^4 / 4) turns back where 1 - 3 t + 5 t^2 / 4 = 0: t = 0.4, r = sqrt(t).
        ([-1.0, 0.25, 0.0, 0.0, 0.0], 'plumb_bob', np.degrees(np.arctan(np.sqrt(0.4)))),
        # r / (1 - r^2) runs to infinity at r = 1 and comes back from the other side.
        ([0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0], 'rational_polynomial', 45.0),
    ],
)
def test_no_picture_beyond_the_fold(distortion: list[float], name: str, degrees: float) -> None:
    """It is NaN from where the picture turns back or runs away, and grows all the way to it."""
    offsets = folded(distortion, name)
    angles = np.linspace(0.0, 80.0, 801)
    assert np.isfinite(offsets[angles < degrees - 1e-6]).all()
    assert np.isnan(offsets[angles > degrees + 1e-6]).all()
    assert (np.diff(offsets[angles < degrees - 1e-6]) > 0.0).all()


def test_no_picture_of_what_is_behind() -> None:
    """Z of 0 and below."""
    rays = np.array([[0.1, 0.1, -1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.1, 0.1, 1.0]])
    for name in ('pinhole', 'plumb_bob', 'tilted'):
        seen = np.isfinite(MODELS[name].project(rays)).all(axis=1)
        assert seen.tolist() == [False, False, False, True]


@pytest.mark.parametrize('name', [name for name in MODELS if name != 'pinhole'])
@pytest.mark.parametrize('x', [np.nan, np.inf, -np.inf])
def test_a_pixel_that_is_no_number_has_no_ray(name: str, x: float) -> None:
    """And the search for it ends."""
    with pytest.raises(LensError, match='no ray leads to the pixel'):
        MODELS[name].unproject(x, 240.0)

"""A texture that moves behind the light is told from one that stands, and is in the covariance."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.location import locate
from blob_tracker.location.moving_texture import MovingTexture
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
BACKGROUND, PEAK, SIGMA, SIZE = 30.0, 100.0, 1.5, 15  # DN, DN, px, px
SCENE = 160  # px


def played(
    deviation: float, step: tuple[int, int], count: int = 300, seed: int = 5
) -> tuple[float, float, MovingTexture]:
    """Return the NEES without and with the texture's doubt, and what was measured."""
    random = np.random.default_rng(seed)
    grain = gaussian_filter(random.standard_normal((SCENE, SCENE)), 1.5, mode='wrap')
    scene = BACKGROUND + deviation * grain / grain.std()
    texture = MovingTexture()
    before: list[float] = []
    after: list[float] = []
    for index in range(count):
        x, y = SIZE // 2 + random.uniform(-1.0, 1.0, 2)
        light = PEAK * pixel_integrated_gaussian((SIZE, SIZE), x, y, SIGMA)
        unlit, lit = (
            np.roll(scene, np.multiply(2 * index + k, step), axis=(0, 1))[:SIZE, :SIZE]
            for k in range(2)
        )
        window = Window(
            expose(lit + light, NOISE, random, saturation=255),
            expose(unlit, NOISE, random, saturation=255), 0, 0, round(index * 1e9 / 30), 255,
        )
        location = locate(window, noise=NOISE)
        error = np.array([location.x - x, location.y - y])
        for squares, each in ((before, location), (after, texture.doubted(location))):
            squares.append(float(error @ np.linalg.solve(each.covariance, error)))
        texture.add(window, location, NOISE)
    return float(np.mean(before[60:])), float(np.mean(after[60:])), texture


@pytest.mark.parametrize('deviation, step', [
    (2.0, (1, 1)), (1.0, (0, 3)), (2.0, (5, 2)), (3.0, (5, 3)),
])
def test_what_moves_is_in_the_covariance(deviation: float, step: tuple[int, int]) -> None:
    """
    Of 240 errors the mean is known to 0.13, and the growth to a quarter.

    Of 2 DN or more each flash leaves a misfit as well, whose doubt is in the covariance besides.
    """
    before, after, texture = played(deviation, step)
    assert before > 3.0
    assert 1.1 < after < 2.8
    assert 'the texture behind the light moves' in texture.warning


@pytest.mark.parametrize('deviation, step', [(0.0, (1, 1)), (2.0, (0, 0)), (6.0, (0, 0))])
def test_what_stands_adds_nothing(deviation: float, step: tuple[int, int]) -> None:
    """Nor does a wall that has no texture."""
    for seed in range(3):
        _, _, texture = played(deviation, step, count=90, seed=seed)
        assert texture.growth == 1.0 and not texture.warning


def test_two_flashes_tell_sooner_that_it_moves() -> None:
    """Between their unlit frames there is twice the time: the NEES was 3.1, never grown."""
    _, after, texture = played(1.0, (1, 1), count=400, seed=3)
    assert texture.growth > 1.15
    assert after < 2.8


@pytest.mark.parametrize('away', [0.0, 1.5])
def test_a_light_that_is_in_the_unlit_frame_too_is_no_texture(away: float) -> None:
    """There, or where it was a frame before: its models know what that does."""
    random = np.random.default_rng(9)
    texture = MovingTexture()
    for index in range(60):
        x, y = SIZE // 2 + random.uniform(-1.0, 1.0, 2)
        angle = 0.1 * index
        light, rest = (
            height * pixel_integrated_gaussian(
                (SIZE, SIZE), x - shift * np.cos(angle), y - shift * np.sin(angle), SIGMA)
            for height, shift in ((PEAK, 0.0), (0.2 * PEAK, away))
        )
        window = Window(
            expose(BACKGROUND + light, NOISE, random, saturation=255),
            expose(BACKGROUND + rest, NOISE, random, saturation=255), 0, 0, index * 33, 255,
        )
        texture.add(window, replace(locate(window, noise=NOISE), x=x, y=y), NOISE)
        assert texture.growth == 1.0


def test_what_cannot_be_compared_is_left_aside() -> None:
    """A window without an unlit half, or of a decoded JPEG."""
    unlit = np.arange(225).reshape(15, 15) % 40
    lit = unlit + 10 + np.round(PEAK * pixel_integrated_gaussian((15, 15), 7.0, 7.0, 1.5))
    window = Window(lit.astype(np.uint8), unlit.astype(np.uint8), 0, 0, 0, 255)
    location = locate(window, noise=NOISE)
    texture = MovingTexture()
    for _ in range(40):
        texture.add(replace(window, unlit=None), location, NOISE)
        texture.add(replace(window, added_noise=3.0), location, NOISE)
    assert texture.growth == 1.0

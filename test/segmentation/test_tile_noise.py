"""Level and noise of each tile are right, and nothing that is on few of its rows moves them."""

from __future__ import annotations

from blob_tracker.segmentation.contrast import ROUNDING_DN
from blob_tracker.segmentation.tile_noise import median, tile_noise
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

SHAPE = (480, 640)


def frames(
    read_noise: float, shape: tuple[int, int] = SHAPE, saturation: int = 255, seed: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Return two frames of an even level with this noise."""
    random = np.random.default_rng(seed)
    noise = SensorNoise(gain=np.inf, read_noise=read_noise)
    level = np.full(shape, 0.3 * saturation)
    lit, unlit = (expose(level, noise, random, saturation=saturation) for _ in range(2))
    return lit, unlit


def tiles(
    lit: np.ndarray, unlit: np.ndarray, region: tuple[int, int, int, int] | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return levels, noises and brightness."""
    x0, y0, x1, y1 = region or (0, 0, lit.shape[1], lit.shape[0])
    return tile_noise(lit, unlit, x0, y0, x1, y1, ROUNDING_DN)


@pytest.mark.parametrize('read_noise, saturation', [(0.7, 255), (3.0, 255), (40.0, 65535)])
def test_noise_of_every_tile_is_right(read_noise: float, saturation: int) -> None:
    """Eight rows of 120 differences know it to 4 %, so that 20 tiles are within 12 %."""
    lit, unlit = frames(read_noise, saturation=saturation)
    levels, noises, brightness = tiles(lit, unlit)
    true = np.sqrt(2 * (read_noise**2 + 1 / 12))
    assert noises.shape == (4, 5)
    assert np.abs(noises / true - 1.0).max() < 0.12
    # The mean of 20 is known to 1 %; where it has few levels, as at 0.7 DN, it is 3 % too low.
    assert noises.mean() == pytest.approx(true, rel=0.04)
    # The median of eight means of 120 pixels.
    assert np.abs(levels).max() < 0.5 * true
    np.testing.assert_allclose(brightness, 0.3 * saturation, rtol=0.01)


@pytest.mark.parametrize('region', [
    (0, 0, 63, 63), (300, 200, 321, 219), (635, 475, 640, 480), (0, 100, 640, 105),
    (17, 3, 22, 400), (100, 100, 299, 257),
])
def test_small_and_odd_regions_have_a_noise(region: tuple[int, int, int, int]) -> None:
    """Regions of 25 px and more: the fewer pixels, the rougher."""
    lit, unlit = frames(3.0)
    _, noises, _ = tiles(lit, unlit, region)
    x0, y0, x1, y1 = region
    assert noises.shape == (max((y1 - y0 + 64) // 128, 1), max((x1 - x0 + 64) // 128, 1))
    true = np.sqrt(2 * (3.0**2 + 1 / 12))
    width = min(x1 - x0, 128)
    pairs = min(y1 - y0, 8) * (width - min(8, (x1 - x0) // 4))
    # The mean |difference| of n pairs is off by 0.76 / sqrt(n), the median of such means by a
    # quarter more; the pairs share pixels: three to four times that.
    assert np.abs(noises / true - 1.0).max() < 3.5 / np.sqrt(pairs)


def target(height: int, width: int) -> np.ndarray:
    """Return a target of 3 px."""
    return 150.0 * pixel_integrated_gaussian((height, width), 300.0, 200.0, 3.0)


def lamp(height: int, width: int) -> np.ndarray:
    """Return a lamp of 12 px that flickers."""
    return 100.0 * pixel_integrated_gaussian((height, width), 300.0, 200.0, 12.0)


def shade(height: int, width: int) -> np.ndarray:
    """Return the light of a target on all that is about it."""
    return 40.0 * pixel_integrated_gaussian((height, width), 300.0, 200.0, 120.0)


def edge(height: int, width: int) -> np.ndarray:
    """Return a bar that lit up, 40 rows high."""
    return 100.0 * (np.abs(np.arange(height) - 200.0) < 20)[:, None] * np.ones(width)


@pytest.mark.parametrize('light', [target, lamp, shade, edge])
def test_what_lights_up_leaves_the_noise(light) -> None:
    """To a sixth in each tile, of which 4 % are its own error."""
    lit, unlit = frames(1.5)
    _, before, _ = tiles(lit, unlit)
    brighter = np.clip(np.rint(lit + light(*SHAPE)), 0, 255).astype(np.uint8)
    _, after, _ = tiles(brighter, unlit)
    assert np.abs(after / before - 1.0).max() < 1 / 6


def test_noise_is_at_least_the_floor() -> None:
    """Equal frames have none of their own."""
    flat = np.full(SHAPE, 40, np.uint8)
    levels, noises, brightness = tiles(flat, flat)
    assert (noises == ROUNDING_DN).all() and (levels == 0.0).all() and (brightness == 40.0).all()


def test_a_change_of_the_whole_is_the_level() -> None:
    """With its sign."""
    lit, unlit = frames(1.0)
    levels, noises, _ = tiles(unlit - np.uint8(20), lit)
    assert np.abs(levels + 20.0).max() < 0.5
    assert noises.mean() == pytest.approx(1.47, rel=0.05)


@pytest.mark.parametrize('values, middle', [
    ([3.0], 3.0), ([5.0, 1.0], 3.0), ([9.0, 1.0, 2.0], 2.0), ([4.0, 1.0, 3.0, 2.0], 2.5),
])
def test_median(values: list[float], middle: float) -> None:
    """Of an even count it is the mean of the two in the middle; others are not looked at."""
    assert median(np.array([*values, -100.0]), len(values)) == middle

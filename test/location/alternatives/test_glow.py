"""A light on a glow of its own flash is placed as well as can be, with a true covariance."""

from __future__ import annotations

from blob_tracker.location import locate
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest
from support.lights import BACKGROUND, dragged, located, NOISE, PEAK, pulse, SIGMA

SIZE, COUNT = 13, 60


def light(
    shape: tuple[int, int], x: float, y: float,
    glow: float, width: float, aside: tuple[float, float],
) -> np.ndarray:
    """Return a pulse, and a glow so far aside."""
    return pulse(shape, x, y) + glow * pixel_integrated_gaussian(
        shape, x + aside[0], y + aside[1], width
    )


def bound(glow: float, width: float, aside: tuple[float, float]) -> float:
    """Return the bound of a pulse's place along an axis, its glow and background known, px."""
    middle = (SIZE - 1) / 2
    truth = np.array([middle, middle, PEAK, SIGMA])
    around = light((SIZE, SIZE), middle, middle, glow, width, aside)
    around = around - pulse((SIZE, SIZE), middle, middle) + BACKGROUND

    def mean(theta: np.ndarray) -> np.ndarray:
        x, y, peak, sigma = theta
        return around + peak * pixel_integrated_gaussian((SIZE, SIZE), x, y, sigma)

    variance = mean(truth) / NOISE.gain + NOISE.read_noise**2 + 1 / 12
    slopes = [(mean(truth + step) - mean(truth - step)) / 2e-4 for step in 1e-4 * np.eye(4)]
    fisher = np.array([[(a * b / variance).sum() for a in slopes] for b in slopes])
    return float(np.sqrt(np.linalg.inv(fisher)[0, 0]))


@pytest.mark.parametrize('glow, width, aside', [
    (10.0, 20.0, (20.0, 0.0)), (20.0, 20.0, (0.0, 20.0)), (40.0, 20.0, (-14.0, 14.0)),
    (40.0, 40.0, (30.0, 0.0)), (40.0, 20.0, (0.0, 0.0)), (30.0, 12.0, (12.0, 0.0)),
])
def test_the_slope_of_a_glow_does_not_move_the_place(
    glow: float, width: float, aside: tuple[float, float]
) -> None:
    """Without the model it is 0.04 to 0.4 px off."""
    result = located(lambda shape, x, y: light(shape, x, y, glow, width, aside), SIZE, COUNT)
    # Of 120 errors the rms is known to 6 %, the NEES to 0.26.
    assert result.rms < 1.3 * bound(glow, width, aside)
    assert 1.4 < result.nees < 2.8
    assert np.mean(result.found.chi2) == pytest.approx(1.0, abs=0.05)
    assert result.said('lights up haze or a wall') > 0.9


def test_a_light_without_a_glow_has_none() -> None:
    """Neither a round one, nor one with a tail."""
    assert located(pulse, SIZE, COUNT).said('haze') == 0.0
    way = np.array([3.2, 2.4])
    assert located(
        lambda shape, x, y: 0.7 * pulse(shape, x, y) + 0.3 * dragged(shape, x, y, way),
        SIZE, COUNT,
    ).said('haze') < 0.05


@pytest.mark.parametrize('change, word', [
    (0.7, 'darker in the lit frame'), (1.3, 'lamps on the mains do'),
])
def test_a_scene_of_another_brightness_in_the_two_frames(change: float, word: str) -> None:
    """By lamps on the mains, or auto-exposure: it is taken off, and named."""
    random = np.random.default_rng(7)
    noise, scene, squares, said = SensorNoise(10.0, 1.0), 40.0, [], []
    for _ in range(COUNT):
        wall = np.full((SIZE, SIZE), scene)
        x, y = (float(each) for each in 6.0 + random.uniform(-0.5, 0.5, 2))
        lit = change * wall + 120.0 * pixel_integrated_gaussian((SIZE, SIZE), x, y, 1.5)
        seen = [
            np.rint(mean + np.sqrt(mean / 10.0 + 1.0) * random.standard_normal(mean.shape))
            for mean in (lit, wall)
        ]
        found = locate(Window(seen[0], seen[1], saturation=255), noise=noise)
        error = np.array([found.x - x, found.y - y])
        squares.append(error @ np.linalg.solve(found.covariance, error))
        said.append(found.warning)
    # Of 60 squares the mean is known to 0.26.
    assert 1.2 < np.mean(squares) < 2.8
    assert np.mean([word in each for each in said]) > 0.9

"""Whether the unlit window holds a pulse, or a texture."""

from __future__ import annotations

import math

from blob_tracker.location.hypotheses import Pair
from blob_tracker.location.texture_field import log_likelihood_of_texture
from blob_tracker.location.unlit_pulse import shows_pulse
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

NOISE = SensorNoise(gain=40.0, read_noise=0.7)


def unlit_window(texture: float, pulse: float, seed: int) -> np.ndarray:
    """Return pixels with a texture whose lumps are as large as a pulse, DN."""
    random = np.random.default_rng(seed)
    mean = 40.0 + pulse * pixel_integrated_gaussian((15, 13), 6.3, 7.2, 2.0)
    for _ in range(30):
        x, y, height = random.uniform(0, 13), random.uniform(0, 15), random.normal(0, texture)
        mean += height * pixel_integrated_gaussian((15, 13), x, y, 2.0)
    return np.round(mean + random.normal(0.0, 1.2, mean.shape))


@pytest.mark.parametrize('pulse, texture, shown', [
    (30.0, 0.0, True), (200.0, 0.2, True), (0.0, 4.0, False), (0.0, 20.0, False),
    (30.0, 20.0, False),
])
def test_a_pulse_is_told_from_a_texture(pulse: float, texture: float, shown: bool) -> None:
    """In each of 20 windows: a pulse that stands out of the texture, and none where it is lost."""
    for seed in range(20):
        unlit = unlit_window(texture, pulse, seed)
        assert shows_pulse(Pair(unlit, unlit, NOISE, math.inf)) is shown


def test_the_likelihood_of_a_texture_is_that_of_its_covariance() -> None:
    """By the determinant and the inverse of the whole matrix, for the likeliest of them."""
    unlit = unlit_window(3.0, 0.0, 1)[:6, :5]
    variance = 1.5
    away = (unlit - unlit.mean()).ravel()
    rows, columns = np.indices(unlit.shape).reshape(2, -1)
    down, across = (np.abs(np.subtract.outer(each, each)) for each in (rows, columns))
    kinds = [np.exp(-(down**2 + across**2) / 2.0 / length**2) for length in (1.0, 2.0, 4.0)]
    kinds += [np.exp(-(down + across) / length) for length in (3.0, 30.0)]
    likeliest = max(
        -0.5 * (away @ np.linalg.solve(matrix, away) + np.linalg.slogdet(matrix)[1])
        for kind in kinds for strength in (0.0, *np.geomspace(0.02, 5000.0, 14))
        for matrix in [variance * (np.eye(30) + strength * kind)]
    )
    assert log_likelihood_of_texture(unlit, variance) == pytest.approx(likeliest, rel=1e-9)

"""The filter undone: exactly above black, in doubt by no more than is said below it."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.camera import CalibrationError
from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.location import locate
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.simulation.trailing_edge import peaked
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest

EDGE = TrailingEdge(1.0, 4.0)
SHAPE = (31, 64)
NOISE = SensorNoise(gain=40.0, read_noise=0.7)


@pytest.mark.parametrize(('peaking', 'memory'), [(0.0, 1.0), (0.3, 12.0), (1.0, 4.0), (3.0, 0.7)])
def test_unclipped_lines_come_back_exactly(peaking: float, memory: float) -> None:
    """The filter is linear above black, and its inverse is exact to rounding."""
    edge = TrailingEdge(peaking, memory)
    light = 80.0 + 30.0 * pixel_integrated_gaussian(SHAPE, 32.0, 15.0, 2.5)
    signal, doubt = edge.restored(peaked(light, edge))
    assert signal == pytest.approx(light, abs=1e-9)
    assert not doubt.any()


def test_clipped_lines_are_within_their_doubt() -> None:
    """No pixel is further from the light than is said, and those on the rise are in no doubt."""
    light = 8.0 + 120.0 * pixel_integrated_gaussian(SHAPE, 32.0, 15.0, 2.5)
    signal, doubt = EDGE.restored(np.maximum(peaked(light, EDGE), 0.0))
    assert (np.abs(signal - light) <= doubt + 1e-9).all()
    assert not doubt[:, :33].any()
    assert doubt.max() > 5.0


@pytest.mark.parametrize('background', [8.0, 60.0])
def test_located_where_the_light_is(background: float) -> None:
    """Clipped or not, the offset of 0.8 px is gone to 4 standard errors of 60 blobs."""
    random = np.random.default_rng(4)
    raw, restored = [], []
    for _ in range(60):
        x, y = 32.0 + random.uniform(-0.5, 0.5), 15.0 + random.uniform(-0.5, 0.5)
        light = background + 90.0 * pixel_integrated_gaussian(SHAPE, x, y, 2.5)
        window = Window(expose(peaked(light, EDGE), NOISE, random), saturation=255.0)
        raw.append(locate(window, noise=NOISE).x - x)
        restored.append(locate(EDGE.corrected(window), noise=NOISE).x - x)
    assert np.mean(raw) == pytest.approx(-0.8, abs=0.1)
    assert abs(np.mean(restored)) < 4.0 * np.std(restored, ddof=1) / np.sqrt(60)
    assert np.std(restored) < 0.02  # twice the bound of the unfiltered blob


def test_window_is_cut_evenly_where_it_is_in_doubt() -> None:
    """As many columns on either side of the brightest, with their place on the sensor."""
    light = 8.0 + 120.0 * pixel_integrated_gaussian(SHAPE, 32.0, 15.0, 2.5)
    seen = np.maximum(peaked(light, EDGE), 0.0)
    window = EDGE.corrected(Window(seen, np.full(SHAPE, 8.0), x0=100, y0=7, saturation=255.0))
    assert window.lit.shape[1] % 2 == 1
    middle = window.lit.shape[1] // 2
    assert window.x0 - 100 + middle == int(np.argmax(seen.max(axis=0)))
    assert window.unlit is not None
    assert window.unlit.shape == window.lit.shape
    assert window.y0 == 7


def test_clipped_bright_pixels_stay_clipped() -> None:
    """Nothing that is restored above full scale passes for a clipped pixel, nor the reverse."""
    light = 60.0 + 150.0 * pixel_integrated_gaussian(SHAPE, 32.0, 15.0, 2.5)
    seen = np.clip(peaked(light, EDGE), 0.0, 255.0)
    window = EDGE.corrected(Window(seen, saturation=255.0))
    assert window.saturation is not None
    assert (np.asarray(window.lit) >= window.saturation).sum() == (seen >= 255.0).sum()


def test_written_and_read_again(tmp_path: Path) -> None:
    """To the last digit, with its covariance."""
    path = tmp_path / 'edge.yaml'
    covariance = np.array([[1e-6, -2e-6], [-2e-6, 4e-5]])
    TrailingEdge(0.987654321, 4.1, covariance).to_yaml(path, ['how it was made'])
    again = TrailingEdge.from_yaml(path)
    assert (again.peaking, again.memory) == (0.987654321, 4.1)
    assert again.covariance is not None
    assert again.covariance.tolist() == covariance.tolist()


@pytest.mark.parametrize(
    ('peaking', 'memory'), [(-0.1, 4.0), (np.nan, 4.0), (1.0, 0.0), (1.0, np.inf), (11.0, 4.0)]
)
def test_impossible_values_are_refused(peaking: float, memory: float) -> None:
    """With a sentence that says what would be possible."""
    with pytest.raises(CalibrationError, match='must be'):
        TrailingEdge(peaking, memory)

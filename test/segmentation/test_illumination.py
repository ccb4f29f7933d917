"""A change of the light on the scene is measured row by row, and taken out."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.illumination import relit, row_gains
from blob_tracker.simulation import expose, flashing_light, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise
import numpy as np
import pytest
from support.contrasts import contrast_of, searched

SHAPE = (240, 320)
NOISE = SensorNoise(gain=40.0, read_noise=0.7)
WALL = flashing_light(width=320, height=240, background=80.0, texture=15.0).wall.astype(float)
ROWS = np.arange(SHAPE[0])
CHANGES = {
    'brighter': np.full(SHAPE[0], 1.12),
    'darker': np.full(SHAPE[0], 0.9),
    'bands': 1.0 + 0.15 * np.sin(ROWS / 20.0),
    'slope': 1.0 + 0.1 * (ROWS / 240.0 - 0.5),
}


def pair(gain: np.ndarray, amplitude: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return lit and unlit frame of the wall, the lit one in another light."""
    random = np.random.default_rng(1)
    light = amplitude * pixel_integrated_gaussian(SHAPE, 150.3, 100.6, 2.0)
    lit, unlit = (
        expose(mean, NOISE, random) for mean in (WALL * gain[:, None] + light, WALL)
    )
    return lit, unlit


@pytest.mark.parametrize('name', CHANGES)
def test_gain_of_each_row_is_found(name: str) -> None:
    """To half a per cent: 64 px of 80 DN and 1.6 DN of noise in each of five parts."""
    gain = CHANGES[name]
    gains, change = row_gains(*pair(gain), 0, SHAPE[0])
    assert gains.shape == (32, 2)
    assert np.all(np.diff(gains[:, 0]) > 0)
    np.testing.assert_allclose(gains[:, 1], gain[gains[:, 0].astype(int)], atol=0.01)
    expected = np.sqrt(np.mean(((gain - 1.0) * WALL.mean(axis=1)) ** 2))
    assert change == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize('name', CHANGES)
def test_the_unlit_frame_is_laid_in_the_new_light(name: str) -> None:
    """What is left is the noise of both, the unlit one's times the gain."""
    lit, unlit = pair(CHANGES[name])
    gains, _ = row_gains(lit, unlit, 0, SHAPE[0])
    left = lit.astype(float) - relit(unlit, gains, 255)
    noise = np.sqrt(2 * (80 / 40 + 0.7**2 + 2 / 12))
    assert abs(left.mean()) < 0.2
    # A hundredth of 80 DN is off here or there.
    assert left.std() < 1.2 * noise
    assert relit(unlit, gains, 255).dtype == np.uint8


def test_a_target_or_a_lamp_does_not_count() -> None:
    """It is in two of a row's five parts at most, and the median is not."""
    lit, unlit = pair(np.ones(SHAPE[0]))
    lit[80:120, 130:190] = 250
    gains, change = row_gains(lit, unlit, 0, SHAPE[0])
    np.testing.assert_allclose(gains[:, 1], 1.0, atol=0.01)
    assert change < 1.0


def test_dark_rows_say_nothing() -> None:
    """Of less than 4 DN the ratio is noise."""
    dark = np.full(SHAPE, 3, np.uint8)
    gains, change = row_gains(dark + np.uint8(2), dark, 0, SHAPE[0])
    assert (gains[:, 1] == 1.0).all() and change == 0.0


def test_relit_stays_within_full_scale() -> None:
    """Clipped, not wrapped around."""
    bright = np.full((10, 8), 200, np.uint8)
    assert (relit(bright, np.array([[0.0, 1.5], [9.0, 1.5]]), 255) == 255).all()
    assert (relit(bright, np.array([[5.0, 0.5]]), 255) == 100).all()


@pytest.mark.parametrize('height', [1, 2, 5, 33])
def test_a_few_rows_are_enough(height: int) -> None:
    """Each that is sampled is another one."""
    lit, unlit = (each[:height] for each in pair(CHANGES['brighter']))
    gains, _ = row_gains(lit, unlit, 0, height)
    assert len(set(gains[:, 0])) == max(min(height // 4, 32), 1)
    assert relit(unlit, gains, 255).shape == unlit.shape


@pytest.mark.parametrize('name', CHANGES)
def test_the_target_is_found_in_another_light(name: str) -> None:
    """And nothing else, though the texture has another height."""
    allowed = [
        each for each in searched(contrast_of(*pair(CHANGES[name], 60.0))).candidates
        if not each.rejected
    ]
    assert [(round(each.x), round(each.y)) for each in allowed] == [(150, 101)]


@pytest.mark.parametrize('factor', [1.7, 0.5])
def test_an_exposure_jump_gives_a_reason_and_no_window(factor: float) -> None:
    """The target lights up in the same frame; who knows by how much."""
    lit, unlit = pair(np.full(SHAPE[0], factor), 60.0)
    segmenter = Segmenter()
    segmenter.update(Frame(unlit, 1, 255))
    assert segmenter.update(Frame(lit, 10**7, 255)) is None
    assert 'switch auto-exposure off' in segmenter.reason

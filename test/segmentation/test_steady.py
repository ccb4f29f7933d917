"""A light that is always on is found by its height alone, and the window has no unlit half."""

from blob_tracker.location import locate
from blob_tracker.segmentation import FrameError, Segmenter
from blob_tracker.segmentation.steady import Steady
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame
import numpy as np
import pytest

SCENE = flashing_light(width=160, height=120, period=3.0)


def steady() -> Segmenter:
    """Return a segmenter that looks at single frames."""
    return Segmenter(flash=Steady(max_pair_interval=0.1))


def test_every_lit_frame_gives_a_window() -> None:
    """The light is 19 sigma above the texture, which also says how well it is placed."""
    segmenter = steady()
    errors = []
    for index in range(0, 60, 2):
        window = segmenter.update(Frame(SCENE.frame(index), 1 + index * 10**7, 255))
        assert window is not None and window.unlit is None
        found, truth = locate(window, noise=SCENE.sensor.noise), SCENE.truth(index)
        errors.append((found.x - truth.x, found.y - truth.y))
    # Nothing can be subtracted: sigma_x is about sigma over the peak SNR, 2 px / 19, and twice
    # that for texture of the blob's own size.
    assert np.sqrt(np.mean(np.square(errors))) < 0.2


@pytest.mark.parametrize('image, reason', [
    (flashing_light(width=160, height=120, seed=3).frame(1), 'times its noise and texture; a'),
    (np.zeros((120, 160), np.uint8), 'nothing lit up'),
    (np.full((120, 160), 255, np.uint8), 'nothing lit up'),
], ids=['texture', 'lens cap', 'all saturated'])
def test_a_scene_without_a_light_gives_none(image: np.ndarray, reason: str) -> None:
    """Texture is noise here."""
    segmenter = steady()
    assert segmenter.update(Frame(image, 1, 255)) is None
    assert reason in segmenter.reason


def test_a_repeated_frame_is_refused() -> None:
    """As in every mode."""
    segmenter = steady()
    segmenter.update(Frame(SCENE.frame(0), 1, 255))
    with pytest.raises(FrameError, match='repeated'):
        segmenter.update(Frame(SCENE.frame(0), 1, 255))

"""Hot pixels stand alone; the blinking ones switch as often as said."""

from blob_tracker.simulation import Drifting, HotPixels, Scene
import numpy as np
import pytest


def drawn(pixels: HotPixels, index: int) -> np.ndarray:
    """Return what they add to a picture of 320 x 240 px from a moving camera."""
    picture = np.zeros((240, 320), dtype=np.float32)
    pixels.draw(picture, Scene(width=320, height=240, camera=Drifting(3.0)).shot(index))
    return picture


def test_constant_ones_stay() -> None:
    """In their pixels, whatever the camera does, over the period of the blinking too."""
    pixels = HotPixels(constant=40, blinking=0)
    first = drawn(pixels, 0)
    assert 35 <= (first > 0).sum() <= 40
    for index in (1, 77, 4096, 4099):
        np.testing.assert_array_equal(drawn(pixels, index), first)


def test_blinking_ones_switch_as_often_as_said() -> None:
    """A tenth of them from frame to frame; the binomial's 4 sigma of 100 x 400 is 0.006."""
    pixels = HotPixels(constant=0, blinking=100, switching=0.1)
    on = np.array([drawn(pixels, index) > 0 for index in range(401)])
    switched = (on[1:] != on[:-1]).sum() / (400 * on.any(axis=0).sum())
    assert switched == pytest.approx(0.1, abs=0.006)


def test_they_stay_in_their_region() -> None:
    """The right half."""
    pixels = HotPixels(constant=200, blinking=0, region=(0.5, 0.0, 1.0, 1.0))
    assert drawn(pixels, 0)[:, :160].max() == 0.0

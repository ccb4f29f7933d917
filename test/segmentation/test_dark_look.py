"""The scene without its lights: a raw frame of a camera at rest, and nothing of one that moves."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.dark_look import DarkLook
from blob_tracker.types import Frame
import cv2
import numpy as np
from numpy.typing import NDArray
import pytest

BOX = Box(30, 20, 60, 50)


def texture(contrast: float) -> NDArray[np.float64]:
    """Return a scene of this standard deviation, DN."""
    noise = np.random.default_rng(1).standard_normal((200, 260))
    smooth = cv2.GaussianBlur(noise, (0, 0), 3.0)
    return np.asarray(60.0 + contrast * smooth / smooth.std())


def frames(contrast: float, drift: int, lit: int) -> list[Frame]:
    """Return ten frames, with a light in the middle of the box in those after `lit`."""
    random = np.random.default_rng(2)
    scene, found = texture(contrast), []
    rows, columns = np.mgrid[:120, :160]
    light = 80.0 * np.exp(-0.5 * ((columns - 45) ** 2 + (rows - 35) ** 2) / 1.5**2)
    for index in range(10):
        image = scene[:120, drift * index:drift * index + 160] + random.standard_normal((120, 160))
        image = image + light * (index > lit)
        found.append(Frame(np.rint(image.clip(0, 255)).astype(np.uint8), index, 255))
    return found


@pytest.mark.parametrize('contrast, drift, helps', [(0.0, 0, False), (10.0, 0, True),
                                                    (10.0, 5, False)])
def test_it_is_taken_off_where_that_helps(contrast: float, drift: int, helps: bool) -> None:
    """Off a texture that stands still; an even scene and one that moves are left as they are."""
    look, shown = DarkLook(), frames(contrast, drift, 10)
    for frame in shown[:-1]:
        look.push(frame)
    assert bool(look.below(shown[-1]).any()) is helps


def test_the_last_dark_frame_is_given() -> None:
    """The one before the light came, of a camera at rest; none of one that moves."""
    still, moving = DarkLook(), DarkLook()
    for one, other in zip(frames(10.0, 0, 6), frames(10.0, 5, 6)):
        still.push(one)
        moving.push(other)
    found = still.of(BOX, 1.2)
    assert found is not None
    np.testing.assert_array_equal(found, frames(10.0, 0, 6)[6].image)
    assert moving.of(BOX, 1.2) is None


@pytest.mark.parametrize('seed', range(5))
def test_a_light_that_is_seldom_off_and_moves_has_its_dark_frame(seed: int) -> None:
    """On in seven frames of nine, 2 px further in each; the level is told between whole DN."""
    random, look = np.random.default_rng(seed), DarkLook()
    scene, dark = texture(8.0)[:120, :160], (4, 8)
    rows, columns = np.mgrid[:120, :160]
    shown = []
    for index in range(12):
        x = 45.0 + 2.0 * (index - 11)
        light = 150.0 * np.exp(-0.5 * ((columns - x) ** 2 + (rows - 35) ** 2) / 2.0**2)
        image = scene + 1.2 * random.standard_normal((120, 160)) + light * (index not in dark)
        shown.append(np.rint(image.clip(0, 255)).astype(np.uint8))
        look.push(Frame(shown[-1], index, 255))
    found = look.of(Box(37, 27, 54, 44), 1.4)
    assert found is not None
    np.testing.assert_array_equal(found, shown[8])

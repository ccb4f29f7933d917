"""The picture of a frame: how it is exposed, whatever its size and depth."""

from __future__ import annotations

from blob_tracker.capture.picture import BAR, CLIPPED, draw, STRIP_PX
from blob_tracker.drawing import GAP_PX, PAPER
from blob_tracker.types import Frame
import numpy as np
import pytest


def has(picture, colour):
    """Tell whether a pixel has this colour."""
    return bool((picture == colour).all(axis=-1).any())


@pytest.mark.parametrize(('kind', 'saturation'), [
    (np.uint8, 255), (np.uint16, 4095), (np.uint16, 65535),
])
@pytest.mark.parametrize(('width', 'height', 'shown'), [
    (1, 1, (480, 480)), (160, 120, (480, 360)), (640, 480, (640, 480)),
    (1920, 1200, (960, 600)), (2000, 3, (960, 1)), (3, 2000, (480, 720)),
])
def test_a_lone_clipped_pixel_is_seen(width, height, shown, kind, saturation):
    """Small frames grow, large ones shrink, and what clips is red in either."""
    image = np.full((height, width), saturation // 2, kind)
    for clipped in (False, True):
        if clipped:
            image[height // 2, width // 2] = saturation
        picture = draw(Frame(image, 1, saturation), ['30 Hz'])
        assert picture.shape[1] == shown[0] + 2 * GAP_PX
        frame = picture[GAP_PX:GAP_PX + shown[1], GAP_PX:-GAP_PX]
        assert has(frame, CLIPPED) == clipped
        assert (picture[-GAP_PX:] == PAPER).all()
        if not clipped:
            # Half of full scale is 127 or 128 of 255.
            assert abs(int(frame[0, 0, 0]) - 127) <= 1


def test_the_histogram_is_that_of_the_levels():
    """A bar at each of two levels, the taller where more pixels are; red where they clip."""
    image = np.full((480, 640), 64, np.uint8)
    image[:2] = 192
    strip = draw(Frame(image, 1, 255))[GAP_PX + 480 + GAP_PX:, GAP_PX:-GAP_PX][:STRIP_PX]
    bars = (strip == BAR).all(axis=-1).sum(axis=0)
    # 256 bins over 640 columns: 2.5 each.
    assert bars[160:162].min() == STRIP_PX
    assert 0 < bars[480:482].min() < STRIP_PX
    assert bars.astype(bool).sum() == pytest.approx(5, abs=1)
    image[0, 0] = 255
    strip = draw(Frame(image, 1, 255))[GAP_PX + 480 + GAP_PX:, GAP_PX:-GAP_PX][:STRIP_PX]
    assert has(strip[:, -2:], CLIPPED)


def test_long_words_are_wrapped():
    """They stay inside the picture."""
    picture = draw(Frame(np.zeros((120, 160), np.uint8), 1, 255), ['what the camera says ' * 20])
    assert (picture[:, -GAP_PX:] == PAPER).all()

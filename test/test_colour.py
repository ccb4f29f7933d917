"""A colour of a frame: whose samples it has, where they clip, and what has no such colour."""

from __future__ import annotations

from typing import Any

from blob_tracker.colour import channels, grey_pixels, in_channel
from blob_tracker.types import BAYER, Frame
import cv2
import numpy as np
import pytest

RANDOM = np.random.default_rng(2)
MOSAIC = RANDOM.integers(0, 200, (6, 8), np.uint8)
COLOURS = RANDOM.integers(0, 200, (6, 8, 4), np.uint8)


def frame(image: np.ndarray, layout: str, **others: Any) -> Frame:
    """Return a frame of 8 bits."""
    return Frame(image, 1, 255, layout=layout, **others)


@pytest.mark.parametrize('order', BAYER)
@pytest.mark.parametrize('channel', ['red', 'green', 'blue', 'luma'])
def test_a_mosaic_keeps_its_samples(order: str, channel: str) -> None:
    """Their sum in each cell is the picture; the sites say which of them it is."""
    found = in_channel(frame(MOSAIC, order, x0=10, binning=(2, 1)), channel)
    letter = 'g' if channel == 'luma' else channel[0]
    total = np.zeros((3, 4), int)
    for place, colour in enumerate(order):
        row, column = divmod(place, 2)
        assert found.mosaic.sites[row, column] == (colour == letter)
        total += (colour == letter) * MOSAIC[row::2, column::2].astype(int)
    np.testing.assert_array_equal(found.image, total)
    np.testing.assert_array_equal(found.samples, MOSAIC)
    assert (found.x0, found.binning, found.layout) == (10, (4, 2), 'grey')
    assert found.saturation == (510 if letter == 'g' else 255)
    assert found.sample_saturation == 255


def test_sums_clip_where_a_sample_does() -> None:
    """Also where they are halved to fit into 16 bits."""
    for full, total in ((255, 510), (65535, 65535)):
        image = np.full((2, 4), 7, np.uint8 if full == 255 else np.uint16)
        image[0, 1] = full
        found = in_channel(Frame(image, 1, full, layout='rggb'), 'green')
        assert found.saturation == total
        assert found.image.tolist() == [[total, 14 if full == 255 else 7]]


def test_half_a_cell_is_left_out() -> None:
    """And where there is no cell at all, that is said."""
    assert in_channel(frame(MOSAIC[:5, :7], 'gbrg'), 'blue').samples.shape == (4, 6)
    with pytest.raises(ValueError, match='8 x 1 px have no cell of 2 x 2'):
        in_channel(frame(MOSAIC[:1], 'gbrg'), 'blue')


@pytest.mark.parametrize('layout', ['rgb', 'bgr', 'rgba', 'bgra'])
def test_planes_go_by_their_order(layout: str) -> None:
    """Luma is clipped where a colour is, and alpha is none."""
    image = COLOURS[..., :len(layout)].copy()
    image[..., 3:] = 255
    for name in ('red', 'green', 'blue'):
        found = in_channel(frame(image, layout), name)
        np.testing.assert_array_equal(found.image, image[..., layout.index(name[0])])
        assert found.channel == name and found.saturation == 255
    image[2, 3, layout.index('r')] = 255
    luma = in_channel(frame(image, layout), 'luma').image
    assert luma[2, 3] == 255 and (luma == 255).sum() == 1
    red, green, blue = (image[0, 0, layout.index(each)] for each in 'rgb')
    assert luma[0, 0] == pytest.approx(0.299 * red + 0.587 * green + 0.114 * blue, abs=1.0)


def test_yuv_is_converted() -> None:
    """Its luma is as it came."""
    colours = COLOURS[..., :3]
    yuv = np.ascontiguousarray(cv2.cvtColor(colours, cv2.COLOR_RGB2YCrCb)[..., (0, 2, 1)])
    np.testing.assert_array_equal(in_channel(frame(yuv, 'yuv'), 'luma').image, yuv[..., 0])
    for index, name in enumerate(('red', 'green', 'blue')):
        found = in_channel(frame(yuv, 'yuv'), name).image.astype(int)
        assert abs(found - colours[..., index]).max() <= 2  # DN: rounded there and back


def test_a_grey_camera_has_no_colour() -> None:
    """It is its own luma."""
    grey = frame(MOSAIC, 'grey')
    assert channels(grey) == () and in_channel(grey, 'luma') is grey
    with pytest.raises(ValueError, match='the camera is grey, it has no channel red'):
        in_channel(grey, 'red')


@pytest.mark.parametrize(('image', 'layout', 'sentence'), [
    (MOSAIC, 'rgb', r'\(h, w, 3\) array'),
    (COLOURS, 'rggb', r'\(h, w\) array'),
    (COLOURS, 'rgb', r'\(h, w, 3\) array'),
    (MOSAIC, 'cmyg', "the layout of a frame is 'cmyg'"),
])
def test_an_image_of_another_layout_is_refused(
    image: np.ndarray, layout: str, sentence: str
) -> None:
    """With what would be right."""
    with pytest.raises(ValueError, match=sentence):
        frame(image, layout)


@pytest.mark.parametrize('order', ['rggb', 'grbg', 'gbrg', 'bggr'])
def test_an_interpolated_mosaic_has_things_where_they_are(order: str) -> None:
    """A grey Gaussian through any mosaic is where it was, to what the interpolation does to it."""
    y, x = np.mgrid[0:40, 0:40]
    spot = 200.0 * np.exp(-((x - 19.3) ** 2 + (y - 20.6) ** 2) / 18.0)
    frame = Frame(np.rint(spot).astype(np.uint8), 0, 255, layout=order)
    grey = grey_pixels(frame, interpolate=True).astype(float)
    assert grey.shape == (40, 40)
    inner = grey[2:-2, 2:-2]  # at the border there are too few neighbours
    total = inner.sum()
    assert (inner * x[2:-2, 2:-2]).sum() / total == pytest.approx(19.3, abs=0.02)
    assert (inner * y[2:-2, 2:-2]).sum() / total == pytest.approx(20.6, abs=0.02)


@pytest.mark.parametrize(('order', 'first'), [
    ('rggb', (0, 1)), ('grbg', (0, 0)), ('gbrg', (0, 0)), ('bggr', (0, 1)),
])
def test_one_green_sample_of_each_cell(order: str, first: tuple[int, int]) -> None:
    """As the sensor gave it, for the noise."""
    pixels = np.arange(24, dtype=np.uint8).reshape(4, 6)
    green = grey_pixels(Frame(pixels, 0, 255, layout=order), interpolate=False)
    np.testing.assert_array_equal(green, pixels[first[0]::2, first[1]::2])

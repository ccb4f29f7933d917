"""The luma of RGB in every order of bytes."""

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
import numpy as np
import pytest

HEIGHT, WIDTH = 5, 9
# name -> bytes of a pixel, places of R, G and B
LAYOUTS = {
    'RGB3': (3, (0, 1, 2)), 'BGR3': (3, (2, 1, 0)),
    'RGB4': (4, (1, 2, 3)), 'BA24': (4, (1, 2, 3)), 'BX24': (4, (1, 2, 3)),
    'BGR4': (4, (2, 1, 0)), 'AR24': (4, (2, 1, 0)), 'XR24': (4, (2, 1, 0)),
    'AB24': (4, (0, 1, 2)), 'XB24': (4, (0, 1, 2)),
    'RA24': (4, (3, 2, 1)), 'RX24': (4, (3, 2, 1)),
}


@pytest.mark.parametrize('name', LAYOUTS)
def test_luma(decode, name):
    size, places = LAYOUTS[name]
    pixels = np.random.default_rng(3).integers(0, 255, (HEIGHT, WIDTH, size), np.uint8)
    if size == 4:
        pixels[..., ({0, 1, 2, 3} - set(places)).pop()] = 255  # opaque: not a clipped colour
    luma = pixels[..., places] @ [0.299, 0.587, 0.114]
    # Half for rounding, and 14 bits of the weights.
    assert np.abs(decode(name, pixels, WIDTH, HEIGHT) - luma).max() <= 0.52


@pytest.mark.parametrize('name', LAYOUTS)
@pytest.mark.parametrize('colour', [0, 1, 2])
def test_one_clipped_colour_clips_the_pixel(decode, name, colour):
    size, places = LAYOUTS[name]
    pixels = np.full((HEIGHT, WIDTH, size), 254, np.uint8)
    pixels[2, 3] = 0
    pixels[2, 3, places[colour]] = 255
    luma = decode(name, pixels, WIDTH, HEIGHT)
    assert luma[2, 3] == 255
    assert (luma == 254).sum() == HEIGHT * WIDTH - 1


@pytest.mark.parametrize('name', LAYOUTS)
@pytest.mark.parametrize('colour', [0, 1, 2])
@pytest.mark.parametrize('level', [235, 240, 255])  # noise may lie above the white of 235
def test_one_clipped_colour_of_the_limited_range_clips_the_pixel(name, colour, level):
    size, places = LAYOUTS[name]
    pixels = np.full((HEIGHT, WIDTH, size), 234, np.uint8)
    if size == 4:
        pixels[..., ({0, 1, 2, 3} - set(places)).pop()] = 255  # opaque: not a clipped colour
    pixels[2, 3, places] = 0
    pixels[2, 3, places[colour]] = level
    limited = PIXEL_FORMATS[name].limited_range
    luma = limited.luma(pixels.tobytes(), WIDTH, HEIGHT, 0)
    assert luma[2, 3] == limited.saturation == 235
    assert (luma == 234).sum() == HEIGHT * WIDTH - 1

"""The luma of YUV, told from chroma that no luma may be confused with."""

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
import numpy as np
import pytest

HEIGHT, WIDTH = 6, 8


@pytest.fixture
def luma():
    return np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH), dtype=np.uint8)


@pytest.mark.parametrize(('name', 'place'), [('YUYV', 0), ('YVYU', 0), ('UYVY', 1), ('VYUY', 1)])
def test_packed(decode, luma, name, place):
    packed = np.empty((HEIGHT, WIDTH, 2), np.uint8)
    packed[..., place] = luma
    packed[..., 1 - place] = 255 - luma
    np.testing.assert_array_equal(decode(name, packed, WIDTH, HEIGHT), luma)


@pytest.mark.parametrize('name', ['NV12', 'NV21', 'NV16', 'NV24', 'YU12', 'YV12', 'NM12', 'YM21'])
@pytest.mark.parametrize('chroma', [0, HEIGHT // 2])  # lines of it behind the luma, if any
def test_planar(decode, luma, name, chroma):
    lines = np.vstack([luma, np.full((chroma, WIDTH), 128, np.uint8)])
    np.testing.assert_array_equal(decode(name, lines, WIDTH, HEIGHT), luma)


def test_white_is_clipped_unless_the_driver_says_that_it_is_not():
    for name in ('YUYV', 'UYVY', 'NV12', 'YM12'):
        assert PIXEL_FORMATS[name].saturation == 235
        assert PIXEL_FORMATS[name].full_range_saturation == 255

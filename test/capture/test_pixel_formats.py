"""Luma of each pixel format, with and without padded lines."""

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
import numpy as np
import pytest

HEIGHT, WIDTH = 5, 8


@pytest.fixture
def luma():
    return np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH), dtype=np.uint8)


def packed_yuyv(luma):
    """Interleave chroma that no luma value may be confused with."""
    packed = np.empty((HEIGHT, 2 * WIDTH), np.uint8)
    packed[:, ::2] = luma
    packed[:, 1::2] = 255 - luma
    return packed


def padded(lines, padding):
    """Return lines with junk after each; the last line has no padding, as drivers may do."""
    with_junk = np.pad(lines, ((0, 0), (0, padding)), constant_values=77)
    data = with_junk.tobytes()
    return data[:len(data) - padding], with_junk.shape[1]


@pytest.mark.parametrize('padding', [0, 3, 64])
def test_grey(luma, padding):
    data, stride = padded(luma, padding)
    np.testing.assert_array_equal(grey(data, WIDTH, HEIGHT, stride), luma)


@pytest.mark.parametrize('padding', [0, 6, 64])
def test_yuyv(luma, padding):
    data, stride = padded(packed_yuyv(luma), padding)
    np.testing.assert_array_equal(yuyv(data, WIDTH, HEIGHT, stride), luma)


@pytest.mark.parametrize(('name', 'pack'), [('GREY', np.copy), ('YUYV', packed_yuyv)])
def test_stride_of_zero_means_no_padding(luma, name, pack):
    decoded = PIXEL_FORMATS[name].luma(pack(luma).tobytes(), WIDTH, HEIGHT, 0)
    np.testing.assert_array_equal(decoded, luma)


@pytest.mark.parametrize('name', PIXEL_FORMATS)
def test_the_buffer_may_be_written_again_at_once(name):
    buffer = bytearray(2 * WIDTH * HEIGHT)
    decoded = PIXEL_FORMATS[name].luma(memoryview(buffer), WIDTH, HEIGHT, 0)
    buffer[:] = b'\xff' * len(buffer)
    assert decoded.max() == 0


@pytest.mark.parametrize(('name', 'line_bytes'), [('GREY', WIDTH), ('YUYV', 2 * WIDTH)])
def test_a_picture_cut_short_is_refused(name, line_bytes):
    data = bytes(line_bytes * HEIGHT - 1)
    with pytest.raises(ValueError, match=f'has {len(data)} bytes; it takes {len(data) + 1}'):
        PIXEL_FORMATS[name].luma(data, WIDTH, HEIGHT, line_bytes)


def test_a_stride_shorter_than_a_line_is_refused():
    with pytest.raises(ValueError, match='lines are 7 bytes apart; a line alone takes 8'):
        grey(bytes(100), WIDTH, HEIGHT, 7)

"""What holds for every pixel format."""

from __future__ import annotations

import mmap

from blob_tracker.capture import videodev2
from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.colour import in_channel
from blob_tracker.types import Frame
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

PLAIN = [name for name, found in PIXEL_FORMATS.items() if not found.compressed]
HEIGHT, WIDTH = 6, 16


def least(name: str, width: int, height: int, stride: int) -> int:
    """Return the bytes that a picture takes, as the refusal of an empty one says."""
    with pytest.raises(ValueError, match='the picture has 0 bytes; it takes') as error:
        PIXEL_FORMATS[name].luma(b'', width, height, stride)
    return int(str(error.value).rsplit(' ', 1)[1])


@pytest.mark.parametrize('name', PIXEL_FORMATS)
def test_a_code_is_one_of_the_kernels_form(name):
    assert videodev2.fourcc_name(videodev2.fourcc(name)) == name
    assert len(name.removesuffix('-BE')) in (3, 4)


@pytest.mark.parametrize('name', PLAIN)
def test_a_picture_is_as_large_as_promised_and_its_own(name):
    buffer = bytearray(least(name, WIDTH, HEIGHT, 0))
    found = PIXEL_FORMATS[name]
    picture = found.luma(memoryview(buffer), WIDTH, HEIGHT, 0)
    assert picture.shape == (HEIGHT // found.binning, WIDTH // found.binning)
    assert picture.dtype in (np.uint8, np.uint16)
    assert picture.dtype.isnative
    assert picture.flags.c_contiguous
    # The driver may write the buffer again at once.
    buffer[:] = b'\xff' * len(buffer)
    assert picture.max() == 0


@pytest.mark.parametrize('name', PLAIN)
def test_full_scale_is_clipped(name):
    data = b'\xff' * least(name, WIDTH, HEIGHT, 0)
    found = PIXEL_FORMATS[name]
    picture = found.luma(data, WIDTH, HEIGHT, 0)
    assert picture.min() >= found.saturation
    assert np.iinfo(picture.dtype).max >= found.saturation


@pytest.mark.parametrize('name', PLAIN)
@settings(max_examples=30, deadline=None, derandomize=True)
@given(width=st.integers(2, 40), height=st.integers(2, 9), padding=st.integers(0, 40),
       seed=st.integers(0, 99))
def test_nothing_behind_the_last_pixel_is_read(name, width, height, padding, seed):
    line = least(name, width, 1, 0) if PIXEL_FORMATS[name].binning == 1 else (
        least(name, width, 2, 0) // 2)
    stride = line + padding
    size = least(name, width, height, stride)
    assert size == stride * (height - 1) + line
    data = np.random.default_rng(seed).bytes(size)
    decode = PIXEL_FORMATS[name].luma
    whole = decode(data, width, height, stride)
    # At the very end of the last page that is mapped, a byte further is no memory of ours.
    with mmap.mmap(-1, -(-size // mmap.PAGESIZE) * mmap.PAGESIZE) as memory:
        memory[-size:] = data
        view = memoryview(memory)[-size:]
        last = decode(view, width, height, stride)
        view.release()
    np.testing.assert_array_equal(last, whole)
    for cut in (1, line, size):
        with pytest.raises(ValueError, match=f'has {size - cut} bytes; it takes {size}'):
            decode(data[:size - cut], width, height, stride)
    with pytest.raises(ValueError, match=f'{line - 1} bytes apart; a line alone takes {line}'):
        decode(data, width, height, line - 1)


@pytest.mark.parametrize('name', [each for each in PLAIN if PIXEL_FORMATS[each].colours])
@settings(max_examples=10, deadline=None, derandomize=True)
@given(padding=st.sampled_from([0, 2, 32]), seed=st.integers(0, 99))
def test_the_luma_of_the_colours_is_the_luma(name, padding, seed):
    # Read as colours and made grey afterwards, as the segmenter does, or grey at once.
    found = PIXEL_FORMATS[name]
    stride = least(name, WIDTH, 2, 0) // 2 + padding
    data = np.random.default_rng(seed).bytes(stride * HEIGHT)
    colours = found.colours(data, WIDTH, HEIGHT, stride)
    assert colours.shape[:2] == (HEIGHT, WIDTH) and colours.flags.c_contiguous
    frame = Frame(colours, 0, found.colour_saturation, layout=found.layout)
    luma = in_channel(frame, 'luma')
    np.testing.assert_array_equal(luma.image, found.luma(data, WIDTH, HEIGHT, stride))
    assert luma.saturation == found.saturation
    assert luma.binning == (found.binning, found.binning)

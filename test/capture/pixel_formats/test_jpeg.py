"""Motion JPEG: the grey of whole pictures, and a sentence for all others."""

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.pixel_formats.jpeg import luma_quantisation
import cv2
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

HEIGHT, WIDTH = 48, 64
decode = PIXEL_FORMATS['MJPG'].luma


def encoded(quality=95, **options):
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    picture = np.stack([3 * x, 4 * y, 100 + x + y], axis=-1).astype(np.uint8)
    flags = [cv2.IMWRITE_JPEG_QUALITY, quality]
    for name, value in options.items():
        flags += [getattr(cv2, f'IMWRITE_JPEG_{name.upper()}'), value]
    return picture, cv2.imencode('.jpg', picture, flags)[1].tobytes()


@pytest.mark.parametrize('options', [{}, {'rst_interval': 4}, {'progressive': 1}])
def test_luma(options):
    picture, data = encoded(**options)
    luma = decode(data, WIDTH, HEIGHT, 0)
    assert luma.dtype == np.uint8
    # Quality 95 of a smooth picture.
    expected = picture @ [0.114, 0.587, 0.299]
    assert np.abs(luma - expected).max() < 4


def test_what_a_camera_puts_around_it_does_no_harm():
    _, data = encoded()
    # An application's segment with markers in it, and a buffer that is not filled to its end.
    segment = b'\xff\xe4\x00\x08\xff\xd9\xff\xda\xff\xc0'
    dressed = data[:2] + segment + data[2:] + bytes(100)
    np.testing.assert_array_equal(
        decode(dressed, WIDTH, HEIGHT, 0), decode(data, WIDTH, HEIGHT, 0))


def test_another_size_is_refused_before_it_is_decoded():
    _, data = encoded()
    place = data.index(b'\xff\xc0') + 5
    huge = data[:place] + b'\xff\xff\xff\xff' + data[place + 4:]  # 4 GB
    with pytest.raises(ValueError, match='the JPEG is 65535x65535, not 64x48'):
        decode(huge, WIDTH, HEIGHT, 0)


def test_not_a_jpeg():
    with pytest.raises(ValueError, match='this is not a JPEG'):
        decode(b'\x00' * 5000, WIDTH, HEIGHT, 0)


@pytest.mark.parametrize('options', [{}, {'rst_interval': 4}, {'progressive': 1}])
def test_a_picture_cut_short_anywhere_is_refused(options):
    _, data = encoded(quality=50, **options)
    for length in range(len(data)):
        with pytest.raises(ValueError, match='JPEG'):
            decode(data[:length], WIDTH, HEIGHT, 0)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.data())
def test_a_damaged_picture_is_a_picture_or_refused(data):
    _, whole = encoded(quality=50)
    damaged = bytearray(whole)
    for _ in range(data.draw(st.integers(1, 8))):
        damaged[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    try:
        luma = decode(bytes(damaged), WIDTH, HEIGHT, 0)
    except ValueError:
        return
    assert luma.shape == (HEIGHT, WIDTH)
    assert luma.dtype == np.uint8


def test_steps_of_the_luma_are_in_the_header():
    # Table K.1 of ITU-T T.81 is quality 50; in colour there is one of the chroma beside it.
    for picture in (np.zeros((48, 64), np.uint8), np.zeros((48, 64, 3), np.uint8)):
        steps = luma_quantisation(
            cv2.imencode('.jpg', picture, [cv2.IMWRITE_JPEG_QUALITY, 50])[1].tobytes())
        assert steps.shape == (8, 8)
        assert steps[0].tolist() == [16, 11, 10, 16, 24, 40, 51, 61]
        assert steps[:, 0].tolist() == [16, 12, 14, 14, 18, 24, 49, 72]


def test_a_header_without_steps_is_refused():
    _, whole = encoded()
    for wrong, sentence in (
        (b'', 'it has no scan'),
        (whole[:20], 'it has no scan'),
        (whole[:60], 'a table is cut short'),
        (whole.replace(b'\xff\xdb', b'\xff\xee'), 'no table of its luma'),
    ):
        with pytest.raises(ValueError, match=sentence):
            luma_quantisation(wrong)

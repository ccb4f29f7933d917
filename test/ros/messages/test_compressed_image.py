"""Compressed images: what they hold, and what is refused with a sentence."""

from __future__ import annotations

from array import array

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.compressed_image import to_whole_frame
from blob_tracker.segmentation.compression import standard_quantisation
import cv2
import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage

GREY = np.arange(24, dtype=np.uint8).reshape(4, 6)


def message(data: bytes, form: str) -> CompressedImage:
    """Return a message of some bytes."""
    return CompressedImage(format=form, data=array('B', data))


def encoded(content: np.ndarray, suffix: str = '.png') -> bytes:
    """Return a compressed picture."""
    return cv2.imencode(suffix, content)[1].tobytes()


@pytest.mark.parametrize(('form', 'content', 'layout'), [
    ('png', GREY, 'grey'),
    ('bayer_gbrg8; png compressed ', GREY, 'gbrg'),
    ('bayer_gbrg8; jpeg compressed bgr8', np.dstack([GREY] * 3), 'bgr'),  # was interpolated
    ('bgra8; png compressed bgra8', np.dstack([GREY] * 4), 'bgra'),
    ('mono16; png compressed ', GREY.astype(np.uint16) * 300, 'grey'),
])
def test_pictures(form: str, content: np.ndarray, layout: str) -> None:
    """The planes tell of colours, the format of a mosaic."""
    frame = to_whole_frame(message(encoded(content), form))
    assert frame.layout == layout
    assert frame.image.dtype == content.dtype
    np.testing.assert_array_equal(frame.image, content)
    assert frame.saturation == np.iinfo(content.dtype).max


def test_a_jpeg_tells_its_steps_and_the_order_of_its_colours() -> None:
    """Those of its quality (ITU-T T.81, K.1); image_transport may have swapped the planes."""
    data = cv2.imencode('.jpg', GREY, [cv2.IMWRITE_JPEG_QUALITY, 50])[1].tobytes()
    frame = to_whole_frame(message(data, 'bayer_rggb8; jpeg compressed mono8'))
    assert frame.layout == 'rggb'
    np.testing.assert_array_equal(frame.quantisation, standard_quantisation(50))
    colours = encoded(np.dstack([GREY] * 3), '.jpg')
    for form, layout in (
        ('rgb8; jpeg compressed bgr8', 'bgr'), ('rgb8; jpeg compressed rgb8', 'rgb'),
        ('jpeg', 'bgr'),
    ):
        assert to_whole_frame(message(colours, form)).layout == layout


@pytest.mark.parametrize('cut', [2, 30, 300, -2])
def test_a_broken_jpeg_is_refused(cut: int) -> None:
    """The decoder would fill it with grey without a word."""
    data = encoded(np.random.default_rng(1).integers(0, 255, (32, 32), np.uint8), '.jpg')
    with pytest.raises(MessageError, match='the JPEG is'):
        to_whole_frame(message(data[:cut], 'mono8; jpeg compressed '))


def test_depth_has_a_header_of_its_own() -> None:
    """Twelve bytes before the PNG."""
    deep = GREY.astype(np.uint16) * 300
    frame = to_whole_frame(message(bytes(12) + encoded(deep), '16UC1; compressedDepth png'))
    np.testing.assert_array_equal(frame.image, deep)


@pytest.mark.parametrize(('data', 'form', 'sentence'), [
    (b'', 'jpeg', '0 bytes of format .jpeg. are not a picture'),
    (encoded(GREY)[:-60], 'png', 'the PNG is cut short or damaged'),
    (bytes(12) + encoded(GREY)[:-60], '16UC1; compressedDepth', 'the PNG is cut short or damaged'),
    (b'\0\0\0\1\x67\x42', 'h264', 'of format .h264. are not a picture that OpenCV decodes'),
    (encoded(GREY.astype(np.float32), '.tiff'), 'tiff', 'holds float32; it must be 8 or 16 bits'),
])
def test_others_are_refused(data: bytes, form: str, sentence: str) -> None:
    """With what would be right."""
    with pytest.raises(MessageError, match=sentence):
        to_whole_frame(message(data, form))

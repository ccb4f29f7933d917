"""Images to arrays and back; every wrong field has its sentence."""

from __future__ import annotations

from typing import Any

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.image import (
    from_frame,
    from_picture,
    from_pixels,
    to_frame,
    to_window,
)
from blob_tracker.types import Frame, Glimpse, Window
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from support.window_messages import from_window

PIXELS = np.arange(12, dtype=np.uint8).reshape(3, 4)
INFO = CameraInfo(width=4, height=3)


def image(**changes: object) -> Image:
    """Return a good 4 x 3 image with some fields changed."""
    message = from_pixels(PIXELS, 5_000_000_007, 'optical')
    for name, value in changes.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
def test_frames_round_trip(kind: Any) -> None:
    """Pixels, stamp and frame survive."""
    pixels = (PIXELS.astype(kind) * (1 if kind is np.uint8 else 300)).astype(kind)
    message = from_pixels(pixels, 5_000_000_007, 'optical')
    assert message.encoding == ('mono8' if kind is np.uint8 else 'mono16')
    assert message.header.frame_id == 'optical'
    frame = to_frame(message, INFO)
    np.testing.assert_array_equal(frame.image, pixels)
    assert frame.stamp_ns == 5_000_000_007
    assert frame.saturation == np.iinfo(kind).max


def test_a_message_is_filled_again_in_place() -> None:
    """The array of the message is kept, its content is new."""
    message = image()
    data = message.data
    assert from_pixels(PIXELS[::-1], 1, 'optical', message) is message
    assert message.data is data
    np.testing.assert_array_equal(to_frame(message, INFO).image, PIXELS[::-1])


@pytest.mark.parametrize('unlit', [PIXELS[::-1], None])
@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
def test_windows_round_trip(unlit: np.ndarray | None, kind: type) -> None:
    """Lit and unlit pixels, place and binning survive."""
    window = Window(
        PIXELS.astype(kind),
        None if unlit is None else unlit.astype(kind),
        x0=10,
        y0=20,
        stamp_ns=7,
    )
    message = from_window(window, 'optical')
    assert message.encoding == f'{8 * kind().itemsize}UC{1 if unlit is None else 2}'
    info = CameraInfo(width=100, height=100, binning_x=2, binning_y=0)
    info.roi.x_offset, info.roi.y_offset, info.roi.width, info.roi.height = 10, 20, 8, 3
    back = to_window(message, info)
    np.testing.assert_array_equal(back.lit, PIXELS)
    if unlit is None:
        assert back.unlit is None
    else:
        np.testing.assert_array_equal(back.unlit, unlit)
    assert (back.x0, back.y0, back.stamp_ns, back.binning) == (10, 20, 7, (2, 1))


def test_pictures_are_bgr8() -> None:
    """Three channels, as image viewers know them."""
    picture = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)
    message = from_picture(picture, 7, 'optical')
    assert (message.encoding, message.step) == ('bgr8', 12)
    assert bytes(message.data) == picture.tobytes()


def test_padded_rows_and_big_endian_are_read() -> None:
    """Step may be wider than the row; bytes may be in the other order."""
    padded = np.zeros((3, 6), dtype=np.uint8)
    padded[:, :4] = PIXELS
    message = image(step=6, data=padded.tobytes())
    np.testing.assert_array_equal(to_frame(message, INFO).image, PIXELS)
    wide = (PIXELS.astype('>u2') * 300).astype('>u2')
    odd = np.zeros((3, 9), dtype=np.uint8)
    odd[:, :8] = np.ascontiguousarray(PIXELS.astype('<u2') * 300).view(np.uint8)
    frame = to_frame(image(encoding='mono16', step=9, data=odd.tobytes()), INFO)
    np.testing.assert_array_equal(frame.image, PIXELS.astype(int) * 300)
    message = image(encoding='mono16', step=8, is_bigendian=1, data=wide.tobytes())
    frame = to_frame(message, INFO)
    np.testing.assert_array_equal(frame.image, PIXELS.astype(int) * 300)
    assert frame.image.dtype == np.uint16


@pytest.mark.parametrize(
    'changes, sentence',
    [
        ({'encoding': 'rgb32'}, "encoding is 'rgb32'; it must be mono8 or"),
        ({'encoding': ''}, "encoding is ''"),
        ({'width': 0}, 'neither may be 0'),
        ({'height': 0}, 'neither may be 0'),
        ({'step': 3}, 'step is 3 bytes; 4 px of mono8 need 4'),
        ({'step': 5}, r'data has 12 bytes; step \* height is 5 \* 3 = 15'),
        ({'data': b''}, 'data has 0 bytes'),
        ({'encoding': 'mono16'}, 'step is 4 bytes; 4 px of mono16 need 8'),
    ],
)
def test_wrong_fields_are_named(changes: dict, sentence: str) -> None:
    """The sentence has the value that came and the one that would be right."""
    with pytest.raises(MessageError, match=sentence):
        to_frame(image(**changes), INFO)


def test_a_window_of_five_channels_is_refused() -> None:
    """Only lit, lit and unlit, what their pixels are worth, and how the light was seen."""
    with pytest.raises(MessageError, match="encoding is '8UC5'; it must be 8UC1 or 8UC2"):
        to_window(image(encoding='8UC5'), INFO)


@pytest.mark.parametrize(
    'info, sentence',
    [
        (CameraInfo(width=640, height=480), 'is 4 x 3 px and its camera_info is for 640 x 480 px'),
        (CameraInfo(width=4, height=3, binning_x=2**32 - 1), 'camera_info is for 0 x 3 px'),
        (CameraInfo(), 'camera_info is for 0 x 0 px'),
    ],
)
def test_a_camera_info_of_another_size_is_refused(info: CameraInfo, sentence: str) -> None:
    """A bearing made with it would be wrong."""
    with pytest.raises(MessageError, match=sentence):
        to_frame(image(), info)


def test_a_region_outside_the_sensor_is_refused() -> None:
    """The offset moves every bearing."""
    info = CameraInfo(width=100, height=100)
    info.roi.x_offset, info.roi.width, info.roi.height = 97, 4, 3
    with pytest.raises(MessageError, match='does not lie within the sensor of 100 x 100 px'):
        to_frame(image(), info)


RGB = np.random.default_rng(3).integers(0, 255, (4, 6, 3), np.uint8)
SMALL = CameraInfo(width=6, height=4)


def colour_message(encoding: str, pixels: np.ndarray, height: int = 4, step: int = 0) -> Image:
    """Return a 6 px wide message of raw bytes."""
    message = Image(height=height, width=6, encoding=encoding)
    message.step = step or pixels.nbytes // pixels.shape[0]
    message.data = np.ascontiguousarray(pixels).tobytes()
    return message


@pytest.mark.parametrize('encoding', ['rgb8', 'bgr8', 'rgba8', 'bgra8'])
def test_colours_go_there_and_back(encoding: str) -> None:
    """By their order."""
    layout = encoding[:-1]
    pixels = np.dstack([RGB, RGB[..., :1]])[..., :len(layout)]
    frame = to_frame(colour_message(encoding, pixels), SMALL)
    assert frame.layout == layout
    np.testing.assert_array_equal(frame.image, pixels)
    assert from_frame(frame, 'optical').encoding == encoding


@pytest.mark.parametrize('order', ['rggb', 'grbg', 'gbrg', 'bggr'])
@pytest.mark.parametrize(('bits', 'kind'), [(8, np.uint8), (16, np.uint16)])
def test_a_mosaic_goes_there_and_back(order: str, bits: int, kind: type) -> None:
    """As it is."""
    frame = Frame(RGB[..., 0].astype(kind), 7, 2**bits - 1, layout=order)
    message = from_frame(frame, 'optical')
    assert message.encoding == f'bayer_{order}{bits}'
    back = to_frame(message, SMALL)
    assert back.layout == order
    np.testing.assert_array_equal(back.image, frame.image)


@pytest.mark.parametrize(('encoding', 'luma_first'), [
    ('yuv422', False), ('uyvy', False), ('yuv422_yuy2', True), ('yuyv', True),
])
def test_packed_yuv(encoding: str, luma_first: bool) -> None:
    """Two pixels share their chromas."""
    y, cb, cr = RGB[..., 0], RGB[:, ::2, 1], RGB[:, ::2, 2]
    chromas = np.stack([cb, cr], axis=-1).reshape(4, 6)
    pairs = np.stack([y, chromas] if luma_first else [chromas, y], axis=-1).reshape(4, 12)
    frame = to_frame(colour_message(encoding, pairs), SMALL)
    assert frame.layout == 'yuv'
    np.testing.assert_array_equal(frame.image[..., 0], y)
    np.testing.assert_array_equal(frame.image[..., 1], np.repeat(cb, 2, axis=1))
    np.testing.assert_array_equal(frame.image[..., 2], np.repeat(cr, 2, axis=1))


@pytest.mark.parametrize('encoding', ['nv12', 'nv21'])
def test_semiplanar_yuv(encoding: str) -> None:
    """Four pixels share their chromas, which follow the luma."""
    y, first, second = RGB[..., 0], RGB[::2, ::2, 1], RGB[::2, ::2, 2]
    rows = np.vstack([y, np.stack([first, second], axis=-1).reshape(2, 6)])
    frame = to_frame(colour_message(encoding, rows), SMALL)
    cb, cr = (first, second) if encoding == 'nv12' else (second, first)
    np.testing.assert_array_equal(frame.image[..., 0], y)
    np.testing.assert_array_equal(frame.image[..., 1], cb.repeat(2, axis=0).repeat(2, axis=1))
    np.testing.assert_array_equal(frame.image[..., 2], cr.repeat(2, axis=0).repeat(2, axis=1))
    with pytest.raises(MessageError, match=r'data has 24 bytes; step \* height is 6 \* 6 = 36'):
        to_frame(colour_message(encoding, y), SMALL)


def test_chromas_of_half_a_pixel_are_refused() -> None:
    """An odd size has no place for them."""
    with pytest.raises(MessageError, match='must be even'):
        to_frame(image(encoding='nv12'), INFO)


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
@pytest.mark.parametrize('unlit', [PIXELS[::-1], None])
@pytest.mark.parametrize(('sites', 'added_noise'), [
    (PIXELS % 2 == 0, 0.0), (None, 1.25), (PIXELS % 3 == 0, 3.5),
])
def test_what_the_pixels_of_a_window_are_worth(
    kind: type, unlit: np.ndarray | None, sites: np.ndarray | None, added_noise: float
) -> None:
    """Which of them see the light, and the noise that compression added."""
    window = Window(
        PIXELS.astype(kind), None if unlit is None else unlit.astype(kind), sites=sites,
        added_noise=added_noise,
    )
    message = from_window(window, 'optical')
    assert message.encoding == ('8UC3' if kind is np.uint8 else '16UC3')
    back = to_window(message, INFO)
    np.testing.assert_array_equal(back.lit, window.lit)
    assert (back.unlit is None) == (unlit is None)
    if unlit is not None:
        np.testing.assert_array_equal(back.unlit, window.unlit)
    assert (back.sites is None) == (sites is None)
    if sites is not None:
        np.testing.assert_array_equal(back.sites, sites)
    assert back.added_noise == added_noise


def test_a_window_that_sees_nothing_is_refused() -> None:
    """A message may hold anything."""
    window = Window(PIXELS, PIXELS, sites=np.zeros(PIXELS.shape, bool))
    with pytest.raises(MessageError, match='no pixel of the window sees the light'):
        to_window(from_window(window, 'optical'), INFO)


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
@pytest.mark.parametrize('paired', [True, False])
def test_how_a_moving_light_was_seen_goes_there_and_back(kind: type, paired: bool) -> None:
    """Bit by bit, beside lit and unlit pixels."""
    lit: np.ndarray = np.arange(49, dtype=kind).reshape(7, 7)
    glimpse = Glimpse.of_numbers(
        np.array([0.3, 4.5, -2.25, 0.125, 0.01, -0.002, 0.04, 0.5, -0.25, 0.125], np.float32)
    )
    window = Window(lit, lit[::-1].copy() if paired else None, stamp_ns=7, glimpse=glimpse)
    message = from_window(window, 'optical')
    assert message.encoding == f'{8 * lit.dtype.itemsize}UC4'
    back = to_window(message, CameraInfo(width=7, height=7))
    assert back.glimpse is not None
    np.testing.assert_array_equal(back.glimpse.numbers, glimpse.numbers)
    np.testing.assert_array_equal(back.lit, lit)
    assert (back.unlit is not None) == paired


def test_a_fourth_channel_of_no_light_is_refused() -> None:
    """With what it must hold."""
    lit = np.arange(49, dtype=np.uint8).reshape(7, 7)
    glimpse = Glimpse.of_numbers(np.full(10, 2.0, np.float32))
    message = from_window(Window(lit, None, stamp_ns=7, glimpse=glimpse), 'optical')
    with pytest.raises(MessageError, match='share must be 0 to 1'):
        to_window(message, CameraInfo(width=7, height=7))

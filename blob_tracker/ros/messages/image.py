"""sensor_msgs/Image to frames and windows, and back, with every field checked."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TYPE_CHECKING

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.serialised import serialised_image
from blob_tracker.ros.messages.stamp import from_ns, SECOND_NS, to_ns
from blob_tracker.types import BAYER, Frame, FULL_SCALE_DN, Glimpse, Pixels, PLANES, Window
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # those of a bag are read where no ROS is installed, too
    from sensor_msgs.msg import CameraInfo, CompressedImage, Image

# encoding: (type of a pixel, channels)
_FRAMES = {
    'mono8': (np.uint8, 1),
    '8UC1': (np.uint8, 1),
    'mono16': (np.uint16, 1),
    '16UC1': (np.uint16, 1),
}
_COLOURS = {  # and the layout of a frame
    **{f'{layout}{bits}': (kind, planes, layout)
       for layout, planes in PLANES.items() if layout != 'yuv'
       for bits, kind in ((8, np.uint8), (16, np.uint16))},
    **{f'bayer_{layout}{bits}': (kind, 1, layout)
       for layout in BAYER for bits, kind in ((8, np.uint8), (16, np.uint16))},
}
# Two bytes a pixel, a luma and a chroma: which of the two the luma is, and the order of chromas.
_PACKED = {
    'yuv422': (1, 'uv'), 'uyvy': (1, 'uv'), 'yuv422_yuy2': (0, 'uv'), 'yuyv': (0, 'uv'),
}
# A plane of luma, and below it one of both chromas: their order, and whether each chroma stands
# for 2 x 2 pixels (of half the height) or for one (rows twice as long).
_SEMIPLANAR = {'nv12': ('uv', 2), 'nv21': ('vu', 2), 'nv24': ('uv', 1)}
# Of a frame; YUV to be named among the others.
_ENCODINGS = (
    _FRAMES | {name: (kind, planes) for name, (kind, planes, _) in _COLOURS.items()}
    | dict.fromkeys((*_PACKED, *_SEMIPLANAR), (np.uint8, 1))
)
_WINDOWS = {
    f'{bits}UC{channels}': (kind, channels)
    for bits, kind in ((8, np.uint8), (16, np.uint16)) for channels in (1, 2, 3, 4)
}
GLIMPSE_BYTES = 40  # of ten numbers, as a window's fourth channel has them
STEPS = 16  # of a DN, in which a window's third channel tells the noise that was added


def to_frame(image: Image, info: CameraInfo) -> Frame:
    """
    Return the frame that an image and its camera_info hold; the pixels are not copied.

    Parameters
    ----------
    image : Image
        mono8, mono16, 8UC1, 16UC1; rgb, bgr, rgba, bgra, bayer_rggb and the other orders, each of
        8 or 16 bits; yuv422 (uyvy), yuv422_yuy2 (yuyv), nv12, nv21 or nv24.
    info : CameraInfo
        Gives hardware crop and binning.

    Returns
    -------
    Frame
        With the stamp of the image; its pixels clip at full scale of the encoding.

    Raises
    ------
    MessageError
        If encoding, size, step or data are wrong, or the camera_info is that of another size;
        says which and what would be right.

    """
    return placed(to_whole_frame(image), info)


def to_window(image: Image, info: CameraInfo) -> Window:
    """
    Return the window that target/window/image_raw and its camera_info hold.

    Parameters
    ----------
    image : Image
        8UC2 or 16UC2, lit and unlit; 8UC1 or 16UC1, lit alone; 8UC3, 8UC4, 16UC3 or 16UC4 as
        `window_bytes` makes them.
    info : CameraInfo
        Its roi is the window's place on the sensor.

    Returns
    -------
    Window
        With the stamp of the image; its pixels clip at full scale of the encoding.

    Raises
    ------
    MessageError
        If encoding, size, step or data are wrong, or the camera_info is that of another
        window; says which and what would be right.

    """
    pixels = _pixels(image, _WINDOWS)
    binning = _check_region(int(image.width), int(image.height), info)
    full = FULL_SCALE_DN[pixels.dtype]
    several = pixels.ndim == 3
    unlit = pixels[..., 1] if several else None
    sites, added_noise, glimpse = None, 0.0, None
    if several and pixels.shape[2] > 2:
        assert unlit is not None
        unlit = None if (unlit == full).all() else unlit
        seen = pixels[..., 2] < full
        if not seen.any():
            raise MessageError('no pixel of the window sees the light: its third channel is full')
        sites = None if seen.all() else seen
        added_noise = float(pixels[..., 2][seen].max()) / STEPS
        if pixels.shape[2] > 3:
            glimpse = _glimpse(pixels[..., 3])
    return Window(
        lit=pixels[..., 0] if several else pixels,
        unlit=unlit,
        sites=sites,
        added_noise=added_noise,
        glimpse=glimpse,
        x0=int(info.roi.x_offset),
        y0=int(info.roi.y_offset),
        stamp_ns=stamp_of(image),
        saturation=full,
        binning=binning,
    )


def _glimpse(fourth: Pixels) -> Glimpse:
    """Return how a light was seen, from a window's fourth channel."""
    if fourth.size < GLIMPSE_BYTES or int(fourth.max()) > 255:
        raise MessageError('the fourth channel of the window holds no ten numbers, byte by byte')
    content = fourth.ravel()[:GLIMPSE_BYTES].astype(np.uint8).tobytes()
    glimpse = Glimpse.of_numbers(np.frombuffer(content, '<f4'))
    (xx, xy), (_, yy) = glimpse.doubt
    if not (
        np.isfinite(glimpse.numbers).all() and 0.0 <= glimpse.share <= 1.0
        and glimpse.way_sigma >= 0.0 and xx >= 0.0 and yy >= 0.0 and xy * xy <= 1.001 * xx * yy
    ):
        raise MessageError(
            'the fourth channel of the window describes no light: its share must be 0 to 1, its '
            'covariance that of a place'
        )
    return glimpse


def to_whole_frame(image: Image) -> Frame:
    """
    Return the frame of an image without its camera_info: as if it were of the whole sensor.

    Parameters
    ----------
    image : Image
        As of `to_frame`; of rclpy or of rosbags.

    Returns
    -------
    Frame
        With the stamp of the image.

    Raises
    ------
    MessageError
        If encoding, size, step or data are wrong; says which and what would be right.

    """
    pixels, layout = _coloured(image)
    full = FULL_SCALE_DN[pixels.dtype]
    return Frame(pixels, stamp_of(image), full, layout=layout)


def placed(frame: Frame, info: CameraInfo) -> Frame:
    """
    Return a frame with the hardware crop and binning of its camera_info.

    Raises
    ------
    MessageError
        If the camera_info is that of another size.

    """
    height, width = frame.image.shape[:2]
    binning = _check_region(width, height, info)
    x0, y0 = int(info.roi.x_offset), int(info.roi.y_offset)
    if (x0, y0, binning) == (frame.x0, frame.y0, frame.binning):
        return frame
    return replace(frame, x0=x0, y0=y0, binning=binning)


def sensor_of(info: CameraInfo) -> tuple[int, int]:
    """Return width and height of the full, unbinned sensor, px."""
    return int(info.width), int(info.height)


def from_frame(frame: Frame, frame_id: str, message: Image | None = None) -> Image:
    """Return the message of a frame, by its layout; arguments as those of `from_pixels`."""
    message = from_pixels(frame.image, frame.stamp_ns, frame_id, message)
    bits = 8 * frame.image.dtype.itemsize
    if frame.layout in BAYER:
        message.encoding = f'bayer_{frame.layout}{bits}'
    elif frame.layout != 'grey':
        message.encoding = f'{frame.layout}{bits}'
    return message


def from_pixels(
    pixels: NDArray[Any], stamp_ns: int, frame_id: str, message: Image | None = None
) -> Image:
    """
    Return the image message of pixels.

    Parameters
    ----------
    pixels : (h, w) or (h, w, n) array of uint8 or uint16
        DN; one channel becomes mono8 or mono16, n become 8UCn or 16UCn.
    stamp_ns : int
        Stamp, ns.
    frame_id : str
        Name of the optical frame.
    message : Image, optional
        A message to fill again: of the same size it saves the allocation.

    Returns
    -------
    Image
        The message that was given, or a new one.

    """
    if message is None:
        from sensor_msgs.msg import Image

        message = Image()
    bits = 8 * pixels.dtype.itemsize
    message.header.stamp = from_ns(stamp_ns)
    message.header.frame_id = frame_id
    message.height, message.width = pixels.shape[:2]
    message.encoding = f'mono{bits}' if pixels.ndim == 2 else f'{bits}UC{pixels.shape[2]}'
    message.is_bigendian = 0
    message.step = pixels.nbytes // pixels.shape[0]
    if len(message.data) != pixels.nbytes:
        message.data = array('B', bytes(pixels.nbytes))
    # Writing into the array in place is ten times faster than any assignment to the field.
    room = np.frombuffer(message.data, dtype=pixels.dtype).reshape(pixels.shape)
    room[...] = pixels
    return message


def window_bytes(window: Window, frame_id: str) -> bytes:
    """
    Return the message of a window, serialised: channel 0 lit, channel 1 unlit, raw DN.

    Where not all pixels see the light, or compression added noise, there is a channel 2: that
    noise in 1/16 DN, full scale in a pixel that does not see the light. Channel 1 is then at full
    scale if there is no unlit frame. Of a light that blinks and moves there is a channel 3 as
    well: `Glimpse.numbers`, byte by byte (little-endian), row by row, then zeros.
    """
    glimpse = window.glimpse if window.lit.size >= GLIMPSE_BYTES else None
    planes = [window.lit]
    if window.sites is not None or window.added_noise > 0.0 or glimpse is not None:
        full = FULL_SCALE_DN[window.lit.dtype]
        noise = min(round(STEPS * window.added_noise), full - 1)
        unlit = np.full_like(window.lit, full) if window.unlit is None else window.unlit
        seen = True if window.sites is None else window.sites
        third = np.where(np.broadcast_to(seen, window.lit.shape), noise, full)
        planes += [unlit, third.astype(window.lit.dtype)]
        if glimpse is not None:
            numbers = np.frombuffer(glimpse.numbers.astype('<f4').tobytes(), np.uint8)
            fourth = np.zeros(window.lit.size, window.lit.dtype)
            fourth[:GLIMPSE_BYTES] = numbers
            planes.append(fourth.reshape(window.lit.shape))
    elif window.unlit is not None:
        planes.append(window.unlit)
    pixels = np.empty((*window.lit.shape, len(planes)), window.lit.dtype)
    for channel, plane in enumerate(planes):
        pixels[..., channel] = plane
    encoding = f'{8 * pixels.dtype.itemsize}UC{len(planes)}'
    return serialised_image(window.stamp_ns, frame_id, encoding, pixels)


def from_picture(picture: NDArray[np.uint8], stamp_ns: int, frame_id: str) -> Image:
    """Return the message of a (h, w, 3) picture for people: bgr8."""
    image = from_pixels(picture, stamp_ns, frame_id)
    image.encoding = 'bgr8'
    return image


def stamp_of(image: Image | CompressedImage) -> int:
    """Return the stamp; one whose nanoseconds make seconds could not be sent on."""
    if image.header.stamp.nanosec >= SECOND_NS:
        raise MessageError(
            f'the nanoseconds of the stamp are {image.header.stamp.nanosec}; they must be below '
            f'{SECOND_NS}'
        )
    return to_ns(image.header.stamp)


def binning_of(info: CameraInfo) -> tuple[int, int]:
    """Return the binning; 0 means the same as 1 (sensor_msgs/CameraInfo)."""
    return max(int(info.binning_x), 1), max(int(info.binning_y), 1)


def _check_region(across: int, down: int, info: CameraInfo) -> tuple[int, int]:
    """Return the binning; refuse an image that is not the region that its camera_info has."""
    roi = info.roi
    # A roi of 0 x 0 is the whole sensor (sensor_msgs/RegionOfInterest).
    width, height = int(roi.width) or int(info.width), int(roi.height) or int(info.height)
    bin_x, bin_y = binning_of(info)
    if (across, down) != (width // bin_x, height // bin_y):
        raise MessageError(
            f'the image is {across} x {down} px and its camera_info is for '
            f'{width // bin_x} x {height // bin_y} px; calibrate at '
            f'{across} x {down} px'
        )
    if roi.x_offset + width > info.width or roi.y_offset + height > info.height:
        raise MessageError(
            f'camera_info: the roi of {width} x {height} px at ({roi.x_offset}, {roi.y_offset}) '
            f'does not lie within the sensor of {info.width} x {info.height} px'
        )
    return bin_x, bin_y


def _coloured(image: Image) -> tuple[Pixels, str]:
    """Return the pixels of a frame's image and their layout."""
    encoding = image.encoding.lower()
    if encoding in _PACKED:
        luma, order = _PACKED[encoding]
        pairs = _pixels(image, {image.encoding: (np.uint8, 2)})
        if image.width % 2:
            raise MessageError(f'{image.encoding} is {image.width} px wide; it must be even')
        chromas = pairs[..., 1 - luma].reshape(image.height, -1, 2)
        return _yuv(pairs[..., luma], chromas, order), 'yuv'
    if encoding in _SEMIPLANAR:
        order, shared = _SEMIPLANAR[encoding]
        if image.width % shared or image.height % shared:
            raise MessageError(
                f'{image.encoding} of {image.width} x {image.height} px; both must be even'
            )
        planes = image.height + 2 * image.height // shared**2
        rows = _pixels(image, {image.encoding: (np.uint8, 1)}, planes)
        chromas = rows[image.height:].reshape(image.height // shared, -1, 2)
        return _yuv(rows[:image.height], chromas, order), 'yuv'
    pixels = _pixels(image, _ENCODINGS)
    return pixels, _COLOURS[image.encoding][2] if image.encoding in _COLOURS else 'grey'


def _yuv(luma: Pixels, chromas: Pixels, order: str) -> Pixels:
    """Return (h, w, 3) Y, Cb, Cr: each chroma stands for the pixels that share it."""
    height, width = luma.shape
    shared = chromas[..., ::-1] if order == 'vu' else chromas
    wide = np.repeat(shared, height // shared.shape[0], axis=0)
    if shared.shape[1] < width:
        wide = np.repeat(wide, 2, axis=1)
    return np.dstack([luma, wide[:, :width]])


def _pixels(
    image: Image, encodings: Mapping[str, tuple[Any, int]], height: int = 0
) -> Pixels:
    """Return the (h, w) or (h, w, n) pixels of an image, in the machine's byte order."""
    if image.encoding not in encodings:
        raise MessageError(
            f"the encoding is {image.encoding!r:.40}; it must be {' or '.join(encodings)}"
        )
    if image.width == 0 or image.height == 0:
        raise MessageError(f'the image is {image.width} x {image.height} px; neither may be 0')
    kind, channels = encodings[image.encoding]
    dtype = np.dtype(kind).newbyteorder('>' if image.is_bigendian else '<')
    row = image.width * channels * dtype.itemsize
    if image.step < row:
        raise MessageError(
            f'step is {image.step} bytes; {image.width} px of {image.encoding} need {row}'
        )
    height = height or image.height  # of all planes
    if len(image.data) != image.step * height:
        raise MessageError(
            f'data has {len(image.data)} bytes; step * height is '
            f'{image.step} * {height} = {image.step * height}'
        )
    rows = np.frombuffer(image.data, dtype=np.uint8).reshape(height, image.step)
    # A copy where needed: rows of 16 bits that begin at odd bytes cannot be looked at in place.
    pixels = rows[:, :row]
    if image.step % dtype.itemsize:
        pixels = np.ascontiguousarray(pixels)
    pixels = pixels.view(dtype)
    if channels > 1:
        pixels = pixels.reshape(height, image.width, channels)
    return pixels if dtype.isnative else pixels.astype(kind)

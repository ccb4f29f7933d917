"""sensor_msgs/Image to frames and windows, and back, with every field checked."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import Any

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.stamp import from_ns, SECOND_NS, to_ns
from blob_tracker.types import Frame, Pixels, Window
import cv2
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image

# encoding: (type of a pixel, channels)
_FRAMES = {
    'mono8': (np.uint8, 1),
    '8UC1': (np.uint8, 1),
    'mono16': (np.uint16, 1),
    '16UC1': (np.uint16, 1),
}
_COLOURS = {  # and how OpenCV turns it into luma
    'rgb8': (np.uint8, 3, cv2.COLOR_RGB2GRAY),
    'bgr8': (np.uint8, 3, cv2.COLOR_BGR2GRAY),
    'rgba8': (np.uint8, 4, cv2.COLOR_RGBA2GRAY),
    'bgra8': (np.uint8, 4, cv2.COLOR_BGRA2GRAY),
}
_WINDOWS = {
    '8UC1': (np.uint8, 1),
    '8UC2': (np.uint8, 2),
    '16UC1': (np.uint16, 1),
    '16UC2': (np.uint16, 2),
}


def to_frame(image: Image, info: CameraInfo) -> Frame:
    """
    Return the frame that an image and its camera_info hold; the pixels are not copied.

    Parameters
    ----------
    image : Image
        mono8, mono16, 8UC1 or 16UC1.
    info : CameraInfo
        Gives hardware crop and binning.

    Returns
    -------
    Frame
        With the stamp of the image; its pixels clip at full scale of the encoding.

    Raises
    ------
    MessageError
        Where encoding, size, step or data are wrong, or the camera_info is that of another size;
        says which and what would be right.

    """
    pixels = _pixels(image, _FRAMES)
    _check_region(image, info)
    return Frame(
        image=pixels,
        stamp_ns=_stamp_ns(image),
        saturation=int(np.iinfo(pixels.dtype).max),
        x0=int(info.roi.x_offset),
        y0=int(info.roi.y_offset),
        binning=_binning(info),
    )


def to_window(image: Image, info: CameraInfo) -> Window:
    """
    Return the window that target/window/image_raw and its camera_info hold.

    Parameters
    ----------
    image : Image
        8UC2 or 16UC2, lit and unlit; 8UC1 or 16UC1, lit alone.
    info : CameraInfo
        Its roi is the window's place on the sensor.

    Returns
    -------
    Window
        With the stamp of the image; its pixels clip at full scale of the encoding.

    Raises
    ------
    MessageError
        Where encoding, size, step or data are wrong, or the camera_info is that of another
        window; says which and what would be right.

    """
    pixels = _pixels(image, _WINDOWS)
    _check_region(image, info)
    two = pixels.ndim == 3
    return Window(
        lit=pixels[..., 0] if two else pixels,
        unlit=pixels[..., 1] if two else None,
        x0=int(info.roi.x_offset),
        y0=int(info.roi.y_offset),
        stamp_ns=_stamp_ns(image),
        saturation=int(np.iinfo(pixels.dtype).max),
        binning=_binning(info),
    )


def to_pixels(image: Image) -> Pixels:
    """
    Return the pixels of an image without its camera_info, those of a colour camera as luma.

    Parameters
    ----------
    image : Image
        mono8, mono16, 8UC1, 16UC1, rgb8, bgr8, rgba8 or bgra8; of rclpy or of rosbags.

    Returns
    -------
    (h, w) array of uint8 or uint16
        Raw DN; luma where the image has colours.

    Raises
    ------
    MessageError
        Where encoding, size, step or data are wrong; says which and what would be right.

    """
    encodings = _FRAMES | {name: (kind, n) for name, (kind, n, _) in _COLOURS.items()}
    pixels = _pixels(image, encodings)
    if pixels.ndim == 2:
        return pixels
    return np.asarray(cv2.cvtColor(pixels, _COLOURS[image.encoding][2]), dtype=pixels.dtype)


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
    message = Image() if message is None else message
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


def from_window(window: Window, frame_id: str) -> Image:
    """Return the message of a window: channel 0 lit, channel 1 unlit, raw DN."""
    if window.unlit is None:
        image = from_pixels(window.lit, window.stamp_ns, frame_id)
        image.encoding = f'{8 * window.lit.dtype.itemsize}UC1'
        return image
    return from_pixels(np.dstack([window.lit, window.unlit]), window.stamp_ns, frame_id)


def from_picture(picture: NDArray[np.uint8], stamp_ns: int, frame_id: str) -> Image:
    """Return the message of a (h, w, 3) picture for people: bgr8."""
    image = from_pixels(picture, stamp_ns, frame_id)
    image.encoding = 'bgr8'
    return image


def _stamp_ns(image: Image) -> int:
    """Return the stamp; one whose nanoseconds make seconds could not be sent on."""
    if image.header.stamp.nanosec >= SECOND_NS:
        raise MessageError(
            f'the nanoseconds of the stamp are {image.header.stamp.nanosec}; they must be below '
            f'{SECOND_NS}'
        )
    return to_ns(image.header.stamp)


def _binning(info: CameraInfo) -> tuple[int, int]:
    """Return the binning; 0 means the same as 1 (sensor_msgs/CameraInfo)."""
    return max(int(info.binning_x), 1), max(int(info.binning_y), 1)


def _check_region(image: Image, info: CameraInfo) -> None:
    """Refuse an image that is not the region, binned, of which its camera_info speaks."""
    roi = info.roi
    # A roi of 0 x 0 is the whole sensor (sensor_msgs/RegionOfInterest).
    width, height = int(roi.width) or int(info.width), int(roi.height) or int(info.height)
    bin_x, bin_y = _binning(info)
    if (image.width, image.height) != (width // bin_x, height // bin_y):
        raise MessageError(
            f'the image is {image.width} x {image.height} px and its camera_info is for '
            f'{width // bin_x} x {height // bin_y} px; calibrate this size'
        )
    if roi.x_offset + width > info.width or roi.y_offset + height > info.height:
        raise MessageError(
            f'camera_info: the roi of {width} x {height} px at ({roi.x_offset}, {roi.y_offset}) '
            f'does not lie within the sensor of {info.width} x {info.height} px'
        )


def _pixels(image: Image, encodings: Mapping[str, tuple[Any, int]]) -> Pixels:
    """Return the (h, w) or (h, w, 2) pixels of an image, in the machine's byte order."""
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
    if len(image.data) != image.step * image.height:
        raise MessageError(
            f'data has {len(image.data)} bytes; step * height is '
            f'{image.step} * {image.height} = {image.step * image.height}'
        )
    rows = np.frombuffer(image.data, dtype=np.uint8).reshape(image.height, image.step)
    # A copy where needed: rows of 16 bits that begin at odd bytes cannot be looked at in place.
    pixels = np.require(rows[:, :row], requirements='C' if image.step % dtype.itemsize else None)
    pixels = pixels.view(dtype)
    if channels > 1:
        pixels = pixels.reshape(image.height, image.width, channels)
    return pixels if dtype.isnative else pixels.astype(kind)

"""
Messages as the middleware sends them: OMG's XCDR1, little-endian.

rclpy publishes bytes as they are. To fill a message with Python's numbers, and have rclpy turn
each into one of C again, takes several times as long as all else that is done to publish it.
"""

from __future__ import annotations

from functools import lru_cache
from struct import Struct

from blob_tracker.ros.messages.stamp import SECOND_NS
import numpy as np
from numpy.typing import NDArray

LITTLE_ENDIAN = b'\0\1\0\0'  # what a message begins with; places in it count from there
STAMP = Struct('<4siI')
STAMP_BYTES = 8
LENGTH, SIZE = Struct('<I'), Struct('<II')
TEXT_ALIGNMENT, NUMBER_ALIGNMENT = 4, 8  # bytes


def serialised(stamp_ns: int, texts: tuple[str, ...], numbers: list[float]) -> bytes:
    """
    Return a message.

    Parameters
    ----------
    stamp_ns : int
        Of its header, ns.
    texts : tuple of str
        The header's frame_id, and those that follow it.
    numbers : list of float
        All doubles, in the order of the message's definition.

    """
    return begin(stamp_ns) + _texts(texts) + _numbers(len(numbers)).pack(*numbers)


def serialised_image(
    stamp_ns: int, frame_id: str, encoding: str, pixels: NDArray[np.generic]
) -> bytes:
    """
    Return a sensor_msgs/Image.

    Parameters
    ----------
    stamp_ns : int
        Of its header, ns.
    frame_id, encoding : str
        As in the message.
    pixels : (h, w) or (h, w, n) array
        DN, in the machine's byte order, which is little-endian.

    """
    height, width = pixels.shape[:2]
    return begin(stamp_ns) + _image(
        frame_id, encoding, height, width, pixels.nbytes // height
    ) + pixels.tobytes()


def begin(stamp_ns: int) -> bytes:
    """Return what a message with a header begins with, to the end of its stamp, ns."""
    sec, nanosec = divmod(stamp_ns, SECOND_NS)
    return STAMP.pack(LITTLE_ENDIAN, sec, nanosec)


@lru_cache
def _texts(texts: tuple[str, ...]) -> bytes:
    """Return texts that follow a stamp, to where the first number is."""
    found = bytearray(STAMP_BYTES)
    for text in texts:
        _add_text(found, text)
    return bytes(found[STAMP_BYTES:]) + bytes(-len(found) % NUMBER_ALIGNMENT)


@lru_cache
def _image(frame_id: str, encoding: str, height: int, width: int, step: int) -> bytes:
    """Return what lies between the stamp of an image and its pixels."""
    found = bytearray(STAMP_BYTES)
    _add_text(found, frame_id)
    found += bytes(-len(found) % TEXT_ALIGNMENT) + SIZE.pack(height, width)
    _add_text(found, encoding)
    found += b'\0'  # it is not big-endian
    found += bytes(-len(found) % TEXT_ALIGNMENT) + SIZE.pack(step, step * height)
    return bytes(found[STAMP_BYTES:])


def _add_text(found: bytearray, text: str) -> None:
    content = text.encode() + b'\0'
    found += bytes(-len(found) % TEXT_ALIGNMENT) + LENGTH.pack(len(content)) + content


@lru_cache
def _numbers(count: int) -> Struct:
    return Struct(f'<{count}d')

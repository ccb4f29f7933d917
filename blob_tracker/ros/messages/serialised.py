"""
Messages of a header and numbers as the middleware sends them: OMG's XCDR1, little-endian.

rclpy publishes bytes as they are. To fill a message with Python's numbers, and have rclpy turn
each into one of C again, takes several times as long as all else that is done to publish it.
"""

from __future__ import annotations

from functools import lru_cache
from struct import Struct

from blob_tracker.ros.messages.stamp import SECOND_NS

LITTLE_ENDIAN = b'\0\1\0\0'  # what a message begins with; places in it count from there
STAMP = Struct('<4siI')
STAMP_BYTES = 8
LENGTH = Struct('<I')
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
    sec, nanosec = divmod(stamp_ns, SECOND_NS)
    begin = STAMP.pack(LITTLE_ENDIAN, sec, nanosec)
    return begin + _texts(texts) + _numbers(len(numbers)).pack(*numbers)


@lru_cache
def _texts(texts: tuple[str, ...]) -> bytes:
    """Return texts that follow a stamp, to where the first number is."""
    found = bytearray(STAMP_BYTES)
    for text in texts:
        found += bytes(-len(found) % TEXT_ALIGNMENT)
        content = text.encode() + b'\0'
        found += LENGTH.pack(len(content)) + content
    return bytes(found[STAMP_BYTES:]) + bytes(-len(found) % NUMBER_ALIGNMENT)


@lru_cache
def _numbers(count: int) -> Struct:
    return Struct(f'<{count}d')

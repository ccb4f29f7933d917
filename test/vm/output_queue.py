"""Runs in the guest: pictures handed to an output device in buffers that it has mapped."""

from __future__ import annotations

import ctypes
import mmap
from typing import Any

from blob_tracker.capture import videodev2

BUF_TYPE_VIDEO_OUTPUT = 2


class OutputQueue:
    """
    The buffers of an open output device, whose format is set.

    Parameters
    ----------
    fd : int
        The device.
    count : int
        Buffers to ask for.

    """

    def __init__(self, fd: int, count: int = 4) -> None:
        self._fd = fd
        request = videodev2.RequestBuffers(
            count=count, type=BUF_TYPE_VIDEO_OUTPUT, memory=videodev2.MEMORY_MMAP)
        videodev2.ioctl(fd, videodev2.REQBUFS, request)
        self._memory = []
        for index in range(request.count):
            buffer = _buffer(index=index)
            videodev2.ioctl(fd, videodev2.QUERYBUF, buffer)
            self._memory.append(mmap.mmap(fd, buffer.length, offset=buffer.m.offset))

    def __len__(self) -> int:
        return len(self._memory)

    def put(self, index: int, picture: bytes, stamp_ns: int = 0) -> None:
        """Hand over a picture in a buffer that the device does not have."""
        self._memory[index][:len(picture)] = picture
        buffer = _buffer(
            index=index, bytesused=len(picture), field=videodev2.FIELDS.index('none'))
        buffer.timestamp.tv_sec, nanoseconds = divmod(stamp_ns, 10**9)
        buffer.timestamp.tv_usec = nanoseconds // 1000
        videodev2.ioctl(self._fd, videodev2.QBUF, buffer)

    def start(self) -> None:
        """Have the device show what it has."""
        videodev2.ioctl(self._fd, videodev2.STREAMON, ctypes.c_int32(BUF_TYPE_VIDEO_OUTPUT))

    def take(self) -> videodev2.Buffer:
        """Wait for a buffer that was shown, and return it."""
        buffer = _buffer()
        videodev2.ioctl(self._fd, videodev2.DQBUF, buffer)
        return buffer

    def close(self) -> None:
        """Give the memory back."""
        for each in self._memory:
            each.close()


def _buffer(**fields: Any) -> videodev2.Buffer:
    return videodev2.Buffer(
        type=BUF_TYPE_VIDEO_OUTPUT, memory=videodev2.MEMORY_MMAP, **fields)

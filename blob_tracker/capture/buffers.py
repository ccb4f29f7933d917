"""The ring of buffers that a driver writes its frames into."""

from __future__ import annotations

import mmap

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Ioctl
from blob_tracker.capture.errors import CaptureError

RECENT_NS = 10_000_000_000  # ns: no other clock agrees with the monotonic one by so much


def map_buffers(
    call: Ioctl, fd: int, device: str, buffer_type: int, count: int,
    memory: list[mmap.mmap],
) -> int:
    """
    Map the driver's buffers into memory and hand them to it; return the flags that they have.

    Parameters
    ----------
    call : function
        Takes the number and the argument of an ioctl of the device.
    fd : int
        Its file descriptor.
    device : str
        What to call it.
    buffer_type : int
        Of its buffers.
    count : int
        How many to ask for; it may give others.
    memory : list of mmap
        Filled with those that are mapped, for the caller to close, whatever is raised.

    Raises
    ------
    CaptureError
        The driver has too little memory.
    OSError
        The device fails.

    """
    request = videodev2.RequestBuffers(
        count=count, type=buffer_type, memory=videodev2.MEMORY_MMAP)
    call(videodev2.REQBUFS, request)
    if request.count < 2:
        raise CaptureError(f'{device}: the driver has no memory for two buffers; choose '
                           'a smaller picture')
    for index in range(request.count):
        buffer = empty_buffer(buffer_type, index)
        call(videodev2.QUERYBUF, buffer)
        if buffer.type == videodev2.BUF_TYPE_VIDEO_CAPTURE_MPLANE:
            plane = buffer.m.planes[0]  # the luma, whatever the format
            length, offset = plane.length, plane.m.mem_offset
        else:
            length, offset = buffer.length, buffer.m.offset
        memory.append(mmap.mmap(fd, length, offset=offset))
        call(videodev2.QBUF, buffer)
    return int(buffer.flags)


def stamp_of(buffer: videodev2.Buffer, device: str, now_ns: int) -> int:
    """
    Return the driver's stamp of a filled buffer, monotonic ns.

    Some drivers do not say which clock a stamp is of, or hand on that of a program that writes
    into them (v4l2loopback, from frame to frame as the writer has it): such a stamp is taken for
    one of the monotonic clock where it is recent by it.

    Parameters
    ----------
    buffer : Buffer
        Filled.
    device : str
        What to call it.
    now_ns : int
        Monotonic, ns.

    Raises
    ------
    CaptureError
        The stamp is of another clock.

    """
    stamp_ns = told_stamp(buffer)
    clock = buffer.flags & videodev2.BUF_FLAG_TIMESTAMP_MASK
    if clock != videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC and not (
        -RECENT_NS < now_ns - stamp_ns < RECENT_NS
    ):
        raise CaptureError(
            f'{device}: its frames are not stamped with the monotonic clock, so that their time '
            'is unknown; use a driver that does, and have a program that writes into '
            'v4l2loopback leave the stamps to it')
    return stamp_ns


def told_stamp(buffer: videodev2.Buffer) -> int:
    """Return the driver's stamp of a filled buffer, ns of whichever clock."""
    return int(buffer.timestamp.tv_sec * 1_000_000_000 + buffer.timestamp.tv_usec * 1000)


def empty_buffer(buffer_type: int, index: int = 0) -> videodev2.Buffer:
    """Return a description of a buffer, for the driver to fill in."""
    buffer = videodev2.Buffer(
        index=index, type=buffer_type, memory=videodev2.MEMORY_MMAP)
    if buffer.type == videodev2.BUF_TYPE_VIDEO_CAPTURE_MPLANE:
        buffer.m.planes = (videodev2.Plane * videodev2.MAX_PLANES)()
        buffer.length = videodev2.MAX_PLANES
    return buffer

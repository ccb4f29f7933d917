"""The ring of buffers that a driver writes its frames into."""

from __future__ import annotations

import mmap

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Ioctl
from blob_tracker.capture.errors import CaptureError


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
        The driver has too little memory, or stamps frames with another clock.
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
    flags = buffer.flags
    if flags & videodev2.BUF_FLAG_TIMESTAMP_MASK != videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC:
        raise CaptureError(
            f'{device}: its driver does not stamp frames with the monotonic clock, so '
            'their time is unknown; use a driver that does')
    return int(flags)


def empty_buffer(buffer_type: int, index: int = 0) -> videodev2.Buffer:
    """Return a description of a buffer, for the driver to fill in."""
    buffer = videodev2.Buffer(
        index=index, type=buffer_type, memory=videodev2.MEMORY_MMAP)
    if buffer.type == videodev2.BUF_TYPE_VIDEO_CAPTURE_MPLANE:
        buffer.m.planes = (videodev2.Plane * videodev2.MAX_PLANES)()
        buffer.length = videodev2.MAX_PLANES
    return buffer

"""
Whether a webcam sends its own time, by the metadata of its driver.

With `hwtimestamps=1` uvcvideo stamps the start of the exposure from two times in the headers of
the packets: PTS, the camera's clock at that instant, and SCR, the same clock beside the counter of
the bus (USB Video Class 1.5, 2.4.3.3). Of a camera that leaves either out it stamps the first
data of a frame, as without the option, and no flag of a buffer tells. The metadata node beside the
video device has the headers (V4L2_META_FMT_UVC).
"""

from __future__ import annotations

import ctypes
import mmap
import os
from pathlib import Path

from blob_tracker.capture import videodev2
from blob_tracker.capture.buffers import empty_buffer, map_buffers
from blob_tracker.capture.device import capabilities
from blob_tracker.capture.errors import CaptureError

BEFORE_HEADER = 10  # bytes of a block: ns of the host, and the number of the bus' frame
HAS_PTS, HAS_SCR = 1 << 2, 1 << 3
PICTURES = 3  # that are looked at; the first one may have begun before
BUFFERS = 4
CHARACTER_DEVICES = Path('/sys/dev/char')


def sends_time(metadata: bytes) -> bool:
    """
    Tell whether a header has both times.

    Parameters
    ----------
    metadata : bytes
        Of one picture, in blocks: 8 bytes of host time, 2 of the bus' frame number, and a header
        that begins with its length and its flags. Headers of two bytes are left out by the driver.

    """
    at = BEFORE_HEADER
    while at + 2 <= len(metadata):
        length, flags = metadata[at], metadata[at + 1]
        if flags & HAS_PTS and flags & HAS_SCR:
            return True
        at += BEFORE_HEADER + max(length, 2)
    return False


class UvcClock:
    """
    Reads the metadata of a webcam that streams, until it is known whether it sends its time.

    Parameters
    ----------
    fd : int
        The video device, open.

    Attributes
    ----------
    told : bool or None
        Whether it does; None while, or where, that is not known.

    """

    def __init__(self, fd: int) -> None:
        self.told: bool | None = None
        self._seen = 0
        self._memory: list[mmap.mmap] = []
        self._fd = -1
        try:
            self._fd = _metadata_node(fd)
            if self._fd >= 0:
                map_buffers(
                    self._call, self._fd, '', videodev2.BUF_TYPE_META_CAPTURE, BUFFERS,
                    self._memory)
                self._call(
                    videodev2.STREAMON, ctypes.c_int32(videodev2.BUF_TYPE_META_CAPTURE))
        except (OSError, CaptureError):  # another program has it
            self.close()

    def look(self) -> None:
        """Read what has come."""
        while self._fd >= 0 and self.told is None:
            buffer = empty_buffer(videodev2.BUF_TYPE_META_CAPTURE)
            try:
                self._call(videodev2.DQBUF, buffer)
                metadata = self._memory[buffer.index][:buffer.bytesused]
                self._call(videodev2.QBUF, buffer)
            except BlockingIOError:
                return
            except OSError:
                self.close()
                return
            self._seen += 1
            if sends_time(metadata):
                self.told = True
            elif self._seen >= PICTURES:
                self.told = False
        if self.told is not None:
            self.close()

    def close(self) -> None:
        """Give the node back; a second time does nothing."""
        for memory in self._memory:
            memory.close()
        self._memory.clear()
        if self._fd >= 0:
            os.close(self._fd)  # which ends its stream
            self._fd = -1

    def _call(self, number: int, argument: object) -> None:
        videodev2.ioctl(self._fd, number, argument)


def _metadata_node(fd: int) -> int:
    """Return the metadata node of a video device, open; -1 if there is none."""
    number = os.fstat(fd).st_rdev
    own = CHARACTER_DEVICES / f'{os.major(number)}:{os.minor(number)}'
    name = (own / 'uevent').read_text().split('DEVNAME=')[1].split()[0]
    nodes = {
        int(each.name.removeprefix('video')): each.name
        for each in (own / 'device' / 'video4linux').iterdir()
        if each.name.removeprefix('video').isdecimal()
    }
    # That of the device comes right after it.
    for index in sorted(each for each in nodes if each > int(name.removeprefix('video'))):
        node = os.open(f'/dev/{nodes[index]}', os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        if capabilities(node)[0] & videodev2.CAP_META_CAPTURE:
            return node
        os.close(node)
        break
    return -1

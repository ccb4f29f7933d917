"""A V4L2 driver in memory: what `V4l2Camera` asks of the kernel, answered by the test."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
import errno
import os
from pathlib import Path
from typing import Any

from blob_tracker.capture import v4l2, videodev2
import pytest

NUMBERS = {
    value: name for name, value in vars(videodev2).items()
    if name.isupper() and isinstance(value, int) and value >> 8 & 0xff == ord('V')
}


class Driver:
    """
    A capture device.

    Parameters
    ----------
    formats : sequence of str
        Pixel formats that it offers; it is left at the first.
    size : (int, int)
        The one size that it has, px.
    field : str
        That of its pictures, whatever is asked for.
    standard : int
        v4l2_std_id of its input; 0 has none.
    rate : float
        Pictures/s that it tells; 0 tells none.
    errors : mapping of str to int
        Name of an ioctl -> errno with which it fails.
    name : str
        Of the driver.
    flags : int
        Of its buffers.

    Attributes
    ----------
    filled : list of (int, int, str, bytes)
        Buffers to come: stamp in monotonic ns, sequence, field, and what is in them.
    asked : list of (str, argument)
        The ioctls of importance that came.

    """

    def __init__(
        self,
        *,
        formats: Iterable[str] = ('GREY',),
        size: tuple[int, int] = (8, 8),
        field: str = 'none',
        standard: int = 0,
        rate: float = 0.0,
        errors: dict[str, int] | None = None,
        name: str = 'made up',
        flags: int = videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC,
    ) -> None:
        self.formats, self.size, self.field = list(formats), size, field
        self.standard, self.rate, self.errors = standard, rate, errors or {}
        self.name, self.flags = name, flags
        self.filled: list[tuple[int, int, str, bytes]] = []
        self.asked: list[str] = []
        self._fd = -1
        self._free: list[int] = []

    @contextmanager
    def at(self, path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
        """Be the driver of a device, whose memory is a file."""
        path.write_bytes(bytes(32 * self.length))

        def opened(device: str) -> int:
            self._fd = os.open(device, os.O_RDWR)
            return self._fd

        with monkeypatch.context() as patch:
            patch.setattr(v4l2, 'open_capture_device', opened)
            patch.setattr(videodev2, 'ioctl', self)
            yield str(path)

    @property
    def length(self) -> int:
        """Return the bytes of a buffer: whole pages."""
        return -(-2 * self.size[0] * self.size[1] // 4096) * 4096

    def __call__(self, fd: int, number: int, argument: Any) -> None:
        name = NUMBERS[number]
        self.asked.append(name)
        if name in self.errors:
            raise OSError(self.errors[name], os.strerror(self.errors[name]))
        answer = getattr(self, f'_{name.lower()}', None)
        if answer is None:
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
        answer(argument)

    def _querycap(self, argument: Any) -> None:
        argument.driver = self.name.encode()
        argument.capabilities = videodev2.CAP_VIDEO_CAPTURE | videodev2.CAP_STREAMING

    def _g_input(self, argument: Any) -> None:
        argument.value = 0

    def _enuminput(self, argument: Any) -> None:
        argument.name, argument.std = b'Composite', self.standard

    def _g_std(self, argument: Any) -> None:
        argument.value = self.standard

    def _s_std(self, argument: Any) -> None:
        self.standard = argument.value

    def _enum_fmt(self, argument: Any) -> None:
        if argument.index >= len(self.formats):
            raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))
        argument.pixelformat = videodev2.fourcc(self.formats[argument.index])

    def _g_fmt(self, argument: Any) -> None:
        pix = argument.pix
        pix.width, pix.height = self.size
        pix.pixelformat = pix.pixelformat or videodev2.fourcc((*self.formats, 'GREY')[0])
        pix.bytesperline = 0
        pix.sizeimage = self.length
        pix.field = videodev2.FIELDS.index(self.field)

    _s_fmt = _g_fmt

    def _g_parm(self, argument: Any) -> None:
        argument.capability = videodev2.CAP_TIMEPERFRAME
        argument.timeperframe.numerator = 1001 if self.rate else 0
        argument.timeperframe.denominator = round(1001 * self.rate)

    def _s_parm(self, argument: Any) -> None:
        self.rate = argument.timeperframe.denominator / argument.timeperframe.numerator

    def _reqbufs(self, argument: Any) -> None:
        self._free = []

    def _querybuf(self, argument: Any) -> None:
        argument.length, argument.flags = self.length, self.flags
        argument.m.offset = argument.index * self.length

    def _qbuf(self, argument: Any) -> None:
        argument.flags = self.flags
        self._free.append(argument.index)

    def _streamon(self, argument: Any) -> None:
        pass

    _streamoff = _streamon

    def _dqbuf(self, argument: Any) -> None:
        assert self.filled, 'the camera reads more than there is'
        stamp_ns, argument.sequence, field, content = self.filled.pop(0)
        argument.index = self._free.pop(0)
        argument.bytesused, argument.flags = len(content), self.flags
        argument.field = videodev2.FIELDS.index(field)
        seconds, rest = divmod(stamp_ns, 1_000_000_000)
        argument.timestamp.tv_sec, argument.timestamp.tv_usec = seconds, rest // 1000
        os.pwrite(self._fd, content, argument.index * self.length)

"""The ring of buffers of a camera that streams: waited for, taken and handed back."""

from __future__ import annotations

from collections.abc import Callable
import ctypes
import errno
import mmap
import select
import time

from blob_tracker.capture import videodev2
from blob_tracker.capture.buffers import empty_buffer, map_buffers
from blob_tracker.capture.controls import Ioctl
from blob_tracker.capture.errors import CaptureError, NoFrameError
from blob_tracker.capture.refusals import unplugged


class Ring:
    """
    The buffers of a device, from before it streams to its end.

    Parameters
    ----------
    call : function
        Takes the number and the argument of an ioctl of the device.
    fd : int
        Its file descriptor.
    device : str
        What to call it.
    trouble : function
        Returns ': ' and why the camera has gone quiet, or ''.

    Attributes
    ----------
    memory : list of mmap
        What each holds.
    streaming : bool
        Whether the driver fills them.

    """

    def __init__(self, call: Ioctl, fd: int, device: str, trouble: Callable[[], str]) -> None:
        self.memory: list[mmap.mmap] = []
        self.streaming = False
        self._call = call
        self._fd = fd
        self._device = device
        self._trouble = trouble
        self._type = 0
        self._poll = select.poll()
        self._poll.register(fd, select.POLLIN)

    def __len__(self) -> int:
        return len(self.memory)

    def map_in(self, buffer_type: int, count: int) -> int:
        """Map buffers of a type, about so many, and return the flags that they have."""
        self._type = buffer_type
        return map_buffers(
            self._call, self._fd, self._device, buffer_type, count, self.memory)

    def start(self) -> None:
        """Let the driver fill them."""
        self._call(videodev2.STREAMON, ctypes.c_int32(self._type))
        self.streaming = True

    def close(self) -> None:
        """Stop the driver and unmap them; a second time does nothing."""
        try:
            if self.streaming:
                self._call(videodev2.STREAMOFF, ctypes.c_int32(self._type))
        except OSError:
            pass  # unplugged: there is nothing left to stop
        finally:
            self.streaming = False
            for memory in self.memory:
                memory.close()
            self.memory.clear()

    def take(self) -> videodev2.Buffer | None:
        """
        Return the oldest buffer that the driver has filled, None if there is none.

        Raises
        ------
        CaptureError
            The device is gone or has stopped.

        """
        buffer = empty_buffer(self._type)
        try:
            self._call(videodev2.DQBUF, buffer)
        except BlockingIOError:
            return None
        except OSError as error:
            raise self.lost(error) from error
        return buffer

    def filled(self, buffer: videodev2.Buffer) -> memoryview:
        """Return what the driver wrote into a buffer; release it before the ring is closed."""
        begin, end = 0, buffer.bytesused
        if buffer.type == videodev2.BUF_TYPE_VIDEO_CAPTURE_MPLANE:
            begin, end = buffer.m.planes[0].data_offset, buffer.m.planes[0].bytesused
        return memoryview(self.memory[buffer.index])[begin:end]

    def give_back(self, buffer: videodev2.Buffer) -> None:
        """
        Let the driver fill a buffer again.

        Raises
        ------
        CaptureError
            It does not take it.

        """
        try:
            self._call(videodev2.QBUF, buffer)
        except OSError as error:
            if error.errno in (errno.ENODEV, errno.EIO):
                raise self.lost(error) from error
            raise CaptureError(f'{self._device}: the driver does not take a buffer back: '
                               f'{error.strerror}; open it again') from error

    def wait(self, deadline: float, timeout: float, spoilt: int) -> None:
        """
        Wait until a buffer may have been filled.

        Parameters
        ----------
        deadline : float
            Monotonic, s.
        timeout : float
            How long has been waited by then, s.
        spoilt : int
            Pictures that came meanwhile and were of no use.

        Raises
        ------
        NoFrameError
            None was filled in time.
        CaptureError
            The driver has stopped.

        """
        ready = self._poll.poll(max(0.0, deadline - time.monotonic()) * 1e3)
        if not ready:
            what = f'no frame for {timeout:.1f} s'
            if spoilt:
                pictures = '1 picture' if spoilt == 1 else f'{spoilt} pictures'
                what = f'{pictures} came, all spoilt or cut short'
            raise NoFrameError(f'{self._device}: {what}{self._trouble()}')
        if not ready[0][1] & select.POLLIN:
            # An error alone; a driver that knows its number gives it with the next buffer.
            self.take()
            raise CaptureError(f'{self._device}: the driver stopped streaming'
                               f'{self._trouble()}; open it again')

    def lost(self, error: OSError) -> CaptureError:
        """Return what an error of a device that streams means."""
        if error.errno == errno.ENODEV:
            return CaptureError(unplugged(self._device))
        return CaptureError(
            f'{self._device}: the driver stopped streaming: {error.strerror}'
            f'{self._trouble()}; open it again')

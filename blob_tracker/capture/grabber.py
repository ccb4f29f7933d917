"""A thread that reads a camera, and hands over the newest frame."""

from __future__ import annotations

from collections import deque
import threading
import time
from types import TracebackType

from blob_tracker.capture.errors import CaptureError, NoFrameError
from blob_tracker.capture.v4l2 import V4l2Camera
from blob_tracker.types import Frame

READ_TIMEOUT_S = 0.5  # s: the longest that the end of the grabber waits for its thread


class Grabber:
    """
    Reads a camera in a thread of its own; close it or use it in a `with`.

    The thread and the reader share one slot: a frame that nobody took is replaced by the next and
    counted in `overruns`. It holds both fields of an interlaced picture, which come together, and
    gives the older one first. So a reader that stalls finds a new frame, and the driver's ring
    never runs full. A frame that waited for longer than the ring is long, as the driver went quiet
    after it, is an overrun too. The reader is woken by the frame itself.

    A flash is seen in the difference of neighbours, which the reader tells by their stamps: a
    reader that is a little too slow loses single frames, and the pairs that they belong to. One
    that takes as long as two frames gets every second one, and of a light that flashes at half
    the frame rate it never sees a pair: `overruns` that keep growing say so.

    Parameters
    ----------
    camera : V4l2Camera
        Open. It stays its owner's, who closes it after the grabber.

    Attributes
    ----------
    overruns : int
        Frames that a newer one replaced before they were taken.

    Examples
    --------
    The newest frame, however slow its reader is:

    >>> with V4l2Camera('/dev/video0') as camera, Grabber(camera) as grabber:  # doctest: +SKIP
    ...     frame = grabber.newest(timeout=1.0)
    ...     print(frame.image.shape, grabber.overruns)
    (480, 640) 0

    """

    def __init__(self, camera: V4l2Camera) -> None:
        self.overruns = 0
        self._camera = camera
        self._slot: deque[Frame] = deque(maxlen=camera.fields.per_buffer)
        self._filled_at = 0.0
        self._error: BaseException | None = None
        self._silence: NoFrameError | None = None
        self._changed = threading.Condition()
        self._stop = False
        self._thread = threading.Thread(target=self._run, name='capture', daemon=True)
        self._thread.start()

    def __enter__(self) -> Grabber:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def drops(self) -> int:
        """Return the frames that the driver lost."""
        return self._camera.drops

    def newest(self, timeout: float = 1.0) -> Frame:
        """
        Return the newest frame, each one once; wait for it for `timeout` seconds at most.

        Raises
        ------
        NoFrameError
            No frame came in time; try again.
        CaptureError
            What ended the capture thread; the camera has to be opened again.

        """
        with self._changed:
            if self._slot and self._stale():
                self.overruns += len(self._slot)
                self._slot.clear()
            self._changed.wait_for(self._something, timeout)
            if self._stop:
                raise CaptureError(f'{self._camera.device}: the grabber is closed')
            if self._slot:
                return self._slot.popleft()
            if self._error is not None:
                raise self._error
            raise self._silence or NoFrameError(
                f'{self._camera.device}: no frame for {timeout:.1f} s')

    def close(self) -> None:
        """End the thread; a second time does nothing."""
        with self._changed:
            self._stop = True
            self._changed.notify_all()
        self._thread.join()

    def _something(self) -> bool:
        return bool(self._slot) or self._error is not None or self._stop

    def _stale(self) -> bool:
        return 0.0 < self._camera.longest_wait < time.monotonic() - self._filled_at

    def _run(self) -> None:
        """Fill the slot until the grabber is closed or the camera fails."""
        while not self._stop:
            try:
                frame = self._camera.read(READ_TIMEOUT_S)
            except NoFrameError as error:
                self._silence = error
                continue
            except BaseException as error:  # the reader's to handle: this thread has nobody
                with self._changed:
                    self._error = error
                    self._changed.notify_all()
                return
            with self._changed:
                self._silence = None
                if len(self._slot) == self._slot.maxlen:
                    self.overruns += 1
                self._slot.append(frame)
                self._filled_at = time.monotonic()
                self._changed.notify_all()

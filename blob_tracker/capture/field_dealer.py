"""The pictures of a stream, dealt out as frames that wait to be read."""

from __future__ import annotations

from collections import deque
import time

from blob_tracker.capture.fields import fields, FieldStream
from blob_tracker.types import Frame

UNKNOWN_PICTURE_RATE = 25.0  # pictures/s, of interlaced ones whose driver tells none


class FieldDealer:
    """
    Give the fields of each picture their times, and keep them until they are read.

    Parameters
    ----------
    stream : FieldStream
        What buffers hold of a picture.
    stamps_end : bool
        Whether the driver stamps the end of a transfer, which is that of the second field.

    Attributes
    ----------
    waiting : deque of Frame
        Frames of the last buffer that nobody has read yet, in the order of time.
    passed_over : int
        Fields that were read and were too old when they were asked for.

    """

    def __init__(self, stream: FieldStream, *, stamps_end: bool) -> None:
        self.passed_over = 0
        self._stream = stream
        self._stamps_end = stamps_end
        self.waiting: deque[Frame] = deque()
        self._last_ns = 0  # of the second field of a picture, monotonic

    def drop_old(self, longest_wait: float) -> None:
        """Pass over the frames that have waited for more than so many s; 0 is for ever."""
        age = (time.monotonic_ns() - self._last_ns) / 1e9
        if self.waiting and 0.0 < longest_wait < age:
            self.passed_over += len(self.waiting)
            self.waiting.clear()

    def first_field_ns(self, middle_ns: int, frame_rate: float) -> int:
        """
        Return the middle of the exposure of the field that was taken first, monotonic ns.

        Parameters
        ----------
        middle_ns : int
            That of a buffer by its stamp, monotonic ns.
        frame_rate : float
            Frames/s, of interlaced pictures fields/s; 0 where it is not known.

        """
        if self._stream.per_buffer == 2:
            field_ns = self._field_ns(frame_rate)
            if self._stamps_end:
                middle_ns -= field_ns
            # A transfer's end may be noticed late: the fields keep their order.
            middle_ns = max(middle_ns, self._last_ns + 1)
            self._last_ns = middle_ns + field_ns
        return middle_ns

    def deal(self, picture: Frame, field: int, frame_rate: float) -> None:
        """
        Let the frames in a buffer wait.

        Parameters
        ----------
        picture : Frame
            All of the buffer; its stamp is that of the first field.
        field : int
            What the driver calls it.
        frame_rate : float
            As of `first_field_ns`.

        Raises
        ------
        ValueError
            Fields alternate and the driver does not say which this is.

        """
        if not self._stream.interlaced:
            self.waiting.append(picture)
            return
        order = self._stream.order(field)
        self.waiting.extend(fields(picture, order, 2 * self._field_ns(frame_rate)))

    def _field_ns(self, frame_rate: float) -> int:
        """Return how long a field takes, ns."""
        return round(0.5e9 / (frame_rate / self._stream.per_picture or UNKNOWN_PICTURE_RATE))

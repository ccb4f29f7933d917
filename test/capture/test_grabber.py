"""The capture thread: the newest frame wins, errors arrive, it always ends."""

import os
import select
import threading
import time

from blob_tracker.capture import CaptureError, Grabber, NoFrameError
from blob_tracker.capture.fields import FieldStream
from blob_tracker.types import Frame
import numpy as np
import pytest
from support.slowness import slowness


class PipeCamera:
    """A camera whose frames come through a pipe: a byte is a frame of that brightness."""

    device = '/dev/pipe'

    def __init__(self):
        self.out, self.into = os.pipe()
        self.drops = 0
        self.longest_wait = 0.0
        self.fields = FieldStream('none', 2)
        self.taken = threading.Semaphore(0)

    def read(self, timeout):
        if not select.select([self.out], [], [], timeout)[0]:
            raise NoFrameError(f'{self.device}: no frame for {timeout:.1f} s: no signal')
        byte = os.read(self.out, 1)
        self.taken.release()
        if not byte:
            raise CaptureError(f'{self.device}: the device is gone (unplugged?)')
        return Frame(np.full((2, 2), byte[0], np.uint8), byte[0], 255)

    def send(self, *frames):
        """Send frames and wait until the capture thread has them."""
        os.write(self.into, bytes(frames))
        for _ in frames:
            assert self.taken.acquire(timeout=10.0 * slowness())

    def unplug(self):
        os.close(self.into)
        self.into = -1

    def close(self):
        for fd in (self.out, self.into):
            if fd >= 0:
                os.close(fd)


@pytest.fixture
def camera():
    camera = PipeCamera()
    yield camera
    camera.close()


def settled(grabber, overruns):
    """Wait until so many frames were replaced."""
    deadline = time.monotonic() + 10.0 * slowness()
    while grabber.overruns < overruns:
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_frames_come_in_order_each_once(camera):
    with Grabber(camera) as grabber:
        for value in range(1, 50):
            camera.send(value)
            assert grabber.newest(10.0).stamp_ns == value
        assert grabber.overruns == 0
        with pytest.raises(NoFrameError):
            grabber.newest(0.0)


def test_both_fields_of_a_picture_wait_for_the_reader(camera):
    # They come together; of two pictures the newer one is kept.
    camera.fields = FieldStream('interlaced', 480)
    with Grabber(camera) as grabber:
        camera.send(1, 2)
        assert [grabber.newest(10.0).stamp_ns for _ in range(2)] == [1, 2]
        assert grabber.overruns == 0
        camera.send(3, 4, 5, 6)
        settled(grabber, 2)
        assert [grabber.newest(10.0).stamp_ns for _ in range(2)] == [5, 6]


def test_the_newest_frame_wins_and_the_others_are_counted(camera):
    with Grabber(camera) as grabber:
        camera.send(1, 2, 3, 4, 5)
        settled(grabber, 4)
        assert grabber.newest(10.0).stamp_ns == 5
        assert grabber.overruns == 4


def test_a_reader_that_waits_is_woken(camera):
    with Grabber(camera) as grabber:
        later = threading.Timer(0.05, camera.send, (7,))
        later.start()
        assert grabber.newest(10.0).stamp_ns == 7
        later.join()


def test_a_frame_that_waited_too_long_is_not_handed_over(camera):
    camera.longest_wait = 0.02
    with Grabber(camera) as grabber:
        camera.send(1)
        deadline = time.monotonic() + 10.0 * slowness()
        while grabber._slot is None:
            assert time.monotonic() < deadline
            time.sleep(0.001)
        time.sleep(0.05)
        with pytest.raises(NoFrameError):
            grabber.newest(0.0)
        assert grabber.overruns == 1


def test_silence_is_told_with_its_reason_and_ends_nothing(camera, monkeypatch):
    monkeypatch.setattr('blob_tracker.capture.grabber.READ_TIMEOUT_S', 0.01)
    with Grabber(camera) as grabber:
        with pytest.raises(NoFrameError, match='/dev/pipe: no frame for 0.0 s: no signal'):
            grabber.newest(0.2)
        camera.send(9)
        assert grabber.newest(10.0).stamp_ns == 9


def test_what_ends_the_thread_is_raised_after_the_last_frame_and_again(camera):
    with Grabber(camera) as grabber:
        camera.send(3)
        camera.unplug()
        grabber._thread.join(10.0)
        assert grabber.newest(10.0).stamp_ns == 3
        for _ in range(2):
            with pytest.raises(CaptureError, match='/dev/pipe: the device is gone'):
                grabber.newest(10.0)
    assert not grabber._thread.is_alive()


def test_an_error_of_any_kind_reaches_the_reader(camera):
    def broken(timeout):
        raise ZeroDivisionError('a defect')

    camera.read = broken
    with Grabber(camera) as grabber, pytest.raises(ZeroDivisionError, match='a defect'):
        grabber.newest(10.0)


def test_closing_ends_the_thread_and_wakes_the_reader(camera):
    grabber = Grabber(camera)
    threading.Timer(0.05, grabber.close).start()
    with pytest.raises(CaptureError, match='/dev/pipe: the grabber is closed'):
        grabber.newest(10.0)
    grabber.close()
    assert not grabber._thread.is_alive()

"""Buffers are taken, handed back and given up with the device."""

from __future__ import annotations

from collections.abc import Iterator
import errno
from pathlib import Path
import time

from blob_tracker.capture import CaptureError, NoFrameError, videodev2
from blob_tracker.capture.ring import Ring
import pytest
from support.v4l2_driver import Driver

TROUBLE = ': the cable is loose'


@pytest.fixture
def driver() -> Driver:
    """Give a driver that has nothing yet."""
    return Driver()


@pytest.fixture
def ring(driver: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Ring]:
    """Give its buffers, which it fills."""
    with driver.at(tmp_path / 'video0', monkeypatch) as device, open(device, 'r+b') as file:
        driver._fd = file.fileno()
        made = Ring(
            lambda number, argument: driver(file.fileno(), number, argument), file.fileno(),
            device, lambda: TROUBLE)
        made.map_in(videodev2.BUF_TYPE_VIDEO_CAPTURE, 2)
        made.start()
        yield made
        made.close()


def test_a_buffer_holds_what_was_written_and_is_filled_again(driver: Driver, ring: Ring) -> None:
    """In the order of the ring, as much as the driver says."""
    assert len(ring) == 2 and ring.streaming
    for index in range(5):
        driver.filled = [(0, index, 'none', bytes([index, 7]))]
        buffer = ring.take()
        assert buffer is not None and buffer.index == index % 2
        with ring.filled(buffer) as content:
            assert content.tobytes() == bytes([index, 7])
        ring.give_back(buffer)


def test_closed_it_has_no_memory_and_the_driver_has_stopped(driver: Driver, ring: Ring) -> None:
    """Once, however often it is closed; a device that is gone need not be stopped."""
    driver.errors['STREAMOFF'] = errno.ENODEV
    ring.close()
    ring.close()
    assert not ring.streaming and len(ring) == 0
    assert driver.asked.count('STREAMOFF') == 1


@pytest.mark.parametrize(('error', 'words'), [
    (errno.ENODEV, 'the device is gone'),
    (errno.EIO, f'the driver stopped streaming: Input/output error{TROUBLE}; open it again'),
])
def test_a_device_that_fails_is_told(
    driver: Driver, ring: Ring, error: int, words: str
) -> None:
    """Whether a buffer is taken or handed back."""
    driver.filled = [(0, 0, 'none', b'')]
    buffer = ring.take()
    driver.errors.update(DQBUF=error, QBUF=error)
    with pytest.raises(CaptureError, match=words):
        ring.take()
    with pytest.raises(CaptureError, match=words):
        ring.give_back(buffer)


def test_a_buffer_that_is_not_taken_back_is_told(driver: Driver, ring: Ring) -> None:
    """The device may be sound, but this ring is not."""
    driver.errors['QBUF'] = errno.EINVAL
    with pytest.raises(CaptureError, match='does not take a buffer back: Invalid argument; open'):
        ring.give_back(videodev2.Buffer())


def test_time_that_runs_out_is_told(ring: Ring, monkeypatch: pytest.MonkeyPatch) -> None:
    """With what came meanwhile, and with what is wrong."""
    class Nothing:
        @staticmethod
        def poll(timeout: float) -> list[tuple[int, int]]:
            return []

    monkeypatch.setattr(ring, '_poll', Nothing)
    with pytest.raises(NoFrameError, match=f'no frame for 0.5 s{TROUBLE}$'):
        ring.wait(time.monotonic(), 0.5, 0)
    with pytest.raises(NoFrameError, match='2 pictures came, all spoilt or cut short'):
        ring.wait(time.monotonic(), 0.5, 2)

"""What a webcam's headers tell of its clock."""

from __future__ import annotations

import errno
import os
from pathlib import Path
import struct
import time

from blob_tracker.capture import stamps, uvc_clock, V4l2Camera, videodev2
from blob_tracker.capture.uvc_clock import sends_time, UvcClock
import pytest
from support.v4l2_driver import Driver

PTS, SCR = 4, 8


def block(flags: int) -> bytes:
    """Return the metadata of one header, as include/uapi/linux/uvcvideo.h has it."""
    times = (struct.pack('<I', 77) if flags & PTS else b'') + (
        struct.pack('<IH', 78, 5) if flags & SCR else b'')
    return struct.pack('<QHBB', 10**9, 5, 2 + len(times), 0x80 | flags) + times


@pytest.mark.parametrize(('flags', 'told'), [
    ((), False), ((0,), False), ((PTS,), False), ((SCR, SCR), False), ((PTS | SCR,), True),
    ((0, SCR, PTS, PTS | SCR), True),
])
def test_both_times_must_be_in_a_header(flags: tuple[int, ...], told: bool) -> None:
    """Of any packet of the picture."""
    assert sends_time(b''.join(map(block, flags))) is told


def test_what_is_cut_short_or_senseless_ends() -> None:
    """A length of 0, half a block."""
    whole = block(PTS | SCR)
    assert not sends_time(whole[:11])
    assert not sends_time(bytes(500))


@pytest.mark.parametrize(('pictures', 'told', 'words'), [
    ([b'', b'', b''], False, 'end of the exposure'),
    ([b'', block(PTS | SCR)], True, 'start of the exposure'),
])
def test_the_stamps_are_what_the_metadata_tell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pictures: list[bytes], told: bool, words: str,
) -> None:
    """With hwtimestamps=1, whose flag tells nothing."""
    node, option = tmp_path / 'video1', tmp_path / 'hwtimestamps'
    node.write_bytes(bytes(32 * 4096))
    option.write_text('1\n')
    monkeypatch.setattr(stamps, 'HARDWARE_STAMPS', option)
    monkeypatch.setattr(uvc_clock, '_metadata_node', lambda fd: os.open(node, os.O_RDWR))
    start_of_exposure = videodev2.BUF_FLAG_TSTAMP_SRC_SOE | videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC
    driver = Driver(name='uvcvideo', flags=start_of_exposure)
    metadata = Driver()
    metadata.filled = [(1, index, 'none', each) for index, each in enumerate(pictures)]

    def kernel(fd: int, number: int, argument: object) -> None:
        if os.readlink(f'/proc/self/fd/{fd}') != str(node):
            driver(fd, number, argument)
        elif number == videodev2.DQBUF and not metadata.filled:
            raise BlockingIOError(errno.EAGAIN, 'nothing yet')
        else:
            metadata._fd = fd
            metadata(fd, number, argument)

    before = os.listdir('/proc/self/fd')
    # Undone before the driver's own.
    with driver.at(tmp_path / 'video0', monkeypatch) as device, monkeypatch.context() as patch:
        patch.setattr(videodev2, 'ioctl', kernel)
        with V4l2Camera(device) as camera:
            assert 'if the camera sends its own time' in camera.stamp_place
            driver.filled = [(time.monotonic_ns(), 0, 'none', bytes(64))]
            camera.read()
            assert camera.stamp_place.split(',')[0] == words
            assert 'if the camera' not in camera.stamp_place
    assert os.listdir('/proc/self/fd') == before


def test_without_a_metadata_node_nothing_is_told(tmp_path: Path) -> None:
    """As of a device that is none."""
    with open(tmp_path / 'video0', 'wb') as file:
        clock = UvcClock(file.fileno())
        clock.look()
        assert clock.told is None
        clock.close()

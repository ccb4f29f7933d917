"""Each errno of a step has its sentence with a remedy."""

from __future__ import annotations

import errno
import os
import time
from typing import Any

from blob_tracker.capture import CaptureError, NoFrameError, V4l2Camera, videodev2
from blob_tracker.capture.refusals import LOOPBACK, refusal, Step
import pytest
from support.v4l2_driver import Driver

STEPS = {'settings': 'S_FMT', 'buffers': 'REQBUFS', 'stream': 'STREAMON'}
CASES: list[tuple[Step, int, str]] = [
    ('settings', errno.EBUSY, 'streams from it, or has chosen its format and keeps it open; end'),
    ('settings', errno.EINVAL, '--list-formats-ext'),
    ('settings', errno.EIO, 'the camera does not answer (Input/output error); plug it in again'),
    ('buffers', errno.EBUSY, 'another program streams from it; end that program'),
    ('buffers', errno.ENOMEM, 'lower width, height or buffers'),
    ('stream', errno.ENOSPC, 'no bandwidth left, which another camera on the same hub'),
    ('stream', errno.EPIPE, "'media-ctl -p' shows them: set the format of each pad"),
    ('stream', errno.ENOLINK, 'no sensor is linked to it; enable the link with media-ctl'),
    ('stream', errno.EINVAL, 'the driver refuses to begin with these settings; raise buffers'),
    ('stream', errno.EIO, 'there is no signal, or the camera does not answer'),
    ('stream', errno.EBUSY, 'another program streams from it; end that program'),
    ('stream', errno.EREMOTEIO, 'the camera does not answer (Remote I/O error)'),
    ('stream', errno.ENODEV, 'the device is gone (unplugged?)'),
    ('stream', errno.EDOM, 'the driver does not begin to stream: Numerical argument out of'),
]


@pytest.mark.parametrize(('step', 'code', 'words'), CASES)
def test_what_fails_is_named_with_the_remedy(tmp_path, monkeypatch, step, code, words):
    driver = Driver(errors={STEPS[step]: code})
    before = os.listdir('/proc/self/fd')
    with driver.at(tmp_path / 'video0', monkeypatch) as device:
        with pytest.raises(CaptureError) as error:
            V4l2Camera(device)
    text = str(error.value)
    assert text.startswith(f'{device}: ') and words in text
    assert '\n' not in text and '{' not in text
    assert os.listdir('/proc/self/fd') == before


def test_no_sentence_is_of_two_errors():
    found: dict[str, Any] = {}
    for step, code, _ in CASES:
        text = refusal('video', 'uvcvideo', step, OSError(code, os.strerror(code)))
        assert found.setdefault(text, code) == code
    # A holder of the device that has chosen a format alone does not stream.
    assert found[refusal('video', '', 'settings', OSError(errno.EBUSY, ''))] == errno.EBUSY


# --- v4l2loopback ---


@pytest.mark.parametrize(('number', 'code'), [
    ('G_FMT', errno.EINVAL), ('STREAMON', errno.EIO), ('STREAMON', errno.ENODATA),
    ('STREAMON', errno.EAGAIN),
])
def test_a_loopback_without_a_writer_says_so(tmp_path, monkeypatch, number, code):
    driver = Driver(name=LOOPBACK, errors={number: code})
    with driver.at(tmp_path / 'video0', monkeypatch) as device:
        with pytest.raises(CaptureError, match='no program writes pictures into this v4l2loop'):
            V4l2Camera(device)


@pytest.mark.parametrize(('driver', 'words'), [
    (Driver(name=LOOPBACK, formats=()), 'it offers no pixel format at all: there is no signal'),
    (Driver(name=LOOPBACK, size=(0, 0)), 'pictures of 0x0: there is no signal, or no program'),
])
def test_a_loopback_without_a_format_says_so(tmp_path, monkeypatch, driver, words):
    with driver.at(tmp_path / 'video0', monkeypatch) as device:
        with pytest.raises(CaptureError, match=words):
            V4l2Camera(device, pixel_format='GREY' if driver.formats else '')


@pytest.mark.parametrize('clock', [0x0000, 0x2000, 0x4000])  # not told, monotonic, the writer's
def test_a_loopback_is_read_whatever_it_says_of_its_clock(tmp_path, monkeypatch, clock):
    # 0.12 says nothing, and 0.13 that of the writer, which may be another from frame to frame.
    driver = Driver(name=LOOPBACK, flags=clock)
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(device) as camera:
        driver.filled = [(time.monotonic_ns(), 0, 'none', bytes(64))]
        assert abs(camera.read().stamp_ns - time.time_ns()) < 1e9
        driver.filled = [(7 * 10**9, 1, 'none', bytes(64))]  # since the writer's start
        if clock == videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC:
            driver.filled[0] = (time.monotonic_ns(), 1, 'none', bytes(64))
            camera.read()
        else:
            with pytest.raises(CaptureError, match='its frames are not stamped with the mono'):
                camera.read()


def test_a_writer_that_has_gone_is_told(tmp_path, monkeypatch):
    driver = Driver(name=LOOPBACK)
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(device) as camera:
        class Nothing:
            @staticmethod
            def poll(timeout: float) -> list[Any]:
                return []

        monkeypatch.setattr(camera._ring, '_poll', Nothing)
        monkeypatch.setattr(camera._ring, 'take', lambda: None)
        with pytest.raises(NoFrameError, match='writes into this v4l2loopback device has stopped'):
            camera.read(0.01)

"""Controls of a device that may be gone, or closed by another thread."""

from __future__ import annotations

import errno
import os
from typing import Any

from blob_tracker.capture import CaptureError, ControlError
from blob_tracker.capture.device_controls import DeviceControls
import pytest


def silent(number: int, argument: Any) -> None:
    """Stand in for a driver without controls."""
    raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))


def test_a_control_that_there_is_not_is_told_with_those_that_there_are() -> None:
    """None, of this device."""
    with pytest.raises(ControlError, match="no control 'gain'; the controls of /dev/v are none"):
        DeviceControls('/dev/v', silent).named('gain')


@pytest.mark.parametrize(('number', 'words'), [
    (errno.ENODEV, 'the device is gone'), (errno.EIO, 'its controls cannot be queried'),
])
def test_what_the_device_refuses_is_said(number: int, words: str) -> None:
    """By what was wrong."""
    def fail() -> None:
        raise OSError(number, os.strerror(number))

    with pytest.raises(CaptureError, match=words):
        DeviceControls('/dev/v', silent).guarded(fail)


def test_nothing_is_done_after_it_was_closed() -> None:
    """With a sentence."""
    found = DeviceControls('/dev/v', silent)
    assert found.guarded(lambda: 5) == 5
    with found.lock:
        found.close()
    with pytest.raises(CaptureError, match='/dev/v: the camera is closed; open it again'):
        found.guarded(lambda: 5)

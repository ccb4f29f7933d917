"""Where pixels clip, and how many frames they sum: what parameters add to messages."""

from __future__ import annotations

from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.clipping import clipping_frame, clipping_window
from blob_tracker.types import Frame, Window
import numpy as np
import pytest

PIXELS = np.zeros((4, 5), np.uint16)


def test_0_is_full_scale_whatever_the_driver_knew() -> None:
    """In memory and by message the same: what the driver knows is in no message."""
    frame = Frame(PIXELS, 0, saturation=4095)
    assert clipping_frame(frame, 0).saturation == 65535
    assert clipping_frame(frame, 1023).saturation == 1023
    window = Window(PIXELS.astype(np.uint8), saturation=None)
    assert clipping_window(window, 0, 1).saturation == 255


def test_what_the_pixels_cannot_reach_is_full_scale() -> None:
    """A saturation of 12 bits would switch the check off for 8."""
    frame = Frame(PIXELS.astype(np.uint8), 0, saturation=255)
    assert clipping_frame(frame, 4095).saturation == 255
    assert clipping_window(Window(frame.image), 4095, 1).saturation == 255


def test_a_sum_clips_at_full_scale() -> None:
    """Its clipped pixels were put there when it was summed."""
    window = clipping_window(Window(PIXELS), 4095, 5)
    assert (window.saturation, window.looks) == (65535, 5)
    assert clipping_window(Window(PIXELS), 4095, 1).saturation == 4095


def test_8_bits_are_no_sum() -> None:
    """The segmenter sums into 16."""
    with pytest.raises(MessageError, match='8 bits is one frame and no sum of 5'):
        clipping_window(Window(PIXELS.astype(np.uint8)), 0, 5)


def test_a_sum_of_other_looks_is_refused() -> None:
    """Where it is known: one look is what every window from a message seems to be."""
    window = Window(PIXELS, looks=5)
    for looks in (1, 4):
        with pytest.raises(MessageError, match=f'5 frames and looks is {looks}; .* to 5'):
            clipping_window(window, 0, looks)
    assert clipping_window(window, 0, 5).looks == 5

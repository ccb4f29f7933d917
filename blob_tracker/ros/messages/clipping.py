"""What no message says of pixels: where they clip, and of how many frames they are the sum."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.ros.errors import MessageError
from blob_tracker.types import Frame, FULL_SCALE_DN, Window
import numpy as np


def clipping_frame(frame: Frame, saturation: int) -> Frame:
    """
    Return a frame whose pixels clip where a parameter says.

    Parameters
    ----------
    frame : Frame
        From a message or handed over in memory: both get the same, so that both give the same.
    saturation : int
        DN of a clipped pixel; 0, or what the pixels' type does not reach, is its full scale.

    """
    full = FULL_SCALE_DN[frame.image.dtype]
    saturation = min(saturation or full, full)
    return frame if frame.saturation == saturation else replace(frame, saturation=saturation)


def clipping_window(window: Window, saturation: int, looks: int) -> Window:
    """
    Return a window whose pixels clip, and are sums of looks, as parameters say.

    Parameters
    ----------
    window : Window
        From a message or handed over in memory.
    saturation : int
        DN of a clipped pixel; 0, or what the pixels' type does not reach, is its full scale,
        which it always is of a sum.
    looks : int
        Frames that are summed in it.

    Raises
    ------
    MessageError
        If 8 bits cannot be a sum, or the window is known to be one of other looks.

    """
    full = FULL_SCALE_DN[window.lit.dtype]
    if looks > 1 and window.lit.dtype == np.uint8:
        raise MessageError(
            f'a window of 8 bits is one frame and no sum of {looks}; set looks as the segmenter '
            'has it'
        )
    # No message says it: a window from one seems to be of one look.
    if window.looks > 1 and window.looks != looks:
        raise MessageError(
            f'the window is a sum of {window.looks} frames and looks is {looks}; set looks of the '
            f'locator to {window.looks}'
        )
    saturation = full if looks > 1 else min(saturation or full, full)
    if (window.saturation, window.looks) == (saturation, looks):
        return window
    return replace(window, saturation=saturation, looks=looks)

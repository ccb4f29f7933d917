"""Light -> Frame: where pictures come from."""

from blob_tracker.capture.controls import Control, ControlError
from blob_tracker.capture.errors import CaptureError, NoFrameError
from blob_tracker.capture.grabber import Grabber
from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.v4l2 import V4l2Camera

__all__ = [
    'CaptureError', 'Control', 'ControlError', 'Grabber', 'NoFrameError', 'PIXEL_FORMATS',
    'V4l2Camera',
]

"""Light -> Frame: where pictures come from."""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from blob_tracker.capture.controls import Control, ControlError
    from blob_tracker.capture.errors import CaptureError, NoFrameError
    from blob_tracker.capture.grabber import Grabber
    from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
    from blob_tracker.capture.v4l2 import V4l2Camera

__all__ = [
    'CaptureError', 'Control', 'ControlError', 'Grabber', 'NoFrameError', 'PIXEL_FORMATS',
    'V4l2Camera',
]
_FILES = {
    'CaptureError': 'errors', 'Control': 'controls', 'ControlError': 'controls',
    'Grabber': 'grabber', 'NoFrameError': 'errors', 'PIXEL_FORMATS': 'pixel_formats',
    'V4l2Camera': 'v4l2',
}


def __getattr__(name: str) -> Any:
    """Import a name when it is first used: who reads a JPEG need not load V4L2."""
    if name not in _FILES:
        raise AttributeError(f"module 'blob_tracker.capture' has no attribute '{name}'")
    return getattr(import_module(f'blob_tracker.capture.{_FILES[name]}'), name)

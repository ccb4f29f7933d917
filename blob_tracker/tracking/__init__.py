"""Bearing ... -> Track: filtered over time, and predicted to the instant the servo moves."""

from blob_tracker.tracking.errors import PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.models import MODELS
from blob_tracker.tracking.pan_tilt_angles import PanTiltAngles
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.track import Track
from blob_tracker.tracking.tracker import compile_ahead, Tracker

__all__ = [
    'MODELS', 'PanTiltAngles', 'PlatformGap', 'PlatformRates', 'StampJump', 'Track', 'Tracker',
    'TrackingError', 'compile_ahead',
]

"""
Bearing ... -> Track: filtered over time, and predicted to the instant the servo moves.

And -> Position: where the bearings of several cameras meet.
"""

from blob_tracker.tracking.errors import PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.models import MODELS
from blob_tracker.tracking.pan_tilt_angles import PanTiltAngles
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.restart import update_or_restart
from blob_tracker.tracking.simultaneous import Simultaneous
from blob_tracker.tracking.track import Track
from blob_tracker.tracking.tracker import compile_ahead, Tracker
from blob_tracker.tracking.triangulation import (
    CameraPose, ParallelRays, Position, RaysApart, triangulate, TriangulationError,
)

__all__ = [
    'CameraPose', 'MODELS', 'PanTiltAngles', 'ParallelRays', 'PlatformGap', 'PlatformRates',
    'Position', 'RaysApart', 'Simultaneous', 'StampJump', 'Track', 'Tracker', 'TrackingError',
    'TriangulationError', 'compile_ahead', 'triangulate', 'update_or_restart',
]

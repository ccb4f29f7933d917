"""
Bearing ... -> Track: filtered over time, and predicted to the instant the servo moves.

And -> Position: where the bearings of several cameras meet.
"""

from blob_tracker.tracking.camera_pose import CameraPose
from blob_tracker.tracking.compilation import compile_ahead
from blob_tracker.tracking.errors import (
    ParallelRays, PlatformGap, RaysApart, StampJump, TrackingError, TriangulationError,
)
from blob_tracker.tracking.gyro_fit import GyroFault
from blob_tracker.tracking.gyro_watch import GyroWatch
from blob_tracker.tracking.models import MODELS
from blob_tracker.tracking.pan_tilt import PanTilt
from blob_tracker.tracking.pan_tilt_angles import PanTiltAngles
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.restart import update_or_restart
from blob_tracker.tracking.sight import Sight
from blob_tracker.tracking.simultaneous import Instant, Simultaneous
from blob_tracker.tracking.track import Track
from blob_tracker.tracking.tracker import Tracker
from blob_tracker.tracking.triangulation import Position, triangulate

__all__ = [
    'CameraPose', 'GyroFault', 'GyroWatch', 'Instant', 'MODELS', 'PanTilt', 'PanTiltAngles',
    'ParallelRays', 'PlatformGap', 'PlatformRates', 'Position', 'RaysApart', 'Sight',
    'Simultaneous', 'StampJump',
    'Track', 'Tracker', 'TrackingError', 'TriangulationError', 'compile_ahead', 'triangulate',
    'update_or_restart',
]

"""The filter's loops, compiled before they are needed."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.tracking.gyro_watch import GyroWatch
from blob_tracker.tracking.hypothesis import CONFIRMING
from blob_tracker.tracking.models import MODELS
from blob_tracker.tracking.pan_tilt_angles import PanTiltAngles
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.rotation import from_vector
from blob_tracker.tracking.tracker import Tracker
from blob_tracker.types import Bearing
import numpy as np

FRAME_NS = 10_000_000


def compile_ahead() -> None:
    """Compile the filter's loops, or load them from Numba's cache, before they are needed."""
    for model in MODELS:
        platform, pan_tilt = PlatformRates(), PanTiltAngles()
        tracker = Tracker(model, platform=platform, pan_tilt=pan_tilt)
        first = Bearing(0.0, 0.0, np.eye(2))
        ahead_ns = FRAME_NS * CONFIRMING
        for stamp in range(0, ahead_ns, FRAME_NS):
            platform.push(stamp, np.zeros(3))
            pan_tilt.push(stamp, 0.0, 0.0)
            tracker.update(replace(first, stamp_ns=stamp))
        tracker.at(ahead_ns)
        tracker.seen_at(ahead_ns)
        platform.reset()  # the rates that it leaves
        tracker.at(ahead_ns)
    watch = GyroWatch()
    watch.saw('', first, None)
    watch.saw('', replace(first, stamp_ns=FRAME_NS), pan_tilt)
    from_vector(0.0, 0.0, 0.0)  # the watch calls it once there is enough to judge by

"""After `compile_ahead` no bearing waits for a compiler."""

from __future__ import annotations

from support.late_kernels import run_alone

RIDES = """
from contextlib import suppress
from itertools import product
import numpy as np
from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import (
    compile_ahead, GyroWatch, MODELS, PanTiltAngles, PlatformRates, Tracker, TrackingError,
)
from blob_tracker.types import Bearing
from support.consistency import of_rays
from support.late_kernels import late_kernels

compile_ahead()
ride = MOTIONS['rover'].ride(9.0, seed=1)
times = np.arange(0.0, 8.0, 0.01)
rates, rotations = ride.rates(times), ride.rotations(times)
late = late_kernels()
for model, rides in product(MODELS, (False, True)):
    platform, pan_tilt = (PlatformRates(), PanTiltAngles()) if rides else (None, None)
    tracker, watch = Tracker(model, platform=platform, pan_tilt=pan_tilt), GyroWatch()
    for index, (time, rate, rotation) in enumerate(zip(times, rates, rotations)):
        stamp_ns = 10**18 + round(1e9 * time)
        watch.push(stamp_ns, -rate)
        if rides:
            platform.push(stamp_ns, rate, 1e-8)
            pan_tilt.push(stamp_ns, 0.1 * np.sin(time), 0.0)
        if index % 4:
            continue
        azimuth, elevation = of_rays(rotation[None, 2])[0].tolist()
        azimuth += 300.0 * (index % 80 == 0)
        bearing = Bearing(azimuth, elevation, 1e-4 * np.eye(2), stamp_ns)
        watch.saw('', bearing, pan_tilt)
        with suppress(TrackingError):
            tracker.update(bearing)
        tracker.at(stamp_ns + 30_000_000), tracker.seen_at(stamp_ns)
    watch.judge()
assert not late, late
"""


def test_compile_ahead_leaves_nothing_to_compile() -> None:
    """With and without a gyro and joints, and for what the gyro is judged by: in a process."""
    run_alone(RIDES)

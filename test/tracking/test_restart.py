"""A measurement from before all that is remembered restarts what takes it, once."""

from __future__ import annotations

from blob_tracker.tracking import (
    PlatformRates, StampJump, Tracker, TrackingError, update_or_restart,
)
from blob_tracker.types import Bearing
import numpy as np
import pytest

SECOND = 10**9  # ns


def bearing(stamp_ns: int, azimuth: float = 0.0) -> Bearing:
    """Return a bearing."""
    return Bearing(azimuth, 0.0, 1e-4 * np.eye(2), stamp_ns)


def test_a_jump_restarts_a_tracker() -> None:
    """It is told of the jump, reset, and has the bearing as its first one."""
    tracker, jumps = Tracker(), []

    def restart(jump: StampJump) -> None:
        jumps.append(str(jump))
        tracker.reset()

    for stamp_ns in (100 * SECOND, 100 * SECOND + 1000, SECOND):
        update_or_restart(lambda: tracker.update(bearing(stamp_ns)), restart)
    assert tracker.stamp_ns == SECOND
    assert len(jumps) == 1 and 'before the newest one' in jumps[0]


def test_a_jump_restarts_the_rates_of_a_platform() -> None:
    """Rates of another time are none."""
    rates = PlatformRates()
    for stamp_ns in (100 * SECOND, SECOND):
        update_or_restart(lambda: rates.push(stamp_ns, np.zeros(3)), lambda _: rates.reset())
    rates.push(SECOND + 1000, np.zeros(3))


def test_what_is_refused_restarts_nothing() -> None:
    """Before a restart, and after it, the reason is passed on."""
    tracker = Tracker()
    tracker.update(bearing(100 * SECOND))
    with pytest.raises(TrackingError, match='there is a bearing with the stamp'):
        update_or_restart(lambda: tracker.update(bearing(100 * SECOND)), pytest.fail)
    assert tracker.stamp_ns == 100 * SECOND
    with pytest.raises(TrackingError):
        update_or_restart(
            lambda: tracker.update(bearing(SECOND, float('nan'))), lambda _: tracker.reset()
        )

"""Bearings of a target that moves evenly, and a tracker that is fed with them."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.tracking import Track, Tracker, TrackingError
from blob_tracker.types import Bearing
import numpy as np

MS = 1_000_000  # ns
FRAME = 33 * MS
COVARIANCE = 0.01 * np.eye(2)


def steady(count: int, *, rate: float = 50.0, first: int = 0) -> list[Bearing]:
    """Return bearings to the right at a rate in mrad/s, without noise."""
    return [
        Bearing(rate * 1e-9 * stamp, 0.0, COVARIANCE, stamp)
        for stamp in range(first * FRAME, (first + count) * FRAME, FRAME)
    ]


def fed(tracker: Tracker, bearings: Sequence[Bearing]) -> list[str]:
    """Give bearings to a tracker; return why each was refused, empty where it was not."""
    reasons = []
    for bearing in bearings:
        try:
            tracker.update(bearing)
            reasons.append('')
        except TrackingError as error:
            reasons.append(str(error))
    return reasons


def present(track: Track | None) -> Track:
    """Return a track that must be there."""
    assert track is not None
    return track

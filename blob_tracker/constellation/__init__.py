"""Bearings of a body's lights -> Pose: where it is and how it is turned, from one camera."""

from blob_tracker.constellation.body import Body, read_body
from blob_tracker.constellation.errors import (
    BodyError, ConstellationError, Inconsistent, TooFewLights,
)
from blob_tracker.constellation.pose import Pose, poses

__all__ = [
    'Body', 'BodyError', 'ConstellationError', 'Inconsistent', 'Pose', 'TooFewLights', 'poses',
    'read_body',
]

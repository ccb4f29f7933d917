"""Bearings of a body's lights -> Pose: where it is and how it is turned, from one camera."""

from blob_tracker.constellation.assignment import Assigned, assigned, Assignment
from blob_tracker.constellation.body import Body, read_body, write_body
from blob_tracker.constellation.compilation import compile_ahead
from blob_tracker.constellation.errors import (
    BodyError, ConstellationError, Inconsistent, TooFewLights,
)
from blob_tracker.constellation.following import Following
from blob_tracker.constellation.pose import Pose, pose_near, poses
from blob_tracker.constellation.sighting import Sighting

__all__ = [
    'Assigned', 'assigned', 'Assignment', 'Body', 'BodyError', 'ConstellationError', 'Following',
    'Inconsistent', 'Pose', 'Sighting', 'TooFewLights', 'compile_ahead', 'pose_near', 'poses',
    'read_body', 'write_body',
]

"""The loops of the fit, compiled before they are needed."""

from __future__ import annotations

from contextlib import suppress
from math import atan2, hypot

from blob_tracker.constellation.assignment import assigned
from blob_tracker.constellation.body import Body
from blob_tracker.constellation.errors import Inconsistent
from blob_tracker.constellation.pose import pose_near, poses
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np

DISTANCE_M = 2.0


def compile_ahead() -> None:
    """Compile the loops of the fit, or load them from Numba's cache, before they are needed."""
    names = ('a', 'b', 'c', 'd')
    places = np.array([[0.3, 0.2, 0.0], [0.3, -0.2, 0.1], [-0.3, 0.0, 0.0], [-0.1, 0.1, 0.3]])
    bearings = [
        Bearing(
            atan2(x, z + DISTANCE_M) / MRAD, atan2(-y, hypot(x, z + DISTANCE_M)) / MRAD,
            np.eye(2), stamp_ns,
        )
        for stamp_ns, (x, y, z) in enumerate(places.tolist())
    ]
    body = Body(names, places, np.zeros(len(names)))
    seen = list(zip(names, bearings, strict=True))
    for pose in poses(body, seen):
        pose_near(body, seen, pose.rotation, pose.position)
    with suppress(Inconsistent):  # two names are exchanged
        poses(body, list(zip('bacd', bearings, strict=True)))
    assigned(body, bearings)

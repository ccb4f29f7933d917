"""The loops of the fit, compiled before they are needed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from math import atan2, hypot

from blob_tracker.constellation.assignment import assigned, named_by
from blob_tracker.constellation.body import Body
from blob_tracker.constellation.errors import Inconsistent
from blob_tracker.constellation.following import Following
from blob_tracker.constellation.pose import Pose, poses
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np

DISTANCE_M = 2.0
STEP_NS = 33_333_333
SIGHTINGS = 3  # from the third on it is known how the body moves


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
    pose = followed(body, bearings)[0]
    with suppress(Inconsistent):  # where other lights are seen, exchanged names are looked for
        poses(body, list(zip(('b', 'a', 'c', 'd'), bearings, strict=True)))
    assigned(body, bearings)
    named_by(body, bearings, pose)


def followed(body: Body, bearings: Sequence[Bearing]) -> list[Pose]:
    """Return the poses that are left once a body that is at rest was seen some times."""
    following = Following(body)
    found = []
    for number in range(SIGHTINGS):
        found = following.take([
            (name, replace(each, stamp_ns=each.stamp_ns + number * STEP_NS))
            for name, each in zip(body.names, bearings, strict=True)
        ])
    return found

"""After `compile_ahead` no bearing waits for a compiler."""

from __future__ import annotations

import os
import subprocess
import sys

SIGHTS = """
from contextlib import suppress

from blob_tracker import kernel
from blob_tracker.constellation import (
    Body, compile_ahead, ConstellationError, pose_near, poses,
)
from blob_tracker.constellation.assignment import assigned
from blob_tracker.types import Bearing
import numpy as np

compile_ahead()
late, missed = [], kernel._Kernel.missed


def noted(each, *arguments, **named):
    late.append(each.py_func.__qualname__)
    return missed(each, *arguments, **named)


kernel._Kernel.missed = noted
random = np.random.default_rng(1)
lights = np.array([
    [0.2, 0.15, 0.0], [0.2, -0.15, 0.02], [-0.25, 0.1, 0.1], [-0.2, -0.1, -0.05], [0.0, 0.0, 0.2],
    [0.1, 0.2, 0.1],
])
names = ('a', 'b', 'c', 'd', 'e', 'f')
for count in (3, 4, 5, 6):
    for flat in (False, True):
        places = lights[:count] * [1.0, 1.0, 0.0 if flat else 1.0]
        body = Body(names[:count], places, np.full(count, 1e-4))
        for distance in (1.0, 30.0):
            for step_ns in (0, 1_000_000):
                for off, order in ((0.0, names), (20.0, names), (0.0, ('b', 'a', *names[2:]))):
                    x, y, z = (places + [0.2, 0.1, distance]).T
                    azimuths = 1e3 * np.arctan2(x, z) + random.normal(0.0, 0.1, count)
                    azimuths[0] += off
                    elevations = -1e3 * np.arctan2(y, np.hypot(x, z))
                    bearings = [
                        Bearing(*angles, 0.01 * np.eye(2), 10**9 + step_ns * index)
                        for index, angles in enumerate(zip(azimuths, elevations))
                    ]
                    seen = list(zip(order, bearings))
                    with suppress(ConstellationError):
                        poses(body, seen)
                    for odd in (False, True):
                        with suppress(ConstellationError):
                            pose_near(body, seen, np.eye(3), np.array([0.2, 0.1, distance]),
                                      odd=odd)
                    with suppress(ConstellationError):
                        assigned(body, bearings)
assert not late, late
"""


def test_compile_ahead_leaves_nothing_to_compile() -> None:
    """For few lights and many, of one instant or not, odd ones and such with others' names."""
    environment = os.environ | {'PYTHONPATH': os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, '-c', SIGHTS], check=True, env=environment)

"""After `compile_ahead` no bearing waits for a compiler."""

from __future__ import annotations

from typing import Any

from blob_tracker.constellation import compilation, Pose
from blob_tracker.constellation.compilation import compile_ahead, followed
import pytest
from support.late_kernels import run_alone

SIGHTINGS = """
from contextlib import suppress
from dataclasses import replace
import sys
import numpy as np
from blob_tracker.constellation import (
    Assignment, Body, compile_ahead, ConstellationError, Following,
)
from blob_tracker.kernel import compiled
from blob_tracker.types import Bearing
from support.late_kernels import late_kernels

compile_ahead()
done, count, _ = compiled('blob_tracker.constellation')
assert done == count
loaded = set(sys.modules)
late = late_kernels()
random = np.random.default_rng(1)
places = np.array([
    [0.2, 0.15, 0.0], [0.2, -0.15, 0.02], [-0.25, 0.1, 0.1], [-0.2, -0.1, -0.05], [0.0, 0.0, 0.2],
])
body = Body(('a', 'b', 'c', 'd', 'e'), places, np.zeros(5))
x, y, z = (places + [0.5, -0.3, 2.0]).T
angles = 1e3 * np.array([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))]).T
for apart_ns in (0, 1_000_000):
    following, assignment = Following(body), Assignment(body, 0.5)
    for index in range(24):
        odd = [[20.0, 0.0]] if index % 4 == 3 else [[0.0, 0.0]]
        seen = random.normal(angles, 0.1) + odd * (np.arange(5) == 0)[:, np.newaxis]
        bearings = [
            Bearing(*each, 0.01 * np.eye(2), 10**18 + index * 20_000_000 + light * apart_ns)
            for light, each in enumerate(seen)
        ][:3 if index % 8 == 6 else 5]
        with suppress(ConstellationError):
            following.take(list(zip(body.names, bearings)))
        with suppress(ConstellationError):
            assignment.name(bearings)
assert not late, late
assert set(sys.modules) == loaded
"""


def test_the_bearings_of_compile_ahead_have_one_pose(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that all of the fit has run, and is compiled."""
    found = []

    def kept(*arguments: Any) -> list[Pose]:
        found.extend(followed(*arguments))
        return found

    monkeypatch.setattr(compilation, 'followed', kept)
    compile_ahead()
    assert len(found) == 1


def test_compile_ahead_leaves_nothing_to_compile() -> None:
    """For lights that are another's, too few, or without names: in a process of its own."""
    run_alone(SIGHTINGS)

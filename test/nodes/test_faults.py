"""Nodes that are killed, cameras that stall, flood and jump, and disks that are full."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
import itertools
import os
from pathlib import Path
import resource
import signal
import time

from blob_tracker.ros.stamp import to_ns
from blob_tracker.simulation import FlashingLight
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
import numpy as np
from played_camera import PlayedCamera
from processes import executable, Probe, probe, Process, start
import pytest

SMALL = {'width': 160, 'height': 120, 'focal_length': 200.0}
SCENE = FlashingLight(width=160, height=120, period=3.0)
# What runs in each arrangement, by the name that it is killed by.
ARRANGEMENTS = {
    'three processes': {'simulator': SMALL, 'segmenter': {}, 'locator': {}},
    'pipeline': {'pipeline': {'source': 'simulator'} | SMALL},
    'pipeline with images': {'simulator': SMALL, 'pipeline': {'source': 'images'}},
}
ON_THE_WAY = 0.5  # s in which what was sent before has come


class Truth:
    """Bearings of the tracker, beside the true ones of the simulator."""

    def __init__(self, node: Probe) -> None:
        self.bearings = node.record(Vector3Stamped, 'target/bearing', 1000)
        self.truths = node.record(Vector3Stamped, 'simulator/truth/bearing', 1000)
        self._node = node

    def expect_right(self) -> None:
        """Expect every bearing within 0.1 px, 8 sigma of the light, of the true one."""
        self._node.spin(0.1)
        true = {to_ns(m.header.stamp): m.vector for m in self.truths}
        for each in self.bearings:
            vector = true.get(to_ns(each.header.stamp))
            if vector is not None:
                within = 0.1 / SMALL['focal_length'] * 1e3
                assert abs(each.vector.x - vector.x) < within
                assert abs(each.vector.y - vector.y) < within

    def expect_new(self) -> None:
        """Wait for bearings of frames from now on."""
        self._node.spin(ON_THE_WAY)
        self.bearings.clear()
        self._node.spin_until(lambda: len(self.bearings) >= 3)


@pytest.mark.parametrize('arrangement', ARRANGEMENTS)
def test_any_node_that_is_killed_may_come_back(arrangement: str, domain: int) -> None:
    """SIGKILL, in any order, one and then all but one: bearings are back, and none is wrong."""
    wanted = ARRANGEMENTS[arrangement]
    with probe(domain) as node, ExitStack() as stack:
        running = {}

        def begin(name: str) -> None:
            running[name] = stack.enter_context(start(name, domain, **wanted[name]))

        def kill(name: str) -> None:
            assert running[name].end(signal.SIGKILL) == -signal.SIGKILL

        truth = Truth(node)
        for name in wanted:
            begin(name)
        truth.expect_new()
        for name in wanted:
            kill(name)
            begin(name)
            truth.expect_new()
            assert all(each.running for each in running.values())
        for name in wanted:  # all of them, and back in the other order
            kill(name)
        for name in reversed(wanted):
            begin(name)
        truth.expect_new()
        truth.expect_right()

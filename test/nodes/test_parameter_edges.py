"""Every parameter at the ends of its range, just outside and of the wrong type, while it runs."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, nan
from typing import Any

from blob_tracker.nodes.interface import locator, segmenter, simulator, tracker
from blob_tracker.ros.interface import Parameter
from blob_tracker.ros.messages.stamp import to_ns
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
import pytest
from support.processes import PATIENCE, Probe, probe, Process, start

DECLARED = {
    'segmenter': segmenter.PARAMETERS,
    'locator': locator.PARAMETERS,
    'tracker': tracker.PARAMETERS,
    'simulator': simulator.PARAMETERS,
}
SMALL = {'width': 160, 'height': 120, 'focal_length': 200.0}  # frames, for speed
# Any text: paths, topics and codes that are none, too long, or of another alphabet.
TEXTS = (
    'a' * 5000,
    '/' + 'a' * 300,
    '/dev/zero',
    'http://x/y',
    'package://x/y',
    'file://x',
    '${NO}',
    'a__b,c d,9',
    'x:' + '10' * 20000,
    'x:1100,x_:0110',
    'ü\u202e\U0001f600\x1b[2J',
    '',
)


def _edges(parameter: Parameter) -> Iterator[tuple[Any, bool | None]]:
    """Give values, and whether each must be taken; None where that is the node's to say."""
    default, least, most = parameter.default, parameter.least, parameter.most
    if isinstance(default, bool):
        yield from ((True, None), (False, None), (1, False), ('true', False))
    elif parameter.choices:
        yield from ((choice, None) for choice in parameter.choices)
        yield from (('none of them', False), (1, False))
    elif isinstance(default, str):
        yield from ((text, None) for text in TEXTS)
        yield 1, False
    elif least is not None and most is not None:
        # rclpy takes what differs from a bound by a millionth of it.
        beyond = 1 if isinstance(default, int) else 1e-4 * max(abs(most), 1.0)
        yield from ((least, None), (most, None), (least - beyond, False), (most + beyond, False))
        yield 'text', False
        if isinstance(default, float):
            yield from ((nan, False), (inf, False), (-inf, False), (int(most), False))


class Edges:
    """A running tracker whose parameters are set."""

    def __init__(self, node: Probe, processes: list[Process]) -> None:
        self.node = node
        self.processes = processes
        self.bearings = node.record(Vector3Stamped, 'target/bearing', 1000)
        self.predictions = node.record(Vector3Stamped, 'target/bearing_predicted', 1000)
        self.rays = node.record(PoseWithCovarianceStamped, 'target/ray', 1000)
        self.truths = node.record(Vector3Stamped, 'simulator/truth/bearing', 1000)

    def try_edges(self, name: str, parameter: Parameter) -> None:
        """Set all edges of a parameter, and its default again; nothing wrong may come of it."""
        default = SMALL.get(parameter.name, parameter.default) if name == 'simulator' else (
            parameter.default
        )
        for value, taken in _edges(parameter):
            result = self.node.set_parameter(name, parameter.name, value)
            assert all(each.running for each in self.processes), (parameter.name, value)
            if taken is not None:
                assert result.successful is taken, (parameter.name, value, result.reason)
            assert result.successful or len(result.reason) > 20, (parameter.name, value)
            self.node.spin(0.02)  # a frame of it
        result = self.node.set_parameter(name, parameter.name, default)
        assert result.successful, (parameter.name, result.reason)

    def expect_right(self, within: float) -> None:
        """Expect the bearings so far within so many px, or 6 sigma, of the truth."""
        truth = {to_ns(m.header.stamp): m.vector for m in self.truths}
        sigma = {
            to_ns(m.header.stamp): np.sqrt(np.array(m.pose.covariance)[[28, 21]]) * 1e3
            for m in self.rays
        }
        for bearing in self.bearings:
            stamp_ns = to_ns(bearing.header.stamp)
            if stamp_ns in truth and stamp_ns in sigma:
                true = truth[stamp_ns]
                error = bearing.vector.x - true.x, bearing.vector.y - true.y
                most = within / SMALL['focal_length'] * 1e3 + 6.0 * sigma[stamp_ns]
                assert (np.abs(error) < most).all(), (error, most)
        for messages in (self.bearings, self.rays, self.truths):
            messages.clear()

    def expect_life(self) -> None:
        """Expect the light to be tracked as if nothing had been."""
        self.node.settle(0.3)  # what is on its way
        self.bearings.clear()
        self.predictions.clear()
        self.node.spin_until(
            lambda: len(self.bearings) >= 5 and len(self.predictions) >= 5, 3.0 * PATIENCE
        )
        self.expect_right(0.08)


@pytest.fixture(params=['four processes', 'pipeline'])
def edges(request: pytest.FixtureRequest, domain: int) -> Iterator[Edges]:
    """Start the tracker once for all nodes' parameters."""
    with probe(domain) as node:
        if request.param == 'pipeline':
            with start('pipeline', domain, source='simulator', **SMALL) as process:
                yield Edges(node, [process])
            processes = [process]
        else:
            with (
                start('segmenter', domain) as segmenter,
                start('locator', domain) as locator,
                start('tracker', domain) as tracker,
                start('simulator', domain, **SMALL) as simulator,
            ):
                processes = [segmenter, locator, tracker, simulator]
                yield Edges(node, processes)
    for process in processes:
        assert 'Traceback' not in process.output


def test_every_edge_of_every_parameter(edges: Edges) -> None:
    """Taken or refused with a reason; no crash, no hang; with the defaults all is as before."""
    edges.expect_life()
    for name, parameters in DECLARED.items():
        for parameter in parameters:
            edges.try_edges(name, parameter)
        edges.expect_life()

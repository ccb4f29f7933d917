"""
Camera, segmenter, locator and tracker in one process: all is handed over in memory.

The nodes are what they are alone, with ROS about them. Their arithmetic without ROS is another
thing, the class `blob_tracker.Pipeline`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
import sys

from blob_tracker.nodes import locator, segmenter, tracker
from blob_tracker.nodes.interface import interface_of
from blob_tracker.nodes.interface.pipeline import CHAIN, PARAMETERS, SOURCES
from blob_tracker.ros.parameters.declaration import declare, given
from blob_tracker.ros.parameters.values import unknown
from blob_tracker.ros.process import run
from rclpy.node import Node


def linked_nodes() -> Iterator[Node]:
    """
    Yield the nodes of the process, each linked to the next.

    They are the very nodes that run alone, with their names, topics and parameters, so that the
    same parameter file serves both. A value that is given for the whole process, as by
    `-p device:=/dev/video0`, goes to the nodes that have such a parameter.

    Raises
    ------
    ParameterError
        If a parameter cannot be, or no node has one of this name.

    """
    pipeline = Node('pipeline')
    yield pipeline
    common = given(pipeline)
    source = declare(pipeline, PARAMETERS, common)['source']
    known = {
        each.name
        for name in ('pipeline', *CHAIN, *SOURCES[source])
        for each in interface_of(name).parameters
    } | {'use_sim_time', 'start_type_description_service'}
    if source != 'camera':  # whose controls have names that only the device knows
        for name in common:
            if name not in known:
                raise unknown(name, sorted(known))

    tracking = tracker.TrackerNode(listen=False, elsewhere=common)
    yield tracking
    locating = locator.LocatorNode(listen=False, deliver=tracking.track, elsewhere=common)
    yield locating

    def announce(lights: Collection[str]) -> None:
        tracking.set_lights(lights)
        locating.set_lights(lights)

    segmenting = segmenter.SegmenterNode(
        listen=source == 'images',
        deliver=locating.locate,
        announce=announce,
        predict=tracking.seen_at,
        elsewhere=common,
    )
    yield segmenting
    # Only the one that is asked for: the lab, above all, takes a while to load.
    if source == 'camera':
        from blob_tracker.nodes.camera import CameraNode
        yield CameraNode(
            deliver=segmenting.segment, rehearsal=segmenting.rehearsal, elsewhere=known
        )
    elif source == 'simulator':
        from blob_tracker.nodes.simulator import SimulatorNode
        yield SimulatorNode(deliver=segmenting.segment, elsewhere=common)


def compile_all() -> None:
    """Compile search, fits and filter, before the first frame could wait for them."""
    segmenter.compile_search()
    locator.compile_default()
    tracker.compile_filter()


def main() -> None:
    """Run the nodes."""
    sys.exit(run(linked_nodes, compile_all))

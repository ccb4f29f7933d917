"""Nodes that are killed, cameras that stall, flood and jump, and disks that are full."""

from __future__ import annotations

from contextlib import ExitStack
from itertools import count
from pathlib import Path
import signal
import time
from typing import Any

from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.simulation import flashing_light
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
import pytest
from rosgraph_msgs.msg import Clock
from support.played_camera import PlayedCamera, STEP_NS
from support.processes import executable, Probe, probe, Process, start

SMALL = {'width': 160, 'height': 120, 'focal_length': 200.0}
SCENE = flashing_light(width=160, height=120, period=3.0)
# What runs in each arrangement, by the name that it is killed by.
ARRANGEMENTS: dict[str, dict[str, dict[str, Any]]] = {
    'four processes': {'simulator': SMALL, 'segmenter': {}, 'locator': {}, 'tracker': {}},
    'pipeline': {'pipeline': {'source': 'simulator'} | SMALL},
    'pipeline with images': {'simulator': SMALL, 'pipeline': {'source': 'images'}},
}
ON_THE_WAY = 0.5  # s in which what was sent before has come
JUDGED = 6  # bearings: of the first and of the last time that they are waited for, at least


class Truth:
    """Bearings of the tracker, beside the true ones of the simulator."""

    def __init__(self, node: Probe) -> None:
        self.bearings = node.record(Vector3Stamped, 'target/bearing', 1000)
        self.predictions = node.record(Vector3Stamped, 'target/bearing_predicted', 1000)
        self.truths = node.record(Vector3Stamped, 'simulator/truth/bearing', 1000)
        self._node = node

    def expect_right(self, within: float = 0.1) -> None:
        """Expect every bearing within so many px, 8 sigma of the light, of the true one."""
        self._node.settle(0.1)
        true = {to_ns(m.header.stamp): m.vector for m in self.truths}
        most = within / SMALL['focal_length'] * 1e3
        judged = 0
        for each in self.bearings:
            vector = true.get(to_ns(each.header.stamp))
            if vector is not None:  # its topic may be discovered after that of the bearings
                judged += 1
                assert abs(each.vector.x - vector.x) < most
                assert abs(each.vector.y - vector.y) < most
        # Not a share of all: bearings come for a second or two before a simulator that is back is
        # heard, see `expect_new`.
        assert judged >= JUDGED, (judged, len(self.bearings))

    def expect_new(self) -> None:
        """Wait for bearings of frames from now on, for predictions, and for the truth."""
        self._node.settle(ON_THE_WAY)
        for messages in (self.truths, self.bearings, self.predictions):
            before = len(messages)
            self._node.spin_until(lambda: len(messages) >= before + 3)


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
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
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
        # A node that was killed is in the graph for another 20 s.
        assert not _said(diagnostics, ' nodes of the name ')


# What takes the frames of a camera that the test plays.
TAKERS: dict[str, dict[str, dict[str, Any]]] = {
    'four processes': {'segmenter': {}, 'locator': {}, 'tracker': {}},
    'pipeline': {'pipeline': {'source': 'images'}},
}


def _start_takers(
    stack: ExitStack, arrangement: str, domain: int, **parameters: object
) -> list[Process]:
    """Start what finds the light in frames from elsewhere."""
    return [
        stack.enter_context(start(name, domain, **own | parameters))
        for name, own in TAKERS[arrangement].items()
    ]


def _said(diagnostics: list[DiagnosticArray], sentence: str) -> bool:
    """Tell whether a diagnostic has said this."""
    return any(sentence in status.message for array in diagnostics for status in array.status)


@pytest.mark.parametrize('arrangement', TAKERS)
def test_a_camera_that_stalls_is_named_and_tracked_again(arrangement: str, domain: int) -> None:
    """Frames stop, and come again: with the stamps of their time, of before, or repeated."""
    with probe(domain) as node, ExitStack() as stack:
        processes = _start_takers(stack, arrangement, domain)
        camera = PlayedCamera(node, SCENE)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        camera.discover()
        first = camera.flash() + 1
        node.spin_until(lambda: _said(diagnostics, 'no frames arrive; is a camera publishing'))
        last = camera.stamp_ns
        frames = count(first)

        def resumed() -> bool:
            camera.send(next(frames))
            node.spin(0.005)
            return camera.located(last)

        node.spin_until(resumed)  # as if nothing had been: buffers that were full meanwhile
        end, camera.stamp_ns = camera.stamp_ns, last  # the same stamps again, and on
        for index in range(first, first + 15 + (end - last) // STEP_NS):
            camera.send(index)
            node.spin(0.005)
        camera.flash()  # a second later by its stamps
        camera.expect_right()
        assert all(process.running for process in processes)


@pytest.mark.parametrize('arrangement', TAKERS)
def test_a_flood_is_taken_or_its_loss_is_named(arrangement: str, domain: int) -> None:
    """640x480 at 600 Hz, ten times the rate: memory stays, and every bearing is right."""
    scene = flashing_light(reach=0.0)  # a light that jumps where the frames begin again is lost
    rate, frames = 600.0, 1200
    with probe(domain) as node, ExitStack() as stack:
        processes = _start_takers(stack, arrangement, domain)
        camera = PlayedCamera(node, scene)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        camera.discover()
        camera.flash()
        drawn = [camera.messages(index) for index in range(60)]
        before = [process.own_memory() for process in processes]
        camera.stamp_ns += 10**9
        first = camera.stamp_ns
        began = time.monotonic()
        for index in range(frames):
            camera.stamp_ns = first + round(1e9 * index / rate)
            camera.send_again(index % 60, *drawn[index % 60])
            node.spin(max(began + (index + 1) / rate - time.monotonic(), 0.0))
        after = [process.own_memory() for process in processes]
        # Ten messages of either topic and a pair of frames are 7 MB. What the camera has in its
        # shared memory is no memory of theirs.
        assert all(b - a < 20.0 for a, b in zip(before, after)), (before, after)

        def accounted_for() -> bool:
            located = sum(1 for each in camera.bearings if to_ns(each.header.stamp) > first)
            # A frame may take its neighbour with it.
            lost = 2 * int(_last(diagnostics, '/segmenter', 'missing frames', '0'))
            lost += sum(
                int(_last(diagnostics, '/locator', key, '0'))
                for key in ('images not taken in time', 'images lost on the way')
            )
            return located + lost >= 0.45 * frames

        # Half the frames are lit; what did not come as a bearing is counted as lost.
        node.spin_until(accounted_for)
        camera.expect_right()
        camera.flash()
        camera.expect_right()


def _last(
    diagnostics: list[DiagnosticArray], node: str, key: str, unsaid: str | None = None
) -> str:
    """Return the last value of a diagnostic, or what it is while the node does not say it."""
    values = [
        pair.value
        for array in diagnostics
        for status in array.status
        if status.name.startswith(node)
        for pair in status.values
        if pair.key == key
    ]
    return values[-1] if values or unsaid is None else unsaid


# How a node starts ("$@") where its logs find no room; {} is a folder.
NO_ROOM = {
    # In a mount namespace of its own, which needs no privilege where the kernel allows that.
    'disk of the log files is full': 'exec unshare --user --map-root-user --mount sh -c '
    '"mount -t tmpfs -o size=64k tmpfs {0}; head -c 1M /dev/zero > {0}/full; '
    'ROS_LOG_DIR={0} exec \\"\\$@\\"" sh "$@"',
    'folder of the log files cannot be': 'touch {0}/file; ROS_LOG_DIR={0}/file/x exec "$@"',
    'terminal is a file on a full disk': 'exec "$@" > /dev/full 2>&1',
}


@pytest.mark.parametrize('where', NO_ROOM)
def test_tracking_needs_no_room_for_logs(where: str, tmp_path: Path, domain: int) -> None:
    """Words are lost, bearings are not; that a disk is full is said where it can be heard."""
    command = [str(executable('pipeline')), '--ros-args', '-p', 'source:=simulator']
    for name, value in SMALL.items():
        command += ['-p', f'{name}:={value}']
    with probe(domain) as node:
        truth = Truth(node)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with Process(['sh', '-c', NO_ROOM[where].format(tmp_path), 'sh', *command], domain) as it:
            truth.expect_new()
            for rate in (50.0, 70.0) * 10:  # each is a line in the log, of several hundred bytes
                assert node.set_parameter('simulator', 'rate', rate).successful
            truth.expect_new()
            truth.expect_right()
            sentence = 'the disk of the log files is full'
            if where == 'disk of the log files is full':
                node.spin_until(lambda: _said(diagnostics, sentence))
            else:
                node.spin_until(lambda: len(diagnostics) >= 6)  # two of each node
                assert not _said(diagnostics, sentence)
            assert it.end() == 0
        assert 'Traceback' not in it.output
        assert where != 'folder of the log files cannot be' or 'set ROS_LOG_DIR' in it.output


def test_a_clock_that_jumps_is_named_and_forgotten(domain: int) -> None:
    """Back by an hour, forward by two, and back, as of bags that begin again."""
    with probe(domain) as node, ExitStack() as stack:
        processes = _start_takers(stack, 'four processes', domain, use_sim_time='true')
        camera = PlayedCamera(node, SCENE)
        clock = node.create_publisher(Clock, '/clock', 10)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')

        def tick() -> None:
            clock.publish(Clock(clock=from_ns(camera.stamp_ns)))

        camera.discover(tick)
        camera.flash(tick)
        for hours in (-1, 2, -1):
            diagnostics.clear()
            camera.stamp_ns += hours * 3600 * 10**9
            camera.flash(tick)
            if hours < 0:
                node.spin_until(lambda: _said(diagnostics, 'the ROS clock jumped back by 3'))
        camera.expect_right()
        assert all(process.running for process in processes)


def test_two_cameras_on_one_topic_are_both_named(domain: int) -> None:
    """What differs between their pictures is no target: no bearing while both publish."""
    with probe(domain) as node, ExitStack() as stack:
        processes = _start_takers(stack, 'pipeline', domain)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        truth = Truth(node)
        for seed, name in enumerate(('left', 'right')):
            stack.enter_context(
                start('simulator', domain, '-r', f'__node:={name}', seed=seed, **SMALL)
            )
            if name == 'left':
                truth.expect_new()
        sentence = 'several nodes publish it (/left, /right), and none of the images is used'
        node.spin_until(lambda: _said(diagnostics, sentence))
        # The first frame of the other one was taken as the unlit half: texture about the light.
        truth.expect_right(within=1.0)
        truth.bearings.clear()
        node.settle(1.0)
        assert not truth.bearings
        assert all(process.running for process in processes)

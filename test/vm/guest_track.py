"""
Runs in the guest: camera, segmenter and locator look at the playing scene; what they say is kept.

The folder holds scene.grey and camera_info.yaml, and gets track.json and a log of each process.
First the nodes are three processes, then one. That one's camera is unplugged and plugged in again,
and from then on both ends of the loop lose frames.
"""

from __future__ import annotations

from collections.abc import Callable
import json
from pathlib import Path
import signal
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, Vector3Stamped
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from vm.fork import Fork, node
from vm.hdmi_loop import (
    CAPTURE, close_loop, HEIGHT, OUTPUT, playing, SLOW_FRAME_RATE, SLOW_TIMINGS, SLOWNESS,
    v4l2_ctl, wait_for, WIDTH,
)
from vm.scene import NOISE

COUNT = 30  # bearings of the three processes and of the one: all lit places twice
STARTUP = 90.0 * SLOWNESS  # s until the first bearing; ten on a quiet machine
END = 40.0 * SLOWNESS  # s; two on a quiet machine
LAST_WORDS = 2.0 * SLOWNESS  # s in which the last messages of processes that have ended are taken
# s without another bearing that end a half. On a quiet machine 30 come in 5 s, on one that is busy
# they come as it has time for them: as long as they come, the half goes on.
PATIENCE = 60.0 * SLOWNESS
PARAMETERS: dict[str, dict[str, object]] = {
    'camera': {'device': CAPTURE, 'width': WIDTH, 'height': HEIGHT, 'pixel_format': 'GREY'},
    # The light goes up to 26 px from one flash to the next, twice that where one is lost.
    'segmenter': {'gate': 60.0, 'max_pair_interval': 2.4 / SLOW_FRAME_RATE},
    # Under another noise each pulse is a misfit, and all that it might be is tried.
    'locator': {'noise.gain': NOISE.gain, 'noise.read_noise': NOISE.read_noise},
}


class Recorder(Node):
    """Keep the bearings, centroids and complaints, by stamp in ns."""

    def __init__(self) -> None:
        super().__init__('recorder')
        self.bearings: list[list[float]] = []
        self.centroids: list[list[float]] = []
        self.complaints: set[str] = set()
        qos = QoSProfile(depth=10)  # reliable
        self.create_subscription(Vector3Stamped, 'target/bearing', self._bearing, qos)
        self.create_subscription(PointStamped, 'target/centroid', self._centroid, qos)
        # Deep enough for the seconds in which the recorder does not listen.
        self.create_subscription(DiagnosticArray, '/diagnostics', self._diagnostics, 100)

    def count(self) -> int:
        """Return how many bearings came since they were taken."""
        return len(self.bearings)

    def take(self) -> dict[str, list[list[float]]]:
        """Return what came since the last call."""
        taken = {'bearings': self.bearings, 'centroids': self.centroids}
        self.bearings, self.centroids = [], []
        return taken

    def _bearing(self, message: Vector3Stamped) -> None:
        stamp, value = message.header.stamp, message.vector
        self.bearings.append(
            [stamp.sec * 10**9 + stamp.nanosec, value.x, value.y, value.z, time.time_ns()])

    def _centroid(self, message: PointStamped) -> None:
        stamp, value = message.header.stamp, message.point
        self.centroids.append([stamp.sec * 10**9 + stamp.nanosec, value.x, value.y, value.z])

    def _diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.level != b'\x00':
                self.complaints.add(f'{status.name}: {status.message}')


def prepare(name: str, parameters: dict[str, object], folder: Path) -> Fork:
    """Return the process of a node, with its log, that is still to begin."""
    arguments = ['--ros-args']
    for key, value in parameters.items():
        arguments += ['-p', f'{key}:={value}']
    return Fork(node(name, *arguments), folder / f'{name}.log')


def end(processes: dict[str, Fork]) -> dict[str, Any]:
    """End processes together; return their exit codes and the seconds that they took."""
    began = time.monotonic()
    for process in processes.values():
        process.send_signal(signal.SIGTERM)
    found = {}
    for name, process in processes.items():
        try:
            code: int | str = process.wait(END)
        except TimeoutError:
            process.send_signal(signal.SIGABRT)  # its log gets the stack of every thread
            process.wait()
            code = f'aborted after {END:.0f} s'
        found[name] = [code, time.monotonic() - began]
    return found


def wait(recorder: Node, came: Callable[[], int], count: int, patience: float) -> float:
    """Wait for so many to come, so long for each; return the seconds that it took."""
    began = since = time.monotonic()
    while (before := came()) < count and time.monotonic() - since < patience:
        rclpy.spin_once(recorder, timeout_sec=0.5)
        if came() > before:
            since = time.monotonic()
            print(came(), flush=True)  # a word for who waits for the machine
    return time.monotonic() - began


def record(recorder: Recorder) -> dict[str, Any]:
    """Return COUNT bearings, or those that came before none came, and the seconds of it."""
    return {'seconds': wait(recorder, recorder.count, COUNT, PATIENCE), **recorder.take()}


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop(timings=SLOW_TIMINGS)
    found: dict[str, Any] = {'count': COUNT}
    scene = folder / 'scene.grey'
    parameters = {name: dict(values) for name, values in PARAMETERS.items()}
    parameters['camera']['camera_info_url'] = f'file://{folder}/camera_info.yaml'
    processes = {name: prepare(name, values, folder) for name, values in parameters.items()}
    together = {name: value for values in parameters.values() for name, value in values.items()}
    pipeline = {'pipeline': prepare('pipeline', together, folder)}
    with playing(scene, 'GREY'):
        for process in processes.values():
            process.begin()
        rclpy.init()
        recorder = Recorder()
        found['startup'] = wait(recorder, recorder.count, 1, STARTUP)
        found['clean'] = record(recorder)
        found['exits'] = end(processes)
        wait(recorder, recorder.count, sys.maxsize, LAST_WORDS)
        recorder.take()
        pipeline['pipeline'].begin()
        found['startup of the pipeline'] = wait(recorder, recorder.count, 1, STARTUP)
        v4l2_ctl(CAPTURE, '-c', 'disconnect=1')
    wait_for(OUTPUT)
    with playing(scene, 'GREY'):
        # What the output loses is repeated at the input; a busy machine loses as many more itself.
        for device in (OUTPUT, CAPTURE):
            v4l2_ctl(device, '-c', 'percentage_of_dropped_buffers=8')
        found['lossy'] = record(recorder)
        found['exits'] |= end(pipeline)
    found['complaints'] = sorted(recorder.complaints)
    (folder / 'track.json').write_text(json.dumps(found, indent=1))
    recorder.destroy_node()
    rclpy.try_shutdown()

"""
Runs in the guest: camera, segmenter and locator look at the playing scene; what they say is kept.

Usage: guest_track.py FOLDER NODES
FOLDER holds scene.grey and camera_info.yaml, and gets track.json and a log of each process; NODES
is the folder of the installed executables. First the nodes are three processes, then one. That
one's camera is unplugged and plugged in again, and from then on both ends of the loop lose frames.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, Vector3Stamped
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from vm.hdmi_loop import (
    CAPTURE, close_loop, HEIGHT, OUTPUT, playing, SLOWNESS, v4l2_ctl, wait_for, WIDTH,
)

COUNT = 60  # bearings of the three processes and of the one: all lit places four times
STARTUP = 90.0 * SLOWNESS  # s until the first bearing: four Pythons on two emulated processors
END = 40.0 * SLOWNESS  # s; two on a quiet machine
LAST_WORDS = 2.0 * SLOWNESS  # s in which the last messages of processes that have ended are taken
LONGEST = 100.0 * SLOWNESS  # s for each half; 5 s are enough on a quiet machine
PARAMETERS: dict[str, dict[str, object]] = {
    'camera': {'device': CAPTURE, 'width': WIDTH, 'height': HEIGHT, 'pixel_format': 'GREY'},
    # The light goes up to 26 px from one flash to the next, twice that where one is lost.
    'segmenter': {'gate': 60.0},
    'locator': {},
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


def start(
    name: str, parameters: dict[str, object], folder: Path, nodes: Path
) -> subprocess.Popen[bytes]:
    """Start an executable, with its log."""
    command = [str(nodes / name), '--ros-args']
    for key, value in parameters.items():
        command += ['-p', f'{key}:={value}']
    with (folder / f'{name}.log').open('wb') as log:
        return subprocess.Popen(
            command, stdout=log, stderr=subprocess.STDOUT,
            env=os.environ | {'PYTHONFAULTHANDLER': '1'})


def end(processes: dict[str, subprocess.Popen[bytes]]) -> dict[str, Any]:
    """End processes together; return their exit codes and the seconds that they took."""
    began = time.monotonic()
    for process in processes.values():
        process.send_signal(signal.SIGTERM)
    found = {}
    for name, process in processes.items():
        try:
            code: int | str = process.wait(timeout=END)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGABRT)  # its log gets the stack of every thread
            process.wait()
            code = f'aborted after {END:.0f} s'
        found[name] = [code, time.monotonic() - began]
    return found


def wait(recorder: Recorder, count: int, longest: float) -> float:
    """Wait until the recorder has so many bearings; return the seconds that it took."""
    began = time.monotonic()
    while len(recorder.bearings) < count and time.monotonic() - began < longest:
        rclpy.spin_once(recorder, timeout_sec=0.5)
    return time.monotonic() - began


def record(recorder: Recorder) -> dict[str, Any]:
    """Return COUNT bearings, or those of LONGEST, and the seconds that it took."""
    return {'seconds': wait(recorder, COUNT, LONGEST), **recorder.take()}


def main(folder: Path, nodes: Path) -> None:
    """Do all of it."""
    close_loop()
    found: dict[str, Any] = {'count': COUNT}
    scene = folder / 'scene.grey'
    parameters = {name: dict(values) for name, values in PARAMETERS.items()}
    parameters['camera']['camera_info_url'] = f'file://{folder}/camera_info.yaml'
    with playing(scene, 'GREY'):
        processes = {
            name: start(name, values, folder, nodes) for name, values in parameters.items()}
        rclpy.init()
        recorder = Recorder()
        found['startup'] = wait(recorder, 1, STARTUP)
        found['clean'] = record(recorder)
        found['exits'] = end(processes)
        together: dict[str, object] = {}
        for values in parameters.values():
            together |= values
        wait(recorder, sys.maxsize, LAST_WORDS)
        recorder.take()
        processes = {'pipeline': start('pipeline', together, folder, nodes)}
        found['startup of the pipeline'] = wait(recorder, 1, STARTUP)
        v4l2_ctl(CAPTURE, '-c', 'disconnect=1')
    wait_for(OUTPUT)
    with playing(scene, 'GREY'):
        # What the output loses is repeated at the input.
        for device in (OUTPUT, CAPTURE):
            v4l2_ctl(device, '-c', 'percentage_of_dropped_buffers=15')
        found['lossy'] = record(recorder)
        found['exits'] |= end(processes)
    found['complaints'] = sorted(recorder.complaints)
    (folder / 'track.json').write_text(json.dumps(found, indent=1))
    recorder.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main(Path(sys.argv[1]), Path(sys.argv[2]))

"""
Runs in the guest: a coded light and one that runs free, played into the driver and tracked.

The folder holds blink.grey and camera_info.yaml, and gets blink.json and a log.
"""

from __future__ import annotations

from functools import partial
import json
import os
from pathlib import Path
import time
from typing import Any

from geometry_msgs.msg import PointStamped
import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Image
from vm.fork import Fork
from vm.guest_capture import digest
from vm.guest_track import end, PARAMETERS, PATIENCE, prepare, STARTUP, wait
from vm.hdmi_loop import close_loop, OUTPUT, SLOW_FRAME_RATE, SLOW_TIMINGS, take_format
from vm.output_queue import OutputQueue
from vm.scene import (
    BITS_PER_SECOND, BLINK_HEIGHT, BLINK_WIDTH, CODE, EXPOSURE, FREQUENCY, LIGHTS, PAUSE,
)

COUNT = 110  # frames of the scene: 28 s on a quiet machine
AHEAD = 12  # frames, until the player is ready
BEGIN = Path('/run/blink.begin')  # holds the time, s, at which the player is to begin
FLASH: dict[str, object] = {
    'width': BLINK_WIDTH,
    'height': BLINK_HEIGHT,
    'flash.mode': 'coded',
    'flash.codes': f'coded:{CODE}',
    'flash.bits_per_second': BITS_PER_SECOND,
    'flash.frequencies': f'free:{FREQUENCY}',
    'flash.exposure': EXPOSURE,
    'max_pair_interval': PAUSE,
    'prediction_rate': 0.0,
}


class Recorder(Node):
    """Keep the places of each light, in px, and the pictures' indices in the scene, by stamp."""

    def __init__(self, known: dict[str, int]) -> None:
        super().__init__('recorder')
        self.places: dict[str, list[tuple[int, float, float]]] = {name: [] for name in LIGHTS}
        self.pictures: list[tuple[int, int]] = []
        self.newest = 0  # ns, stamp of any picture
        self._known = known
        qos = QoSProfile(depth=10)  # reliable
        for name in LIGHTS:
            self.create_subscription(
                PointStamped, f'target/{name}/centroid', partial(self._place, name), qos)
        self.create_subscription(Image, 'camera/image_raw', self._picture, qos)

    def _place(self, name: str, message: PointStamped) -> None:
        self.places[name].append((_ns(message), message.point.x, message.point.y))

    def _picture(self, message: Image) -> None:
        self.newest = _ns(message)
        index = self._known.get(digest(np.frombuffer(message.data, np.uint8)))
        if index is not None:  # not the driver's own picture
            self.pictures.append((_ns(message), index))


def _ns(message: Any) -> int:
    stamp = message.header.stamp
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def play(frames: np.ndarray) -> None:
    """Show frame n of the scene in interval n of the output device, whoever is late."""
    fd = os.open(OUTPUT, os.O_RDWR)
    queue = OutputQueue(fd)

    def put(index: int, number: int) -> None:
        queue.put(index, frames[number % len(frames)].tobytes())

    for index in range(len(queue)):
        put(index, index)
    time.sleep(max(0.0, float(BEGIN.read_text()) - time.time()))
    queue.start()
    while True:
        shown = queue.take()
        put(shown.index, shown.sequence + len(queue))


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop(timings=SLOW_TIMINGS)
    frames = np.fromfile(folder / 'blink.grey', np.uint8).reshape(-1, BLINK_HEIGHT, BLINK_WIDTH)
    take_format('GREY', OUTPUT, BLINK_WIDTH, BLINK_HEIGHT)
    parameters = PARAMETERS['camera'] | PARAMETERS['locator'] | FLASH | {
        'camera_info_url': f'file://{folder}/camera_info.yaml'}
    player = Fork(lambda: play(frames), folder / 'player.log')
    processes = {'pipeline': prepare('pipeline', parameters, folder)}
    processes['pipeline'].begin()
    rclpy.init()
    recorder = Recorder({digest(frame): index for index, frame in enumerate(frames)})
    startup = wait(recorder, lambda: int(recorder.newest > 0), 1, STARTUP)
    found: dict[str, Any] = {'startup': startup}
    # Both ends have their own clock, of one rate: a picture is to change in the middle of those of
    # the other, where no jitter makes it come twice or never.
    BEGIN.write_text(str(recorder.newest / 1e9 + (AHEAD + 0.5) / SLOW_FRAME_RATE))
    player.begin()
    found['seconds'] = wait(recorder, lambda: len(recorder.pictures), COUNT, PATIENCE)
    found['exits'] = end(processes)
    end({'player': player})
    found |= {'pictures': recorder.pictures, 'places': recorder.places}
    (folder / 'pipeline.log').rename(folder / 'blink.log')
    (folder / 'blink.json').write_text(json.dumps(found, indent=1))
    recorder.destroy_node()
    rclpy.try_shutdown()

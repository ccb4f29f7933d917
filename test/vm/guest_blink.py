"""
Runs in the guest: a coded light and one that runs free, played into the driver and tracked.

Usage: guest_blink.py FOLDER NODES
FOLDER holds blink.grey and camera_info.yaml, and gets blink.json and a log; NODES is the folder of
the installed executables.
"""

from __future__ import annotations

from functools import partial
import json
from pathlib import Path
import sys
import time
from typing import Any

from geometry_msgs.msg import PointStamped
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from vm.guest_track import end, PARAMETERS, start, STARTUP
from vm.hdmi_loop import close_loop, FRAME_RATE, playing, SLOWNESS
from vm.scene import BITS_PER_SECOND, BLINK_HEIGHT, BLINK_WIDTH, CODE, FREQUENCY

COUNT = 12  # places of each light
LONGEST = 40.0 * SLOWNESS  # s for them; 3 s on a quiet machine
FLASH: dict[str, object] = {
    'flash.mode': 'coded',
    'flash.codes': f'coded:{CODE}',
    'flash.bits_per_second': BITS_PER_SECOND,
    'flash.frequencies': f'free:{FREQUENCY}',
    'flash.exposure': 0.5 / FRAME_RATE,
    # The loop repeats frames and leaves some out: two of them are no end of it.
    'max_pair_interval': 0.5,
    'prediction_rate': 0.0,
}
LIGHTS = 'coded', 'free'


class Recorder(Node):
    """Keep the places of each light: stamp in ns, x and y in px."""

    def __init__(self) -> None:
        super().__init__('recorder')
        self.places: dict[str, list[tuple[int, float, float]]] = {name: [] for name in LIGHTS}
        for name in LIGHTS:
            self.create_subscription(
                PointStamped, f'target/{name}/centroid', partial(self._take, name),
                QoSProfile(depth=10),  # reliable
            )

    def wait(self, count: int, longest: float) -> float:
        """Wait until each light has so many places; return the seconds that it took."""
        began = time.monotonic()
        while min(map(len, self.places.values())) < count and time.monotonic() - began < longest:
            rclpy.spin_once(self, timeout_sec=0.5)
        return time.monotonic() - began

    def _take(self, name: str, message: PointStamped) -> None:
        stamp = message.header.stamp
        self.places[name].append(
            (stamp.sec * 10**9 + stamp.nanosec, message.point.x, message.point.y))


def main(folder: Path, nodes: Path) -> None:
    """Do all of it."""
    close_loop()
    found: dict[str, Any] = {'count': COUNT}
    parameters = PARAMETERS['camera'] | FLASH | {
        'width': BLINK_WIDTH, 'height': BLINK_HEIGHT,
        'camera_info_url': f'file://{folder}/camera_info.yaml',
    }
    with playing(folder / 'blink.grey', 'GREY', width=BLINK_WIDTH, height=BLINK_HEIGHT):
        processes = {'pipeline': start('pipeline', parameters, folder, nodes)}
        rclpy.init()
        recorder = Recorder()
        found['startup'] = recorder.wait(1, STARTUP)
        found['seconds'] = recorder.wait(COUNT, LONGEST)
        found['exits'] = end(processes)
    found['places'] = recorder.places
    (folder / 'pipeline.log').rename(folder / 'blink.log')
    (folder / 'blink.json').write_text(json.dumps(found, indent=1))
    recorder.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main(Path(sys.argv[1]), Path(sys.argv[2]))

"""
Record frames, or other topics, in a bag, where there is no `ros2 bag record`.

    python3 examples/record_bag.py my_bag
    python3 examples/record_bag.py my_bag target/ray:geometry_msgs/msg/PoseWithCovarianceStamped

Ctrl-C ends it; until then the count of messages is shown. The bag is an mcap, with the instants at
which messages arrived.
"""

import argparse
from contextlib import suppress
from importlib import import_module
from pathlib import Path
import time
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

IMAGES = [
    'camera/image_raw:sensor_msgs/msg/Image', 'camera/camera_info:sensor_msgs/msg/CameraInfo'
]
# Takes from every publisher; the depth is for disks that are slow at times.
LIVE = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
SHOW_S = 1.0  # s from one look at the count to the next


def main() -> int:
    """Record until Ctrl-C."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('bag', type=Path, help='folder to make')
    parser.add_argument(
        'topics', nargs='*', default=IMAGES, metavar='TOPIC:TYPE',
        help=f'by default {" and ".join(IMAGES)}',
    )
    arguments = parser.parse_args()
    count = 0
    rclpy.init()
    node = rclpy.create_node('record_bag')
    with Writer(arguments.bag, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        for words in arguments.topics:
            topic, _, kind = words.partition(':')
            package, _, name = kind.partition('/msg/')
            connection = bag.add_connection(
                node.resolve_topic_name(topic), kind, typestore=get_typestore(Stores.ROS2_JAZZY)
            )

            def write(message: bytes, connection: Any = connection) -> None:
                nonlocal count
                count += 1
                bag.write(connection, time.time_ns(), message)

            message_type = getattr(import_module(f'{package}.msg'), name)
            node.create_subscription(message_type, topic, write, LIVE, raw=True)
        node.create_timer(SHOW_S, lambda: print(f'\r{count} messages', end='', flush=True))
        print('recording; Ctrl-C ends it', flush=True)
        try:
            rclpy.spin(node)
        except (KeyboardInterrupt, ExternalShutdownException):
            pass
    with suppress(RuntimeError):  # a signal's handler may be faster
        rclpy.try_shutdown()
    print(f'\r{count} messages in {arguments.bag}')
    return 0 if count else 1


if __name__ == '__main__':
    raise SystemExit(main())

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
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import get_typestore, Stores

IMAGES = [
    'camera/image_raw:sensor_msgs/msg/Image', 'camera/camera_info:sensor_msgs/msg/CameraInfo'
]
# Takes from every publisher; the depth is for disks that are slow at times.
LIVE = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
SHOW_S = 1.0  # s from one look at the count to the next


def _parted(words: str) -> tuple[str, str]:
    """Return name and type of a topic."""
    topic, _, kind = words.partition(':')
    return topic, kind


def _type_of(kind: str) -> Any:
    """Return the class of the messages of a type."""
    package, _, name = kind.partition('/msg/')
    try:
        return getattr(import_module(f'{package}.msg'), name)
    except (ImportError, AttributeError, TypeError, ValueError):
        raise ValueError(
            f'{kind!r} is no type of messages that is installed here; write TOPIC:TYPE, '
            'target/ray:geometry_msgs/msg/PoseWithCovarianceStamped say'
        ) from None


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
    try:
        topics = [(topic, kind, _type_of(kind)) for topic, kind in map(_parted, arguments.topics)]
        bag = Writer(arguments.bag, version=9, storage_plugin=StoragePlugin.MCAP)
    except (ValueError, WriterError) as error:
        parser.error(str(error))
    count = 0
    rclpy.init()
    node = rclpy.create_node('record_bag')
    with bag:
        for topic, kind, message_type in topics:
            connection = bag.add_connection(
                node.resolve_topic_name(topic), kind, typestore=get_typestore(Stores.ROS2_JAZZY)
            )

            def write(message: bytes, connection: Any = connection) -> None:
                nonlocal count
                count += 1
                bag.write(connection, time.time_ns(), message)

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

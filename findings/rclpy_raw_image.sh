#!/usr/bin/env bash
# A raw subscription takes a large image no sooner than one that makes a message of it.
#
# Expected: raw=True hands over the serialised bytes as they came, so that a node that reads an
# image's header by itself and looks at the pixels where they lie saves the deserialisation, the
# dearest step for frames of megabytes.
# Happens: to take the bytes of an image of 2.3 MB takes 1.2 to 2.3 times as long as to take the
# message with its pixels in an array; at 0.3 MB neither is ahead.
# Matters: parsing CDR by hand for the sake of speed makes a camera's node slower. The message is
# the quick way; what pays is to take fewer or smaller images.
#
# rclpy 7.1.6 of ROS 2 Jazzy on Fast DDS, 200 images of 1920 x 1200 bytes, the two kinds in turns,
# medians of take_message and of an array over the pixels:
#   raw is not the quicker one
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6' ros-jazzy-sensor-msgs
export ROS_LOG_DIR=$folder ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST ROS_DOMAIN_ID=96
unset FASTDDS_BUILTIN_TRANSPORTS FASTDDS_DEFAULT_PROFILES_FILE FASTRTPS_DEFAULT_PROFILES_FILE
cat >"$folder/take.py" <<'END'
import array
from statistics import median
import time

import numpy as np
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import Image

WIDTH, HEIGHT = 1920, 1200

rclpy.init()
node = Node('takes')
publisher = node.create_publisher(Image, 'image', 5)
subscriptions = {
    raw: node.create_subscription(Image, 'image', print, 5, raw=raw) for raw in (False, True)
}
image = Image(height=HEIGHT, width=WIDTH, encoding='mono8', step=WIDTH)
pixels = np.random.default_rng(1).integers(0, 255, WIDTH * HEIGHT, dtype=np.uint8)
image.data = array.array('B', pixels.tobytes())
while publisher.get_subscription_count() < 2:
    time.sleep(0.01)


def taken(raw):
    """Return the seconds of one image from DDS to an array of its pixels; NaN if none came."""
    handle = subscriptions[raw].handle
    began = time.perf_counter()
    found = handle.take_message(Image, raw)
    if found is None:  # not here yet
        return float('nan')
    if raw:
        pixels = np.frombuffer(found[0], np.uint8, offset=len(found[0]) - WIDTH * HEIGHT)
    else:
        pixels = np.frombuffer(found[0].data, np.uint8)
    seconds = time.perf_counter() - began
    assert pixels.size == WIDTH * HEIGHT
    return seconds


seconds = {False: [], True: []}
for turn in range(200):
    publisher.publish(image)
    time.sleep(0.02)
    for raw in (False, True) if turn % 2 else (True, False):
        seconds[raw].append(taken(raw))
ratio = median(a for a in seconds[True] if a == a) / median(a for a in seconds[False] if a == a)
print(f'raw is {"not " if ratio > 0.95 else ""}the quicker one', f'{ratio:.1f}')
END
found=$("$folder/venv/bin/python" -I "$folder/take.py")
echo "$found"
if [ "${found% *}" != 'raw is not the quicker one' ]; then
    echo 'Raw bytes are taken sooner than the message.' >&2
    exit 1
fi

#!/usr/bin/env bash
# A publisher that counts a subscription is not heard by it yet.
#
# Expected: once get_subscription_count() is 1 the two ends know each other, and what is published
# from then on arrives, best effort or not, on one machine without other load.
# Happens: each end finds the other by itself. The publisher may know the subscription some time
# before the subscription knows the publisher; best effort that is sent meanwhile is dropped by the
# reader, without a word, also from a publisher that is reliable.
# Matters: a test that waits for the count and then plays ten frames to a node finds some missing
# every other time. A message of the other end, or the answer of its service, tells that it hears.
#
# rclpy 7.1.6 of ROS 2 Jazzy, 200 numbers 2 ms apart to a subscription of best effort that has just
# been counted, 12 starts:
#   the first numbers were lost in some of 12 starts
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6' ros-jazzy-std-msgs
export ROS_LOG_DIR=$folder ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST ROS_DOMAIN_ID=97
unset FASTDDS_BUILTIN_TRANSPORTS FASTDDS_DEFAULT_PROFILES_FILE FASTRTPS_DEFAULT_PROFILES_FILE
cat >"$folder/hears.py" <<'END'
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Int32

rclpy.init()
node, heard = Node('hears'), []
best_effort = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
node.create_subscription(Int32, 'number', lambda message: heard.append(message.data), best_effort)
while not heard or heard[-1] < 199:
    rclpy.spin_once(node)
print(heard[0])
END
cat >"$folder/speaks.py" <<'END'
import subprocess
import sys
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import Int32

rclpy.init()
node = Node('speaks')
lost = 0
for _ in range(12):
    publisher = node.create_publisher(Int32, 'number', 1000)
    with subprocess.Popen(
        [sys.executable, '-I', sys.argv[1]], stdout=subprocess.PIPE, text=True
    ) as other:
        while publisher.get_subscription_count() == 0:
            time.sleep(0.001)
        for number in range(200):
            publisher.publish(Int32(data=number))
            time.sleep(0.002)
        while other.poll() is None:  # until it has the last one
            publisher.publish(Int32(data=199))
            time.sleep(0.1)
        lost += int(other.stdout.read()) > 0
    node.destroy_publisher(publisher)
print(f'the first numbers were lost in {"some" if lost else "none"} of 12 starts')
END
found=$("$folder/venv/bin/python" -I "$folder/speaks.py" "$folder/hears.py")
echo "$found"
if [ "$found" != 'the first numbers were lost in some of 12 starts' ]; then
    echo 'A subscription that is counted hears from then on.' >&2
    exit 1
fi

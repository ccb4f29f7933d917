#!/usr/bin/env bash
# serialize_message puts bytes that mean nothing behind a JointState, and rosbags refuses it.
#
# Expected: rclpy's serialize_message returns the message as it is published, and who reads CDR
# reads it.
# Happens: the length is reckoned before, with the padding of a double for each list of doubles,
# empty or not. A JointState of positions alone, as most drivers publish it, comes eight bytes
# longer than it is. What a publisher sends has the right length, unless it is given these bytes.
# rosbags takes a message of another length than its own for a damaged one.
# Matters: a bag that a test or a converter writes with serialize_message has joint_states that
# rosbags cannot read, while a recorded one has none; and two messages that are equal differ in
# their last bytes. Without that tail it is read.
#
# rclpy 7.1.6 of ROS 2 Jazzy, sensor_msgs 5.3.6, rosbags 0.11.9:
#   serialised by rclpy: 84 bytes, by rosbags: 76
#   SerdeError, CDR message size mismatch for 'sensor_msgs/msg/JointState'.
#   without the tail: read; with velocity and effort: read
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 rosbags==0.11.9 'ros-jazzy-rclpy[fastrtps]==7.1.6' \
    ros-jazzy-common-interfaces==5.3.6
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from rclpy.serialization import serialize_message
from rosbags.typesys import get_typestore, Stores
from sensor_msgs.msg import JointState

KIND = 'sensor_msgs/msg/JointState'
STORE = get_typestore(Stores.ROS2_JAZZY)
PLACES = [0.1, 0.2]


def by_rclpy(**lists: list[float]) -> bytes:
    """Return the message of two joints as rclpy serialises it."""
    return serialize_message(JointState(name=['pan', 'tilt'], position=PLACES, **lists))


def read(data: bytes) -> str:
    """Return what rosbags says to it."""
    try:
        found = STORE.deserialize_cdr(data, KIND)
    except Exception as error:
        return f'{type(error).__name__}, {error}'
    return 'read' if found.position.tolist() == PLACES else 'read, and wrong'


types = STORE.types
header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), '')
message = types[KIND](header, ['pan', 'tilt'], np.array(PLACES), np.zeros(0), np.zeros(0))
right = len(STORE.serialize_cdr(message, KIND))
alone = by_rclpy()
cut, whole = read(alone[:right]), read(by_rclpy(velocity=PLACES, effort=PLACES))
print(f'serialised by rclpy: {len(alone)} bytes, by rosbags: {right}')
print(read(alone))
print(f'without the tail: {cut}; with velocity and effort: {whole}')
if len(alone) == right or read(alone) == 'read' or (cut, whole) != ('read', 'read'):
    raise SystemExit('A message is as long as it is by now, or rosbags does not mind.')
END

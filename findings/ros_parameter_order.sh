#!/usr/bin/env bash
# Whether -p wins over a parameter file depends on an unrelated -p further to the left.
#
# Expected: of several values for one parameter on the command line the last one holds.
# Happens: rcl keeps a set of values for each node name or wildcard, in the order in which those
# first came, and the last set holds. A -p is of the set "/**". The first -p of all makes that set,
# so that if it stands before a file that names the node, each later -p is put in front of the file
# as well.
# Matters: a line of a launch file that sets use_sim_time takes away what somebody appends to it.
#
# rclpy 7.1.6 of ROS 2 Jazzy, camera.yaml has "camera: {ros__parameters: {gain: 5}}":
#   --params-file camera.yaml -p gain:=3: 3
#   -p other:=1 --params-file camera.yaml -p gain:=3: 5
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6'
export ROS_LOG_DIR=$folder ROS_AUTOMATIC_DISCOVERY_RANGE=OFF
cd "$folder"
printf 'camera:\n  ros__parameters:\n    gain: 5\n' >camera.yaml
"$folder/venv/bin/python" -I - <<'END'
import rclpy
from rclpy.context import Context
from rclpy.node import Node


def gain(words: str) -> int:
    """Return the gain of a node that was started with these words."""
    context = Context()
    rclpy.init(args=['--ros-args', *words.split()], context=context)
    node = Node('camera', context=context, automatically_declare_parameters_from_overrides=True)
    value = node.get_parameter('gain').value
    node.destroy_node()
    context.shutdown()
    return value


found = []
for words in ('--params-file camera.yaml -p gain:=3',
              '-p other:=1 --params-file camera.yaml -p gain:=3'):
    found.append(gain(words))
    print(f'{words}: {found[-1]}')
if found != [3, 5]:
    raise SystemExit('The last value of the command line holds by now.')
END

#!/usr/bin/env bash
# A ROS 2 parameter whose default is an empty list is one of bytes, and takes no names.
#
# Expected: declare_parameter('lights', []) declares a list; its type is that of the first value it
# is given, or there is an error that asks for one.
# Happens: an empty list counts as bytes, as nothing in it is not a byte, and the type is fixed
# then: names are refused from there on.
# Matters: a node that starts with no lights can never be told any. It takes
# ParameterDescriptor(type=PARAMETER_STRING_ARRAY), or Parameter.Type.STRING_ARRAY for the value.
#
# rclpy 7.1.6 of ROS 2 Jazzy:
#   BYTE_ARRAY
#   ['port']: Wrong parameter type, expected 'Type.BYTE_ARRAY' got 'Type.STRING_ARRAY'
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6'
export ROS_LOG_DIR=$folder ROS_AUTOMATIC_DISCOVERY_RANGE=OFF
"$folder/venv/bin/python" -I - <<'END'
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

rclpy.init()
node = Node('listener')
declared = node.declare_parameter('lights', []).type_.name
print(declared)
result = node.set_parameters([Parameter('lights', value=['port'])])[0]
print(f"['port']: {result.reason}")
node.destroy_node()
rclpy.shutdown()
if declared != 'BYTE_ARRAY' or result.successful:
    raise SystemExit('An empty list is no longer declared as bytes.')
END

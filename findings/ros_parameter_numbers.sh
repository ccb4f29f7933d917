#!/usr/bin/env bash
# ROS 2 reads the parameter 0101 as 65, 0108 as 108.0, y as true and 0x1p3 as 8.0.
#
# Expected: 0101 and 0108 are of one type, and the second is 108 if it is a number at all; y is a
# letter.
# Happens: rcl tries C's strtol with any base, then strtod, for whatever is not in quotes. So a
# number with a leading zero is octal if its digits allow it, and else decimal and a double; C's
# hexadecimal floats, nan and infinity without a dot are numbers; y, n, on and off are booleans.
# Matters: the code of a light is such a number. 0101 is another pattern, 0108 another type, with
# no complaint unless the node declared one. In quotes, "0101", it is text.
#
# rclpy 7.1.6 of ROS 2 Jazzy:
#   0101: INTEGER 65
#   0108: DOUBLE 108.0
#   0x1p3: DOUBLE 8.0
#   nan: DOUBLE nan
#   y: BOOL True
#   "0101": STRING 0101
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6'
export ROS_LOG_DIR=$folder ROS_AUTOMATIC_DISCOVERY_RANGE=OFF
"$folder/venv/bin/python" -I - <<'END'
import rclpy
from rclpy.context import Context
from rclpy.node import Node


def read(text: str) -> str:
    """Return the type and value of a parameter that is given as this text."""
    context = Context()
    rclpy.init(args=['--ros-args', '-p', f'given:={text}'], context=context)
    node = Node('reader', context=context, automatically_declare_parameters_from_overrides=True)
    parameter = node.get_parameter('given')
    node.destroy_node()
    context.shutdown()
    return f'{parameter.type_.name} {parameter.value}'


EXPECTED = {
    '0101': 'INTEGER 65', '0108': 'DOUBLE 108.0', '0x1p3': 'DOUBLE 8.0', 'nan': 'DOUBLE nan',
    'y': 'BOOL True', '"0101"': 'STRING 0101',
}
found = {text: read(text) for text in EXPECTED}
print(*(f'{text}: {what}' for text, what in found.items()), sep='\n')
if found != EXPECTED:
    raise SystemExit('ROS 2 no longer reads these parameters as described.')
END

#!/usr/bin/env bash
# Fast DDS writes its errors into the output of the program, between the data.
#
# Expected: what goes wrong in a library is told on the standard error, as ROS 2 itself does, so
# that the standard output of a node, a table say, can go into a file or a pipe.
# Happens: errors of Fast DDS are on the standard output, with codes for colours, in a file as well.
# Matters: a table of bearings begins with a line that is none, on a machine where, say, the file of
# profiles is missing; and who looks at the standard error alone sees no reason. A profile can name
# the consumer StdoutErrConsumer in its <log>; one that is missing cannot.
#
# rclpy 7.1.6 of ROS 2 Jazzy, a node that prints "0.1,0.2" with profiles that are not there:
#   standard output: 2 lines, 1 of them with "Error"
#   standard error: 0 lines
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6'
export ROS_LOG_DIR=$folder ROS_AUTOMATIC_DISCOVERY_RANGE=OFF
cat >"$folder/node.py" <<'END'
import rclpy
from rclpy.node import Node

rclpy.init()
node = Node('light')
print('0.1,0.2')
node.destroy_node()
rclpy.shutdown()
END
FASTRTPS_DEFAULT_PROFILES_FILE=$folder/none.xml "$folder/venv/bin/python" -I "$folder/node.py" \
    >"$folder/output" 2>"$folder/error"
lines=$(wc -l <"$folder/output")
errors=$(grep -c Error "$folder/output" || true)
others=$(wc -l <"$folder/error")
echo "standard output: $lines lines, $errors of them with \"Error\""
echo "standard error: $others lines"
if [ "$lines $errors $others" != '2 1 0' ]; then
    echo 'Errors of Fast DDS are no longer on the standard output.' >&2
    exit 1
fi

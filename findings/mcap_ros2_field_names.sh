#!/usr/bin/env bash
# mcap-ros2-support writes a camera_info without its calibration if K is not spelt k.
#
# Expected: a message is a dictionary by its definition; a name that is not in it, or a matrix with
# too few numbers, is an error.
# Happens: names that are not known are dropped, those that are missing become 0 or empty, and
# short arrays are filled with zeros. K, D, R and P were the names of ROS 1.
# Matters: the bag is valid and has a camera matrix of zeros, which by convention means that the
# camera was not calibrated. Covariances of six numbers for 36 pass likewise.
#
# mcap-ros2-support 0.6.0, mcap 1.6.0, what was read of K = 700, 0, 320, ...:
#   k: 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0
#   r, of which one number was given: 1.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    mcap==1.6.0 mcap-ros2-support==0.6.0
"$folder/venv/bin/python" -I - <<'END'
from io import BytesIO

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer

MATRIX = [700.0, 0.0, 320.0, 0.0, 700.0, 240.0, 0.0, 0.0, 1.0]

bag = BytesIO()
writer = Writer(bag)
schema = writer.register_msgdef('example_msgs/msg/Camera', 'float64[9] k\nfloat64[9] r\n')
writer.write_message('/camera_info', schema, {'K': MATRIX, 'r': [1.0]})
writer.finish()

bag.seek(0)
reader = make_reader(bag, decoder_factories=[DecoderFactory()])
message = next(reader.iter_decoded_messages()).decoded_message
print('k:', *message.k)
print('r, of which one number was given:', *message.r)
if list(message.k) != [0.0] * 9 or list(message.r) != [1.0] + [0.0] * 8:
    raise SystemExit('mcap-ros2-support no longer drops unknown names and fills short arrays.')
END

#!/usr/bin/env bash
# rosbags-image turns a 16-bit PNG of a bag into 8 bits, as if the message were mono8.
#
# Expected: message_to_cvimage of a CompressedImage with format 'mono16; png compressed' is uint16,
# as it is for an Image with encoding mono16.
# Happens: whatever the format says, the file is decoded to 8 bits, which keeps the upper byte.
# Matters: of the 12 bits of a camera 4 are left, and nothing looks wrong in a viewer.
#
# rosbags-image 0.10.4, rosbags 0.11.9, pixels 0, 100, 1000, 4095 in DN:
#   Image: uint16 0 100 1000 4095
#   CompressedImage: uint8 0 0 3 15
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94 rosbags==0.11.9 rosbags-image==0.10.4
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np
from rosbags.image import message_to_cvimage
from rosbags.typesys import get_typestore, Stores

PIXELS = np.array([[0, 100, 1000, 4095]], np.uint16)
types = get_typestore(Stores.ROS2_JAZZY).types
Image, CompressedImage = types['sensor_msgs/msg/Image'], types['sensor_msgs/msg/CompressedImage']
header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](1, 0), 'camera')

raw = Image(header, 1, 4, 'mono16', 0, 8, np.frombuffer(PIXELS.tobytes(), np.uint8))
png = CompressedImage(header, 'mono16; png compressed ', cv2.imencode('.png', PIXELS)[1])
found = [message_to_cvimage(message) for message in (raw, png)]
for name, pixels in zip(('Image', 'CompressedImage'), found):
    print(f'{name}:', pixels.dtype, *pixels.ravel())

if not (np.array_equal(found[0], PIXELS) and found[1].dtype == np.uint8
        and np.array_equal(found[1], PIXELS >> 8)):
    raise SystemExit('rosbags-image no longer cuts a 16-bit PNG to 8 bits.')
END

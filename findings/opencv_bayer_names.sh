#!/usr/bin/env bash
# cv2.COLOR_BayerRG2BGR is not for a sensor with the pattern RGGB: red and blue are exchanged.
#
# Expected: BayerRG is the pattern that begins with red and green, RGGB, as cameras (BayerRG8) and
# ROS (bayer_rggb8) name it.
# Happens: OpenCV names the pattern by two pixels of the second row, from the second column on: RG
# is BGGR. The longer names, as COLOR_BayerRGGB2BGR, are the usual ones.
# Matters: grey and green scenes look right, and a red light is a blue one. Two such errors cancel
# each other, BayerRG2RGB for BGR, until somebody corrects one of them.
#
# OpenCV 4.14.0, 200 DN at the red pixels of RGGB, as blue, green, red:
#   COLOR_BayerRG2BGR: 200 0 0
#   COLOR_BayerRGGB2BGR: 0 0 200
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

raw = np.zeros((8, 8), np.uint8)
raw[::2, ::2] = 200  # DN, red of RGGB

found = []
for name in ('COLOR_BayerRG2BGR', 'COLOR_BayerRGGB2BGR'):
    found.append(cv2.cvtColor(raw, getattr(cv2, name))[4, 4].tolist())
    print(f'{name}:', *found[-1])
if found != [[200, 0, 0], [0, 0, 200]]:
    raise SystemExit('COLOR_BayerRG2BGR no longer exchanges red and blue of RGGB.')
END

#!/usr/bin/env bash
# cv2.min, max and inRange of a colour picture apply a number to blue alone; add applies it to all.
#
# Expected: a number means the same for every function: all channels, as with numpy, or the first
# one and 0 for the others, as a Scalar of C++.
# Happens: add, subtract and multiply take it for all channels, min, max and inRange for the first
# one. The others are compared with 0.
# Matters: min(frame, 250) leaves green and red 0, max(frame, dark) raises blue only, and
# inRange(frame, 50, 150) finds nothing. With grey pictures, on which it was tried, all are right.
#
# OpenCV 4.14.0, a colour of 100 100 100:
#   add(colour, 20): 120 120 120
#   multiply(colour, 2): 200 200 200
#   max(colour, 120): 120 100 100
#   min(colour, 20): 20 0 0
#   inRange(colour, 50, 150): 0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

CALLS = (
    (cv2.add, (20,), [120, 120, 120]),
    (cv2.multiply, (2,), [200, 200, 200]),
    (cv2.max, (120,), [120, 100, 100]),
    (cv2.min, (20,), [20, 0, 0]),
    (cv2.inRange, (50, 150), [0]),
)

colour = np.full((2, 2, 3), 100, np.uint8)
as_described = True
for function, numbers, expected in CALLS:
    found = np.atleast_1d(function(colour, *numbers)[0, 0]).tolist()
    print(f"{function.__name__}(colour, {', '.join(map(str, numbers))}):", *found)
    as_described &= found == expected

if not as_described:
    raise SystemExit('cv2.min, max and inRange no longer apply a number to blue alone.')
END

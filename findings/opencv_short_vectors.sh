#!/usr/bin/env bash
# cv2.add of two vectors of three numbers has four.
#
# Expected: a sum has as many numbers as its terms, and their type; OpenCV makes it a column.
# Happens: so it is from five numbers on. Arrays of one dimension with up to four numbers are taken
# for a Scalar, which has four: zeros are put behind, and the type is float64. subtract, multiply
# and absdiff do so too.
# Matters: pixels, rays and translations have two or three numbers. A mean over the differences is
# too small, a loop over them too long.
#
# OpenCV 4.14.0, 1 2 3 ... of int32 added to itself:
#   2 numbers: 2 4 0 0 of float64
#   3 numbers: 2 4 6 0 of float64
#   4 numbers: 2 4 6 8 of float64
#   5 numbers: 2 4 6 8 10 of int32
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

as_described = True
for length in (2, 3, 4, 5):
    numbers = np.arange(1, length + 1, dtype=np.int32)
    found = cv2.add(numbers, numbers).ravel()
    print(f'{length} numbers:', *(f'{each:g}' for each in found), f'of {found.dtype}')
    as_described &= found.size == max(length, 4)
    as_described &= found.dtype == (np.int32 if length > 4 else np.float64)

if not as_described:
    raise SystemExit('cv2.add no longer makes four numbers of two or three.')
END

#!/usr/bin/env bash
# A picture shifted by cv2.warpAffine or cv2.remap moves in steps of 1/32 px; cubic, it overshoots.
#
# Expected: a picture of floats that is shifted by 0.01 px has its centroid 0.01 px further, and
# the cubic interpolation is the better one.
# Happens: places are rounded to 1/32 px first: 0.01 px moves nothing, 0.02 px moves 0.031. The
# cubic kernel is one that does not keep the centroid: 0.10 px becomes 0.128.
# Matters: this is how pictures are made to try a locator on. What is measured below 0.03 px is
# then the error of the shift.
#
# OpenCV 4.14.0, the shift wanted, that of the centroid with linear and with cubic interpolation:
#   0.010 px: 0.0000, 0.0000
#   0.020 px: 0.0313, 0.0454
#   0.050 px: 0.0625, 0.0881
#   0.100 px: 0.0938, 0.1283
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

Y, X = np.mgrid[:128, :128]
LIGHT = np.exp(-((X - 64.0) ** 2 + (Y - 60.0) ** 2) / 8).astype(np.float32)

found = []
for shift in (0.01, 0.02, 0.05, 0.1):
    matrix = np.float32([[1, 0, shift], [0, 1, 0]])
    moved = []
    for flags in (cv2.INTER_LINEAR, cv2.INTER_CUBIC):
        picture = cv2.warpAffine(LIGHT, matrix, (128, 128), flags=flags)
        moved.append((picture * X).sum() / picture.sum() - 64)
    print(f'{shift:.3f} px: {moved[0]:.4f}, {moved[1]:.4f}')
    found.append(moved)

if not np.allclose(found, [[0, 0], [1 / 32, 0.0454], [2 / 32, 0.0881], [3 / 32, 0.1283]],
                   atol=2e-3):
    raise SystemExit('warpAffine no longer shifts in steps of 1/32 px.')
END

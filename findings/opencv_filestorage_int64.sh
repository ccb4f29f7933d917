#!/usr/bin/env bash
# cv2.FileStorage keeps the lower half of 64-bit integers: time stamps come back as other numbers.
#
# Expected: a matrix of int64, numpy's own integer, is written as it is, or refused.
# Happens: it is written as 32-bit integers, each cut to its lower 32 bits, without a word. And a
# bool becomes a matrix of four numbers.
# Matters: stamps in nanoseconds beside a calibration are lost for good, those of a short test in
# microseconds seem to work: they fit.
#
# OpenCV 4.14.0 wrote
#   stamps: dt i, 1032178965, 16683
#   flipped: dt d, 1, 0, 0, 0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

STAMPS = np.array([[1_700_000_000_123_456_789, 16_683]])

storage = cv2.FileStorage('stamps.yaml', cv2.FILE_STORAGE_WRITE)
storage.write('stamps', STAMPS)
storage.write('flipped', True)
storage.release()
print(open('stamps.yaml').read())

storage = cv2.FileStorage('stamps.yaml', cv2.FILE_STORAGE_READ)
stamps = storage.getNode('stamps').mat()
flipped = storage.getNode('flipped')
if not (np.array_equal(stamps, STAMPS.astype(np.int32)) and flipped.isMap()
        and flipped.mat().ravel().tolist() == [1, 0, 0, 0]):
    raise SystemExit('FileStorage no longer cuts int64 to 32 bits and makes a matrix of a bool.')
END

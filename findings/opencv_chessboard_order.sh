#!/usr/bin/env bash
# findChessboardCornersSB lists the corners of a board from its other end.
#
# Expected: the corners in the order of findChessboardCorners, whose place it is to take.
# Happens: the first corner of the one is the last of the other, for boards of every parity, also
# those that look different upside down and so have a first corner.
# Matters: calibration does not mind, as long as one detector did all of it. A mixture of both, or
# a rig whose cameras use different ones, has boards that are turned by 180 degrees.
#
# OpenCV 4.14.0, first corner by findChessboardCorners and by findChessboardCornersSB:
#   8 x 6 corners: (80, 71), (291, 221)
#   7 x 6 corners: (80, 71), (261, 221)
#   8 x 5 corners: (80, 71), (291, 191)
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

SQUARE = 30.2  # px

as_described = True
for columns, rows in ((8, 6), (7, 6), (8, 5)):
    down, right = np.mgrid[:400, :400]
    column, row = (right - 50.3) // SQUARE, (down - 40.6) // SQUARE
    board = (column >= 0) & (column <= columns) & (row >= 0) & (row <= rows)
    light = np.where(board, (column + row) % 2 * 255, 255).astype(np.float32)
    picture = cv2.GaussianBlur(light, (0, 0), 1.0).round().astype(np.uint8)
    corners = [find(picture, (columns, rows))[1].reshape(-1, 2)
               for find in (cv2.findChessboardCorners, cv2.findChessboardCornersSB)]
    first = ', '.join(f'({x:.0f}, {y:.0f})' for x, y in (each[0] for each in corners))
    print(f'{columns} x {rows} corners: {first}')
    as_described &= np.abs(corners[0] - corners[1][::-1]).max() < 1

if not as_described:
    raise SystemExit('findChessboardCornersSB no longer lists the corners backwards.')
END

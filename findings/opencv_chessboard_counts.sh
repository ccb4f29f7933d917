#!/usr/bin/env bash
# findChessboardCornersSB finds a board that is not there when it is asked for fewer corners.
#
# Expected: of a board of 9 x 6 corners a grid of 6 x 4 is not found, as findChessboardCorners does
# not find it, or some 6 x 4 neighbouring corners are.
# Happens: True, and 24 corners that skip rows and columns of the board, some of them: neighbours
# are one square apart here and several there.
# Matters: rows and columns that were miscounted are not told. The corners are true ones, to a tenth
# of a pixel, and the calibration fits a lens to a board of unequal squares.
#
# OpenCV 4.14.0, a board of 9 x 6 corners with squares of 30.2 px, distances of neighbours:
#   asked for 9 x 6: findChessboardCorners: True, findChessboardCornersSB: True, 29.9 to 31.1 px
#   asked for 6 x 4: findChessboardCorners: False, findChessboardCornersSB: True, 29.9 to 121.0 px
#   asked for 5 x 4: findChessboardCorners: False, findChessboardCornersSB: True, 29.9 to 68.5 px
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

COLUMNS, ROWS = 9, 6  # of corners
SQUARE = 30.2  # px

down, right = np.mgrid[:400, :480]
column, row = (right - 50.3) // SQUARE, (down - 40.6) // SQUARE
board = (column >= 0) & (column <= COLUMNS) & (row >= 0) & (row <= ROWS)
light = np.where(board, (column + row) % 2 * 255, 255).astype(np.float32)
picture = cv2.GaussianBlur(light, (0, 0), 1.0).round().astype(np.uint8)

as_described = True
for columns, rows in ((9, 6), (6, 4), (5, 4)):
    older = cv2.findChessboardCorners(picture, (columns, rows))[0]
    newer, corners = cv2.findChessboardCornersSB(picture, (columns, rows))
    told = f'findChessboardCorners: {older}, findChessboardCornersSB: {newer}'
    whole = (columns, rows) == (COLUMNS, ROWS)
    as_described &= newer and older == whole
    if newer:
        grid = corners.reshape(rows, columns, 2)
        steps = np.concatenate(
            [np.linalg.norm(np.diff(grid, axis=axis), axis=2).ravel() for axis in (0, 1)]
        )
        told += f', {steps.min():.1f} to {steps.max():.1f} px'
        as_described &= bool((steps.max() < 1.1 * SQUARE) == whole)
    print(f'asked for {columns} x {rows}: {told}')

if not as_described:
    raise SystemExit('findChessboardCornersSB no longer finds a board of too few corners.')
END

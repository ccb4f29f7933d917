#!/usr/bin/env bash
# cv2.FileStorage of OpenCV 5 writes a vector in another form than a matrix, and than OpenCV 4.
#
# Expected: five distortion coefficients are an !!opencv-matrix of one column, as 4.14.0 writes them
# whether they are one-dimensional or not.
# Happens: arrays of one dimension, which OpenCV 5 has, are !!opencv-nd-matrix with sizes in place
# of rows and cols. The same numbers as a column, as calibrateCamera returns them, are as before.
# Matters: a ravel() in between, which did nothing before, decides whether other programs read the
# file: those that look for the tag, or for rows and cols. The matrix beside it is read.
#
# OpenCV 5.0.0 wrote
#   column: !!opencv-matrix, rows: 5, cols: 1
#   flat: !!opencv-nd-matrix, sizes: [ 5 ]
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==5.0.0.93
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

DISTORTION = np.array([[-0.1], [0.01], [0.0], [0.0], [0.0]])

storage = cv2.FileStorage('camera.yaml', cv2.FILE_STORAGE_WRITE)
storage.write('column', DISTORTION)
storage.write('flat', DISTORTION.ravel())
storage.release()
written = open('camera.yaml').read()
print(written)

column, _, flat = written.partition('flat:')
if not ('column: !!opencv-matrix' in column and 'rows: 5' in column and 'cols: 1' in column
        and flat.startswith(' !!opencv-nd-matrix') and 'sizes: [ 5 ]' in flat
        and 'rows' not in flat):
    raise SystemExit('FileStorage of OpenCV 5 no longer writes a vector in a form of its own.')
END

#!/usr/bin/env bash
# cv2.VideoWriter takes 16-bit frames for 8-bit ones: the film shows the left half, in stripes.
#
# Expected: a writer that was opened for 8 bits refuses a frame of uint16, as it refuses one of
# floats by an exception, or scales it.
# Happens: it is accepted, and its bytes are written as pixels: of each pixel the lower and then
# the upper byte, so that half a row fills the width.
# Matters: the film of a 12-bit camera plays and looks noisy; every light is at twice its column.
# VIDEOWRITER_PROP_DEPTH = cv2.CV_16U is what such a writer needs.
#
# OpenCV 4.14.0, a row of 64 pixels 0, 1024, 2048, ...:
#   read back: 0 0 0 4 0 8 0 12
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

FRAME = np.tile(np.arange(64, dtype=np.uint16) * 1024, (64, 1))

writer = cv2.VideoWriter('film.mkv', cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*'FFV1'), 60.0,
                         (64, 64), False)
writer.write(FRAME)
writer.release()
there, picture = cv2.VideoCapture('film.mkv').read()
if not there:
    raise SystemExit('A writer of 8 bits no longer takes a frame of 16 bits.')
print('read back:', *picture[0, :8, 0])
if not np.array_equal(picture[..., 0], FRAME.astype('<u2').view(np.uint8)[:, :64]):
    raise SystemExit('A writer of 8 bits no longer takes the bytes of 16 for pixels.')
END

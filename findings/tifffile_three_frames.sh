#!/usr/bin/env bash
# tifffile writes three grey frames, or four, as one colour picture.
#
# Expected: a stack of n frames becomes a file with n pages, whatever n is.
# Happens: with 3 or 4 frames the first dimension is taken for red, green, blue (and one more), and
# the file has a single page. tifffile itself reads the stack as it was; the warning that it gives
# is one that Python does not show by default.
# Matters: a series is tried with a few frames. Programs that read page by page find one where there
# were three; as a preview it is a picture in colours.
#
# tifffile 2026.3.3, OpenCV 4.14.0, pages of a stack of grey frames:
#   2 frames: 2 of 48 x 64
#   3 frames: 1 of 48 x 64 x 3
#   4 frames: 1 of 48 x 64 x 4
#   5 frames: 5 of 48 x 64
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94 tifffile==2026.3.3
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np
import tifffile

as_described = True
for frames in (2, 3, 4, 5):
    stack = np.zeros((frames, 48, 64), np.uint16)
    tifffile.imwrite('stack.tif', stack)
    as_described &= tifffile.imread('stack.tif').shape == stack.shape
    _, pages = cv2.imreadmulti('stack.tif', flags=cv2.IMREAD_UNCHANGED)
    print(f'{frames} frames: {len(pages)} of', ' x '.join(map(str, pages[0].shape)))
    as_described &= len(pages) == (1 if frames in (3, 4) else frames)

if not as_described:
    raise SystemExit('tifffile no longer writes three grey frames as one colour picture.')
END

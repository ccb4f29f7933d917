#!/usr/bin/env bash
# scipy.ndimage.label finds as many lights as pixels in a slanting trail that is one for others.
#
# Expected: pixels that touch at a corner belong together, as for OpenCV and scikit-image.
# Happens: by default only those with a common edge do. structure=np.ones((3, 3)) joins them.
# Matters: it shows in thin trails and in faint lights whose pixels are few; round, bright spots,
# with which it is tried, are the same for all three.
#
# SciPy 1.17.1, OpenCV 4.14.0, scikit-image 0.25.2, lights in a trail of 10 px, and in a round spot:
#   scipy.ndimage.label: 10, 1
#   cv2.connectedComponents: 1, 1
#   skimage.measure.label: 1, 1
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.17.1 opencv-python-headless==4.14.0.94 scikit-image==0.25.2
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np
import scipy.ndimage
import skimage.measure

y, x = np.mgrid[:20, :20]
TRAIL = ((x == y) & (x >= 5) & (x < 15)).astype(np.uint8)
SPOT = ((x - 10) ** 2 + (y - 10) ** 2 <= 16).astype(np.uint8)
COUNTS = {  # and what each one counts
    'scipy.ndimage.label': (lambda light: scipy.ndimage.label(light)[1], [10, 1]),
    'cv2.connectedComponents': (lambda light: cv2.connectedComponents(light)[0] - 1, [1, 1]),
    'skimage.measure.label': (lambda light: int(skimage.measure.label(light).max()), [1, 1]),
}

as_described = True
for name, (count, expected) in COUNTS.items():
    found = [count(light) for light in (TRAIL, SPOT)]
    print(f'{name}: {found[0]}, {found[1]}')
    as_described &= found == expected

if not as_described:
    raise SystemExit('scipy.ndimage.label no longer parts pixels that touch at a corner.')
END

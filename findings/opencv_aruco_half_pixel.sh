#!/usr/bin/env bash
# OpenCV's markers move by half a pixel when their corners are refined the way of AprilTag.
#
# Expected: cornerRefinementMethod changes how well the corners are placed, not what 0 means: in
# all of OpenCV that is the centre of the first pixel.
# Happens: CORNER_REFINE_APRILTAG counts from the edge of the first pixel, half a pixel further, as
# the AprilTag library itself does (pupil-apriltags 1.0.4 too), and OpenCV does not take it back.
# Matters: a bearing by such corners is out by half a pixel, to the right and down, in a camera
# that was calibrated with any other detector of OpenCV; no residual shows it.
#
# OpenCV 4.14.0, mean error of the centre over 40 places of a tag of 96 px:
#   NONE: +0.02, +0.01 px
#   SUBPIX: -0.01, +0.00 px
#   CONTOUR: -0.01, +0.01 px
#   APRILTAG: +0.48, +0.52 px
#   pupil-apriltags 1.0.4.post11: +0.47, +0.45 px
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94 pupil-apriltags==1.0.4.post11
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np
from pupil_apriltags import Detector

DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
TAG = cv2.aruco.generateImageMarker(DICTIONARY, 3, 8)
FINER = 4  # samples per pixel and axis
METHODS = ('NONE', 'SUBPIX', 'CONTOUR', 'APRILTAG')


def picture(x: float, y: float, cell: float) -> np.ndarray:
    """Return the tag with its first corner there, 0 being the centre of the first pixel."""
    down, right = (np.mgrid[:256 * FINER, :256 * FINER] + 0.5) / FINER - 0.5
    column = np.floor((right - x) / cell).astype(int)
    row = np.floor((down - y) / cell).astype(int)
    inside = (column >= 0) & (column < 8) & (row >= 0) & (row < 8)
    light = np.full(inside.shape, 255.0)
    light[inside] = TAG[row[inside], column[inside]]
    pixels = light.reshape(256, FINER, 256, FINER).mean((1, 3)).astype(np.float32)
    return cv2.GaussianBlur(pixels, (0, 0), 0.7).round().astype(np.uint8)


random = np.random.default_rng(0)
errors = {name: [] for name in (*METHODS, 'pupil-apriltags')}
library = Detector(families='tag36h11', quad_decimate=1.0)
for _ in range(40):
    corner = 80 + random.uniform(-0.5, 0.5, 2)
    cell = 12 + random.uniform(-1, 1)
    seen = picture(*corner, cell)
    true = corner + 4 * cell
    for name in METHODS:
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = getattr(cv2.aruco, f'CORNER_REFINE_{name}')
        corners = cv2.aruco.ArucoDetector(DICTIONARY, parameters).detectMarkers(seen)[0]
        errors[name].append(corners[0][0].mean(0) - true)
    errors['pupil-apriltags'].append(library.detect(seen)[0].center - true)

mean = {name: np.mean(each, axis=0) for name, each in errors.items()}
for name, (x, y) in mean.items():
    print(f'{name}: {x:+.2f}, {y:+.2f} px')
if not (all(np.all(np.abs(mean[name]) < 0.12) for name in METHODS[:3])
        and all(np.all(np.abs(mean[name] - 0.5) < 0.12)
                for name in ('APRILTAG', 'pupil-apriltags'))):
    raise SystemExit('The origin of the corners no longer depends on how they are refined.')
END

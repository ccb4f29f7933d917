#!/usr/bin/env bash
# cv2.fisheye.undistortPoints gives wrong rays at the rim of a wide lens, and no sign of it.
#
# Expected: the inverse of the fisheye model as far as the lens sees, or (-1e6, -1e6), its mark for
# a point that has no solution.
# Happens: the distorted angle is cut at 90 degrees before it is solved for. With k1 > 0 that is
# reached well inside the picture: all that lies further out comes back some degrees too near to
# the axis. With k1 < 0 a light beyond 90 degrees comes back mirrored, at the other side.
# Matters: a fisheye looks out for lights exactly there, and a servo would turn the wrong way.
#
# OpenCV 4.14.0:
#   k1 = +0.10, at 75.0 degrees: 75.0
#   k1 = +0.10, at 80.0 degrees: 77.2
#   k1 = +0.10, at 85.0 degrees: 78.2
#   k1 = -0.05, at 85.0 degrees: 85.0
#   k1 = -0.05, at 95.0 degrees: -85.0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

FOCAL_LENGTH = 300.0  # px
CENTRE = 640.0, 480.0  # px
CAMERA = np.array([[FOCAL_LENGTH, 0, CENTRE[0]], [0, FOCAL_LENGTH, CENTRE[1]], [0, 0, 1]])


def seen(k1: float, angle: float) -> float:
    """Return the angle that OpenCV finds for a light right of the axis, in degrees."""
    theta = np.radians(angle)
    u = CENTRE[0] + FOCAL_LENGTH * (theta + k1 * theta ** 3)
    ray = cv2.fisheye.undistortPoints(
        np.array([[[u, CENTRE[1]]]]), CAMERA, np.array([k1, 0, 0, 0]))
    found = float(np.degrees(np.arctan(ray[0, 0, 0])))
    print(f'k1 = {k1:+.2f}, at {angle} degrees: {found:.1f}')
    return found


as_described = (
    abs(seen(0.1, 75.0) - 75) < 0.01
    and abs(seen(0.1, 80.0) - 77.2) < 0.1
    and abs(seen(0.1, 85.0) - 78.2) < 0.1
    and abs(seen(-0.05, 85.0) - 85) < 0.01
    and abs(seen(-0.05, 95.0) + 85) < 0.01
)
if not as_described:
    raise SystemExit('fisheye.undistortPoints no longer cuts at 90 degrees as described.')
END

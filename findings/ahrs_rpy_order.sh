#!/usr/bin/env bash
# Two classes of the ahrs package take roll, pitch and yaw in opposite orders.
#
# Expected: Quaternion(rpy=angles) and DCM(rpy=angles), a quaternion and a matrix for the same
# three angles, are the same orientation.
# Happens: the quaternion turns by the first angle about x and by the last about z, the matrix by
# the first about z and by the last about x.
# Matters: the mounting of an IMU or a camera, three numbers from a data sheet, is another one
# wherever the matrix is used. A test whose roll and yaw are alike passes.
#
# ahrs 0.4.0, rpy of 20, 30 and 40 degrees, about x, y and z:
#   Quaternion: 20 30 40
#   DCM: 40 30 20
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 ahrs==0.4.0
"$folder/venv/bin/python" -I - <<'END'
from ahrs import DCM, Quaternion
import numpy as np

ANGLES = np.deg2rad([20.0, 30.0, 40.0])


def turns(matrix: np.ndarray) -> list[float]:
    """Return the turns about x, y and z that make a matrix, that about x first (degrees)."""
    x = np.arctan2(matrix[2, 1], matrix[2, 2])
    y = -np.arcsin(matrix[2, 0])
    z = np.arctan2(matrix[1, 0], matrix[0, 0])
    return np.rad2deg([x, y, z]).tolist()


found = []
for name, matrix in (('Quaternion', Quaternion(rpy=ANGLES).to_DCM()),
                     ('DCM', np.asarray(DCM(rpy=ANGLES)))):
    found.append(turns(matrix))
    print('{}: {:.0f} {:.0f} {:.0f}'.format(name, *found[-1]))

if not np.allclose(found, [[20, 30, 40], [40, 30, 20]]):
    raise SystemExit('Both classes take roll, pitch and yaw in the same order by now.')
END

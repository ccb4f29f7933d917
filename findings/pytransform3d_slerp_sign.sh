#!/usr/bin/env bash
# Half way between two orientations 0.2 rad apart, pytransform3d is 3.04 rad away from both.
#
# Expected: q and -q are one orientation, and quaternion_slerp takes the short way between two.
# Happens: the signs are taken as they are, and with opposite ones the way is the long one, unless
# shortest_path=True is given.
# Matters: trackers and filters hand over either sign, and a stored one that flips turns the camera
# through almost a full circle between two samples. A path by matrix_slerp has no signs to flip.
#
# pytransform3d 3.17.0, turn half way from 0 to 0.2 rad about z (rad):
#   end q: 0.10
#   end -q: -3.04
#   end -q, shortest_path=True: 0.10
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.15.3 pytransform3d==3.17.0
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from pytransform3d.rotations import (
    matrix_from_quaternion, quaternion_from_axis_angle, quaternion_slerp)

start = np.array([1.0, 0.0, 0.0, 0.0])
end = quaternion_from_axis_angle([0.0, 0.0, 1.0, 0.2])

found = []
for name, last, settings in (('end q', end, {}),
                             ('end -q', -end, {}),
                             ('end -q, shortest_path=True', -end, {'shortest_path': True})):
    half = matrix_from_quaternion(quaternion_slerp(start, last, 0.5, **settings))
    found.append(float(np.arctan2(half[1, 0], half[0, 0])))
    print(f'{name}: {found[-1]:.2f}')

if not np.allclose(found, [0.1, 0.1 - np.pi, 0.1]):
    raise SystemExit('quaternion_slerp takes the short way by now.')
END

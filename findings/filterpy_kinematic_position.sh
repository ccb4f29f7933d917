#!/usr/bin/env bash
# filterpy's ready-made filter of a plane measures the sum of x and y, twice.
#
# Expected: kinematic_kf(dim=2, order=1, dim_z=2) is a filter of position and velocity for
# positions (x, y): H has, says its help, one position per dimension.
# Happens: each row of H has a one at every position, so that both say x + y. The filter takes the
# pairs and settles where that sum fits best. With dim_z left at 1 there is one such row.
# Matters: nothing fails, the track is smooth and keeps to a diagonal of the picture. H is to be
# written by hand.
#
# filterpy 2.0.0, a light that stays at (30, 40):
#   H: [1 0 1 0] [1 0 1 0]
#   track: (17.5, 17.5)
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 scipy==1.15.3 filterpy==2.0.0
"$folder/venv/bin/python" -I - <<'END'
from filterpy.common import kinematic_kf
import numpy as np

LIGHT = np.array([30.0, 40.0])  # px

track = kinematic_kf(dim=2, order=1, dt=1.0, dim_z=2)
for _ in range(100):
    track.predict()
    track.update(LIGHT)
x, y = track.x[::2].ravel()
print('H:', *track.H.astype(int))
print(f'track: ({x:.1f}, {y:.1f})')

if not (np.array_equal(track.H, [[1, 0, 1, 0]] * 2) and abs(x - y) < 0.1 and abs(x - 17.5) < 0.1):
    raise SystemExit('kinematic_kf measures one position with each row by now.')
END

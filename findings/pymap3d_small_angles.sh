#!/usr/bin/env bash
# pymap3d gives a bearing of exactly 0 for a direction less than a milliradian off the axis.
#
# Expected: enu2aer of a unit vector is its azimuth and elevation; a direction has no length, and a
# vector of 1 m is as good as one of 1 km.
# Happens: components below 1 mm are put to 0 before the angles are taken, those of the unit vector
# too: azimuth and elevation are cut to 0 within 1 mrad of north and the horizon.
# Matters: that is where a servo holds its light. The error of the pointing seems to be 0.
#
# pymap3d 3.2.0, a light at 0.9 mrad in azimuth and elevation:
#   as a unit vector: 0.000, 0.000 mrad
#   the same a kilometre long: 0.900, 0.900 mrad
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    pymap3d==3.2.0
"$folder/venv/bin/python" -I - <<'END'
from math import cos, sin

import pymap3d

ANGLE = 0.9e-3  # rad
LIGHT = sin(ANGLE) * cos(ANGLE), cos(ANGLE) * cos(ANGLE), sin(ANGLE)  # east, north, up

found = []
for name, length in (('as a unit vector', 1.0), ('the same a kilometre long', 1e3)):
    azimuth, elevation, _ = pymap3d.enu2aer(*(length * each for each in LIGHT), deg=False)
    print(f'{name}: {1e3 * azimuth:.3f}, {1e3 * elevation:.3f} mrad')
    found += [azimuth, elevation]

if not (found[:2] == [0, 0] and all(abs(each - ANGLE) < 1e-9 for each in found[2:])):
    raise SystemExit('enu2aer no longer puts small angles of a unit vector to 0.')
END

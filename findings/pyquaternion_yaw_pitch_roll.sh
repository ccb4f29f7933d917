#!/usr/bin/env bash
# pyquaternion's yaw, pitch and roll are those of the other order of the three turns.
#
# Expected: yaw_pitch_roll are, as its help begins, angles of the convention z-y'-x'': a turn by
# yaw about z, by pitch about the new y and by roll about the new x is the quaternion again.
# Happens: they are those of x-y'-z'', where the roll comes first and the yaw last, as a product of
# matrices further down in the help has it.
# Matters: one turn alone is right, and small ones nearly are. A camera that looks 40 degrees to the
# side and 30 down, rolled by 20, is put 21 degrees off by who keeps to the name of the convention.
#
# pyquaternion 0.9.9, made of yaw, pitch and roll of 40, 30 and 20 degrees:
#   yaw_pitch_roll: 35.5 35.4 -2.8
#   as z-y'-x'': 21.4 degrees off
#   as x-y'-z'': 0.0 degrees off
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 pyquaternion==0.9.9
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from pyquaternion import Quaternion


def turn(axis: int, degrees: float) -> Quaternion:
    """Return a turn about x, y or z (0, 1 or 2)."""
    return Quaternion(axis=np.eye(3)[axis], degrees=degrees)


made = turn(2, 40) * turn(1, 30) * turn(0, 20)
yaw, pitch, roll = np.rad2deg(made.yaw_pitch_roll)
print(f'yaw_pitch_roll: {yaw:.1f} {pitch:.1f} {roll:.1f}')
found = []
for name, again in (("z-y'-x''", turn(2, yaw) * turn(1, pitch) * turn(0, roll)),
                    ("x-y'-z''", turn(0, roll) * turn(1, pitch) * turn(2, yaw))):
    found.append(abs((made.inverse * again).degrees))
    print(f'as {name}: {found[-1]:.1f} degrees off')

if not found[1] < 1e-6 < 20 < found[0]:
    raise SystemExit('The angles follow their convention by now.')
END

#!/usr/bin/env bash
# Pinocchio numbers the joints of a URDF by the alphabet of their names, not as they stand there.
#
# Expected: q[0] is the joint that comes first in the URDF, as other readers of URDF have it.
# Happens: joints of one link are sorted by their names: left_pan comes before right_pan, wherever
# they stand.
# Matters: of two cameras on one mast each gets the pan of the other, without an error, and a new
# name for a joint swaps them. Take the place in q from model.joints[model.getJointId(name)].idx_q.
#
# pin 4.1.0, yourdfpy 0.0.60, right_pan before left_pan in the URDF, angles 1.0 and 0.2:
#   Pinocchio: right 0.2, left 1.0
#   yourdfpy: right 1.0, left 0.2
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 yourdfpy==0.0.60 pin==4.1.0
"$folder/venv/bin/python" -I - <<'END'
from io import BytesIO

import numpy as np
import pinocchio
import yourdfpy

CAMERAS = 'right', 'left'
ANGLES = np.array([1.0, 0.2])
URDF = '<robot name="mast"><link name="mast"/>' + ''.join(
    f'<link name="{camera}"/><joint name="{camera}_pan" type="revolute">'
    f'<parent link="mast"/><child link="{camera}"/><axis xyz="0 0 1"/>'
    '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
    for camera in CAMERAS) + '</robot>'

model = pinocchio.buildModelFromXML(URDF)
data = model.createData()
pinocchio.framesForwardKinematics(model, data, ANGLES)
robot = yourdfpy.URDF.load(BytesIO(URDF.encode()), load_meshes=False)
robot.update_cfg(ANGLES)

found = []
for name, turns in (
        ('Pinocchio', [data.oMf[model.getFrameId(camera)].rotation for camera in CAMERAS]),
        ('yourdfpy', [robot.get_transform(camera, 'mast')[:3, :3] for camera in CAMERAS])):
    found.append([float(np.arctan2(turn[1, 0], turn[0, 0])) for turn in turns])
    print('{}: right {:.1f}, left {:.1f}'.format(name, *found[-1]))

if not np.allclose(found, [[0.2, 1.0], [1.0, 0.2]]):
    raise SystemExit('Pinocchio keeps the order of the URDF by now.')
END

#!/usr/bin/env bash
# pytransform3d stops a joint at its limit without a word, yourdfpy turns on.
#
# Expected: the pose of a camera on a pan unit, read from its URDF with the angle of the encoder,
# is that of the angle; if that is beyond the limits of the file, something fails or warns.
# Happens: set_joint of UrdfTransformManager cuts the angle to the limits. yourdfpy, from the same
# file, takes it as it is. Neither says a word.
# Matters: limits in a URDF are often those of the software, or a guess. Where the unit goes a bit
# further all bearings stay at the limit, and only there.
#
# pytransform3d 3.17.0 and yourdfpy 0.0.60, limits of 0.5 rad, turned to 0.7 rad:
#   pytransform3d: 0.5 rad
#   yourdfpy: 0.7 rad
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 lxml==6.0.2 pytransform3d==3.17.0 yourdfpy==0.0.60
"$folder/venv/bin/python" -I - "$folder" <<'END'
import sys
from pathlib import Path

import numpy as np
from pytransform3d.urdf import UrdfTransformManager
from yourdfpy import URDF

ANGLE = 0.7  # rad
MAST = """<robot name="mast">
  <link name="base"/>
  <link name="camera"/>
  <joint name="pan" type="revolute">
    <parent link="base"/>
    <child link="camera"/>
    <axis xyz="0 0 1"/>
    <limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>
  </joint>
</robot>"""

path = Path(sys.argv[1]) / 'mast.urdf'
path.write_text(MAST)

frames = UrdfTransformManager()
frames.load_urdf(MAST)
frames.set_joint('pan', ANGLE)
robot = URDF.load(str(path), load_meshes=False)
robot.update_cfg({'pan': ANGLE})

found = []
for name, pose in (('pytransform3d', frames.get_transform('camera', 'base')),
                   ('yourdfpy', robot.get_transform('camera', 'base'))):
    found.append(float(np.arctan2(pose[1, 0], pose[0, 0])))
    print(f'{name}: {found[-1]:.1f} rad')

if not np.allclose(found, [0.5, 0.7], atol=1e-9):
    raise SystemExit('pytransform3d turns a joint as yourdfpy does by now.')
END

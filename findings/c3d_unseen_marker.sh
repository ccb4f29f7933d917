#!/usr/bin/env bash
# A marker that was not seen stands at the origin when c3d reads the file, with ezc3d it is NaN.
#
# Expected: in a motion capture file, a frame in which a camera rig lost a marker has no place for
# it: NaN, whichever package reads, or whichever wrote it.
# Happens: the format marks such a point by a residual of -1, and c3d hands out what lies beside
# it, mostly zeros, as x, y and z. That ezc3d took NaN when it wrote makes no difference.
# Matters: markers as the truth for a tracker: the mean of a body is drawn towards the origin of
# the room, its speed jumps, and no NaN is there to be seen. Look at the fourth column (-1).
#
# ezc3d 1.7.2 and c3d 0.6.0, a marker at (1, 2, 3), lost in the second of three frames:
#   ezc3d: (1 2 3) (nan nan nan) (1 2 3)
#   c3d: (1 2 3) (0 0 0) (1 2 3)
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 c3d==0.6.0 ezc3d==1.7.2
"$folder/venv/bin/python" -I - "$folder" <<'END'
import sys
import warnings
from pathlib import Path

import c3d
import ezc3d
import numpy as np

warnings.filterwarnings('ignore', 'No analog data found')
path = Path(sys.argv[1]) / 'rig.c3d'
points = np.ones((4, 1, 3))  # x, y, z and 1 (mm) of the marker in three frames
points[:3, 0] = np.array([[1.0], [2.0], [3.0]])
points[:3, 0, 1] = np.nan
file = ezc3d.c3d()
file['parameters']['POINT']['RATE']['value'] = [100.0]
file['parameters']['POINT']['LABELS']['value'] = ['light']
file['data']['points'] = points
file.write(str(path))

one = ezc3d.c3d(str(path))['data']['points'][:3, 0].T
with path.open('rb') as opened:
    other = np.array([seen[0, :3] for _, seen, _ in c3d.Reader(opened).read_frames()])
for name, places in (('ezc3d', one), ('c3d', other)):
    print(f'{name}:', *('({:.0f} {:.0f} {:.0f})'.format(*place) for place in places))

if not (np.isnan(one[1]).all() and (other[1] == 0).all()):
    raise SystemExit('c3d no longer puts an unseen marker at the origin.')
END

#!/usr/bin/env bash
# aotools finds another centroid for a picture in a stack than alone, and changes the stack.
#
# Expected: centre_of_gravity takes one picture or many: the same picture has the same centroid
# either way, and pictures are not changed.
# Happens: with a threshold, a single picture has it subtracted. In a stack it is not subtracted,
# and what lies below is set to zero in the caller's array.
# Matters: a calibration frame by frame and a run on stacks weigh the rim of the spot differently,
# and who takes the background or another centroid from the same stack later finds zeros.
#
# aotools 1.0.8, a spot at (12.4, 9.2) on a background, threshold 0.3:
#   alone: 12.411, 9.205
#   in a stack: 12.389, 9.208
#   changed in the stack: 422 of 441 pixels
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 aotools==1.0.8
"$folder/venv/bin/python" -I - <<'END'
from aotools.image_processing.centroiders import centre_of_gravity
import numpy as np

y, x = np.mgrid[:21, :21]
spot = 10 + 100 * np.exp(-((x - 12.4) ** 2 + (y - 9.2) ** 2) / 4)
stack = np.stack([spot])
alone = centre_of_gravity(spot, threshold=0.3)
together = centre_of_gravity(stack, threshold=0.3)[:, 0]
changed = np.count_nonzero(stack[0] != spot)
print('alone: {:.3f}, {:.3f}'.format(*alone))
print('in a stack: {:.3f}, {:.3f}'.format(*together))
print(f'changed in the stack: {changed} of {spot.size} pixels')

if not (np.abs(alone - together).max() > 0.01 and changed > 300):
    raise SystemExit('A stack is taken as its pictures are by now.')
END

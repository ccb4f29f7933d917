#!/usr/bin/env bash
# Orientation filters take a slow steady turn for the bias of the gyroscope and cancel it.
#
# Expected: the bias of a gyroscope is estimated while the sensor rests, and one that turns by 1
# degree/s, far above its noise, does not rest. A pan of half a minute comes out as 30 degrees.
# Happens: at rest is, by default, whatever turns by less than 2 degrees/s (VQF) or 3 degrees/s
# (imufusion's Bias) for a few seconds. The rate becomes the bias. The filter that knows the whole
# recording takes away even the start.
# Matters: a mast that follows a slow light, or a turntable, seems to stand. Put the thresholds
# between noise and the slowest turn, or leave the estimate out.
#
# vqf 2.1.2 and imufusion 1.3.3, without noise, 30 s at 1 and 4 degrees/s:
#   vqf: 1.7 and 120.0 degrees
#   offlineVQF: 0.1 and 120.0 degrees
#   imufusion: 10.7 and 120.0 degrees
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 vqf==2.1.2 imufusion==1.3.3
"$folder/venv/bin/python" -I - <<'END'
import imufusion
import numpy as np
from vqf import offlineVQF, VQF

STEP = 0.01  # s
COUNT = 3000
GRAVITY = 9.81  # m/s^2


def turn(quaternions: np.ndarray) -> float:
    """Return by how many degrees quaternions (w, x, y, z) turn from the first to the last."""
    yaw = np.unwrap(2 * np.arctan2(quaternions[:, 3], quaternions[:, 0]))
    return float(np.rad2deg(yaw[-1] - yaw[0]))


found = {'vqf': [], 'offlineVQF': [], 'imufusion': []}
for rate in (1.0, 4.0):  # degrees/s
    rates = np.tile([0.0, 0.0, rate], (COUNT, 1))
    up = np.tile([0.0, 0.0, 1.0], (COUNT, 1))
    found['vqf'].append(turn(VQF(STEP).updateBatch(np.deg2rad(rates), GRAVITY * up)['quat6D']))
    found['offlineVQF'].append(
        turn(offlineVQF(np.deg2rad(rates), GRAVITY * up, None, STEP)['quat6D']))
    bias = imufusion.Bias()
    found['imufusion'].append(STEP * sum(float(bias.update(each)[2]) for each in rates))
for name, turns in found.items():
    print('{}: {:.1f} and {:.1f} degrees'.format(name, *turns))

if not all(slow < 12 and abs(fast - 120) < 1 for slow, fast in found.values()):
    raise SystemExit('A slow turn is no longer taken for the bias.')
END

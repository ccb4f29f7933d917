#!/usr/bin/env bash
# pykalman drops a whole measurement if one value of it is masked.
#
# Expected: in a masked array those values are left out that are masked; of two bearings of a
# light, from two cameras, the one that is there is used.
# Happens: a row with any masked value counts as none at all. A NaN instead of the mask is no value
# left out either: it makes the track NaN from there on.
# Matters: while one of the two cameras is covered the track flies on blindly, as if both were. The
# matrix of such a step is to be made smaller by hand (filter_update).
#
# pykalman 0.11.2, x and y measured as 1, then y alone as 2 for 20 steps:
#   x masked: y stays at 0.99
#   both there: y comes to 2.00
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 pykalman==0.11.2
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from pykalman import KalmanFilter

light = KalmanFilter(
    transition_matrices=np.eye(2), observation_matrices=np.eye(2), initial_state_mean=[0, 0],
    initial_state_covariance=np.eye(2), transition_covariance=0.01 * np.eye(2),
    observation_covariance=0.01 * np.eye(2))
measured = np.ma.array([[1.0, 1.0]] + [[1.0, 2.0]] * 20)
whole = light.filter(measured)[0][-1, 1]
measured[1:, 0] = np.ma.masked
half = light.filter(measured)[0][-1, 1]
print(f'x masked: y stays at {half:.2f}')
print(f'both there: y comes to {whole:.2f}')

if not (abs(half - 0.99) < 0.01 and abs(whole - 2) < 0.01):
    raise SystemExit('A masked value no longer takes its row along.')
END

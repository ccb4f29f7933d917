#!/usr/bin/env bash
# Filters of the ahrs package turn a pan to the left, to the right, or not at all.
#
# Expected: the filters of one package, whose calls are alike, give the same orientation for the
# same samples: a level sensor that turns by 90 degrees about its upward axis has a yaw of 90.
# Happens: AQUA returns the inverse, from the world to the sensor. Complementary without a
# magnetometer takes a part of the yaw from the accelerometer at each step, where it is always 0:
# the turn is gone after a few samples.
# Matters: who tries another filter for its drift gets bearings of the other sign. That the tilt is
# right tells nothing about the second one.
#
# ahrs 0.4.0, yaw after a turn of 90 degrees:
#   Madgwick: 90
#   Mahony: 90
#   EKF: 90
#   Complementary: 0
#   AQUA: -90
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 ahrs==0.4.0
"$folder/venv/bin/python" -I - <<'END'
from ahrs import filters
import numpy as np

RATE = 100.0  # Hz
EXPECTED = {'Madgwick': 90, 'Mahony': 90, 'EKF': 90, 'Complementary': 0, 'AQUA': -90}

gyroscope = np.zeros((1000, 3))  # rad/s
gyroscope[300:400, 2] = np.pi / 2
accelerometer = np.tile([0.0, 0.0, 9.81], (1000, 1))  # m/s^2

as_described = True
for name, expected in EXPECTED.items():
    course = getattr(filters, name)(gyr=gyroscope, acc=accelerometer, frequency=RATE)
    w, _, _, z = course.Q[-1]
    yaw = np.rad2deg(2 * np.arctan2(z, w))
    yaw -= 360 * round(yaw / 360)
    print(f'{name}: {round(yaw)}')
    as_described &= abs(yaw - expected) < 2

if not as_described:
    raise SystemExit('The filters of ahrs turn otherwise by now.')
END

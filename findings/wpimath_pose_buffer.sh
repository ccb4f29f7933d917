#!/usr/bin/env bash
# A buffer of poses in time answers for a time it does not have, with the pose that is nearest.
#
# Expected: TimeInterpolatablePose3dBuffer.sample gives a pose between two that were added, and
# None for a time before or after all of them, as its type (a pose or None) lets one think.
# Happens: None is for an empty buffer alone. For other times the oldest or the newest pose comes,
# however far away.
# Matters: a frame whose stamp is of another clock, or that comes later than the history is long,
# gets a pose, and the light a place, instead of an error. Compare with the times of the samples
# first.
#
# robotpy-wpimath 2026.2.2, history of 1.5 s, poses at 0 to 10 s with x as the time:
#   sample(9.75): x = 9.75
#   sample(5.00): x = 8.50
#   sample(1700000000.00): x = 10.00
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    robotpy-wpimath==2026.2.2
"$folder/venv/bin/python" -I - <<'END'
from wpimath.geometry import Pose3d, Rotation3d
from wpimath.interpolation import TimeInterpolatablePose3dBuffer

poses = TimeInterpolatablePose3dBuffer(1.5)
for half in range(21):
    poses.addSample(half / 2, Pose3d(half / 2, 0, 0, Rotation3d()))

found = []
for time in (9.75, 5.0, 1.7e9):
    pose = poses.sample(time)
    found.append(None if pose is None else round(pose.X(), 3))
    print(f'sample({time:.2f}): x = {found[-1]:.2f}' if pose else f'sample({time:.2f}): None')

if found != [9.75, 8.5, 10.0]:
    raise SystemExit('Times outside the buffer no longer get the nearest pose.')
END

#!/usr/bin/env bash
# evo pairs one pose of the reference with several of the estimate, if the reference is longer.
#
# Expected: associate_trajectories makes pairs of poses; each pose is in one pair at most.
# Happens: for each pose of the trajectory that has fewer of them the nearest one of the other is
# taken, however often it was taken before. A reference of 10 Hz that was recorded long enough has
# more poses than an estimate of 100 Hz, and then serves several of them each.
# Matters: an estimate without any fault is charged with the motion between the poses, and the
# charge depends on how long the reference ran on after the estimate ended.
#
# evo 1.38.1, an exact estimate, 2 s at 100 Hz and 1 m/s, max_diff 0.05 s, reference of 10 Hz:
#   reference of 2 s: 20 pairs, 20 poses of it, error 0.0 mm
#   reference of 60 s: 193 pairs, 21 poses of it, error 28.1 mm
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.15.3 pandas==2.3.3 evo==1.38.1
HOME=$folder "$folder/venv/bin/python" -I - <<'END'
from evo.core import sync
from evo.core.metrics import APE, PoseRelation, StatisticsType
from evo.core.trajectory import PoseTrajectory3D
import numpy as np

SPEED = 1.0  # m/s


def walk(duration: float, rate: float) -> PoseTrajectory3D:
    """Return a straight walk along x."""
    times = np.arange(round(duration * rate)) / rate
    zeros = np.zeros_like(times)
    return PoseTrajectory3D(
        positions_xyz=np.column_stack([SPEED * times, zeros, zeros]),
        orientations_quat_wxyz=np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1)), timestamps=times)


found = []
for duration in (2, 60):
    pairs = sync.associate_trajectories(walk(duration, 10.0), walk(2.0, 100.0), max_diff=0.05)
    error = APE(PoseRelation.translation_part)
    error.process_data(pairs)
    millimetres = 1e3 * error.get_statistic(StatisticsType.rmse)
    reference = pairs[0].timestamps
    found.append((len(reference), len(np.unique(reference)), millimetres))
    print('reference of {} s: {} pairs, {} poses of it, error {:.1f} mm'.format(
        duration, *found[-1]))

(pairs, poses, error), (more_pairs, more_poses, more_error) = found
if not (pairs == poses and error < 1e-6 and more_pairs > 5 * more_poses and more_error > 20):
    raise SystemExit('evo no longer uses a pose of the reference more than once.')
END

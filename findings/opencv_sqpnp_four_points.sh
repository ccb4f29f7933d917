#!/usr/bin/env bash
# SQPnP misses the pose of four points in one of forty views, without any noise.
#
# Expected: SOLVEPNP_SQPNP is a global solver for 3 points or more; four points that lie in no plane
# and are seen without error have one pose, which it finds, and its residuals are zero.
# Happens: in about 2 % of the views it returns another pose, centimetres to decimetres off at 2 m,
# with residuals that the true pose does not have, and says that it succeeded. With six points all
# poses are right.
# Matters: a body of four lights jumps now and then, and who refines (SOLVEPNP_ITERATIVE) from there
# may stay there. Look at the residuals, or try the candidates of P3P as well.
#
# OpenCV 4.12.0, 2000 random bodies of 0.3 m at 2 m:
#   4 points: 46 poses wrong, none of which has the residuals of the true one
#   6 points: 0 poses wrong
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 opencv-python-headless==4.12.0.88
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

VIEWS = 2000
CAMERA = np.eye(3)


def wrong(points: int) -> tuple[int, int]:
    """Return how many poses are wrong, and how many of them explain what was seen."""
    rng = np.random.default_rng(0)
    count = explained = 0
    for _ in range(VIEWS):
        body = rng.uniform(-0.15, 0.15, (points, 3))
        turn = rng.standard_normal(3)
        turn *= rng.uniform(0.0, 1.0) / np.linalg.norm(turn)
        place = np.array([0.0, 0.0, 2.0])
        seen = cv2.projectPoints(body, turn, place, CAMERA, None)[0]
        done, its_turn, its_place = cv2.solvePnP(
            body, seen, CAMERA, None, flags=cv2.SOLVEPNP_SQPNP)
        assert done
        if np.linalg.norm(its_place.ravel() - place) > 1e-3:
            again = cv2.projectPoints(body, its_turn, its_place, CAMERA, None)[0]
            count += 1
            explained += np.abs(again - seen).max() < 1e-6
    return count, explained


four, six = wrong(4), wrong(6)
print(f'4 points: {four[0]} poses wrong, {four[1] or "none"} of which has the residuals of the '
      'true one')
print(f'6 points: {six[0]} poses wrong')
if not (10 < four[0] < 200 and four[1] == 0 and six[0] == 0):
    raise SystemExit('SQPnP finds the pose of four points as often as that of six by now.')
END

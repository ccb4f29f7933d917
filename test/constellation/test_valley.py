"""The far end of a valley: another pose that the covariance of the one does not tell of."""

from __future__ import annotations

from typing import Any

from blob_tracker.constellation.likelihood import fit
from blob_tracker.constellation.valley import far_end, turn_between
from blob_tracker.kernel import Array
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

SIGMA = 1e-4  # rad
PLACES = np.array([[0.1, 0.1, 0.0], [-0.1, 0.12, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.09, 0.0]])
AMBIGUOUS = 25.0
NOTHING: Array = np.zeros(4)
STILL: Array = np.zeros(6)


def bottom(turn: Rotation, distance: float) -> tuple[Any, Any]:
    """Return what is seen of lights in a plane, and their pose of greatest likelihood."""
    points = turn.apply(PLACES) + [0.0, 0.0, distance]
    rays = points / np.linalg.norm(points, axis=1, keepdims=True)
    across = np.cross([0.0, 1.0, 0.0], rays)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    bases = np.ascontiguousarray(np.stack([across, np.cross(rays, across)], axis=2))
    noise = np.broadcast_to(SIGMA**2 * np.eye(2), (4, 2, 2)).copy()
    seen: Any = (PLACES, NOTHING, rays, bases, noise, NOTHING, np.ones(4), np.zeros(2), STILL)
    pose: Any = turn.as_matrix(), np.array([0.0, 0.0, distance]), np.zeros(6)
    arguments = *seen, *pose, np.empty((12, 12)), np.empty(4)
    fit(*arguments)
    return seen, pose


@pytest.mark.parametrize('tilt, distance, has_end', [(0.6, 1.0, False), (0.01, 6.0, True)])
def test_a_plane_that_is_seen_from_the_front_has_another_end(
    tilt: float, distance: float, has_end: bool
) -> None:
    """Tilted and near it has none, and is left as it was; far away it may be tilted otherwise."""
    seen, pose = bottom(Rotation.from_rotvec([tilt, 0.3 * tilt, 0.2]), distance)
    before = pose[0].copy()
    arguments = *seen, *pose, AMBIGUOUS
    assert far_end(*arguments) is has_end
    turned = np.linalg.norm(Rotation.from_matrix(pose[0] @ before.T).as_rotvec())
    assert turned > 0.02 if has_end else turned == 0.0


@pytest.mark.parametrize('angle', [0.0, 1e-8, 0.3, 3.1, np.pi])
def test_the_turn_between_two_rotations(angle: float) -> None:
    """As SciPy has it, up to half a turn, of which either sense is right."""
    axis = np.array([0.6, -0.48, 0.64])
    before = Rotation.from_euler('xyz', [0.3, -0.8, 2.0])
    after = Rotation.from_rotvec(angle * axis) * before
    turn = np.empty(3)
    turn_between(before.as_matrix(), after.as_matrix(), turn)
    again = Rotation.from_rotvec(turn) * before
    np.testing.assert_allclose(again.as_matrix(), after.as_matrix(), atol=1e-7)

"""Three lights on three rays: the true pose is among those that are found."""

from __future__ import annotations

from blob_tracker.constellation.three_rays import MOST, three_rays
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

ANYWHERE = np.random.default_rng(3).normal(size=(300, 3, 3))
EVEN = np.array([[1.0, 0.0, 0.0], [-0.5, 0.75**0.5, 0.0], [-0.5, -(0.75**0.5), 0.0]])


def nearest(places: np.ndarray, rotation: np.ndarray, position: np.ndarray) -> float:
    """Return how far the best of the poses is off in its turn."""
    points = places @ rotation.T + position
    rays = points / np.linalg.norm(points, axis=1)[:, None]
    rotations, positions = np.empty((MOST, 3, 3)), np.empty((MOST, 3))
    count = three_rays(places, rays, rotations, positions)
    return min(
        (np.abs(each - rotation).max() for each in rotations[:count]), default=float(np.inf)
    )


def test_rays_of_any_direction() -> None:
    """Behind the camera, too: a fish-eye sees past 90 degrees. A start needs 1e-2."""
    random = np.random.default_rng(4)
    for seed, places in enumerate(ANYWHERE):
        rotation = Rotation.random(random_state=seed).as_matrix()
        assert nearest(places, rotation, 5.0 * random.normal(size=3)) < 1e-2


@pytest.mark.parametrize('tilt', [0.0, 0.3])
def test_a_triangle_seen_from_the_front(tilt: float) -> None:
    """Where the quartic has equal roots, and eq. 8 of Haralick et al. divides by zero."""
    rotation = Rotation.from_rotvec([tilt, 0.0, 0.0]).as_matrix()
    assert nearest(EVEN, rotation, np.array([0.0, 0.0, 6.0])) < 0.1

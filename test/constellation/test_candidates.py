"""The best poses of three rays: the true one is first, also where bearings are others'."""

from __future__ import annotations

from blob_tracker.constellation.candidates import candidates
import numpy as np
from scipy.spatial.transform import Rotation

PRICE = 50.0


def test_the_true_pose_is_first() -> None:
    """Two of ten bearings are of other lights; a start needs no more than 1e-2."""
    random = np.random.default_rng(1)
    places = random.normal(size=(10, 3))
    rotation = Rotation.random(random_state=2).as_matrix()
    position = np.array([0.3, 0.1, 8.0])
    rays = places @ rotation.T + position
    rays[:2] += random.normal(size=(2, 3))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    bases = np.array([np.linalg.svd(ray[None])[2][1:].T for ray in rays])
    triples = np.array([random.choice(10, 3, replace=False) for _ in range(30)])
    rotations, positions = np.empty((4, 3, 3)), np.empty((4, 3))
    count = candidates(
        places, np.zeros(10), rays, bases, np.tile(1e-6 * np.eye(2), (10, 1, 1)), np.zeros(10),
        np.zeros(6), triples, PRICE, rotations, positions,
    )
    assert 1 <= count <= 4
    np.testing.assert_allclose(rotations[0], rotation, atol=1e-2)
    np.testing.assert_allclose(positions[0], position, atol=0.1)

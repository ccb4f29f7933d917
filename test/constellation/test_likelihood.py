"""The likelihood of a pose: its derivatives are those of its residuals."""

from __future__ import annotations

from blob_tracker.constellation.likelihood import linearise
import numpy as np
from scipy.spatial.transform import Rotation

STEP = 1e-6  # m, rad, m/s, rad/s


def test_the_gradient_is_that_of_the_cost() -> None:
    """
    Of pose and twist, a little off a pose that fits.

    The derivative of the way on the sphere is taken at a small residual, and the covariance as
    constant: of residuals of 1e-3 rad the error is as small.
    """
    random = np.random.default_rng(1)
    count = 6
    places = random.normal(size=(count, 3))
    rotation = Rotation.random(random_state=1).as_matrix()
    position = np.array([0.2, 0.1, 6.0])
    twist, apart = 0.1 * random.normal(size=6), 0.1 * random.normal(size=count)
    turned = np.array([
        Rotation.from_rotvec(twist[3:] * late).as_matrix() @ rotation @ place
        for late, place in zip(apart, places)
    ])
    rays = turned + position + twist[:3] * apart[:, None] + 3e-3 * random.normal(size=(count, 3))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    bases = np.array([np.linalg.svd(ray[None])[2][1:].T for ray in rays])
    noise = np.tile(1e-6 * np.array([[2.0, 0.3], [0.3, 1.0]]), (count, 1, 1))

    def cost(step: np.ndarray) -> tuple[float, np.ndarray]:
        gradient = np.empty(12)
        turn = Rotation.from_rotvec(step[3:6]).as_matrix()
        value = linearise(
            places, np.zeros(count), rays, bases, noise, apart, np.ones(count), np.ones(2),
            np.full(6, 0.05),
            turn @ rotation, position + step[:3], twist + step[6:],
            np.empty((12, 12)), gradient, np.empty(count),
        )
        return value, gradient

    _, downhill = cost(np.zeros(12))
    slopes = [
        (cost(step)[0] - cost(-step)[0]) / (2.0 * STEP) for step in STEP * np.eye(12)
    ]
    np.testing.assert_allclose(-2.0 * downhill, slopes, atol=5e-3 * np.abs(slopes).max())

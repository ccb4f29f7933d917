"""The equations of a body that moves: derivatives as differences have them, and what is free."""

from __future__ import annotations

from blob_tracker.calibration.body_equations import Equations, loose, Measured, Unknown
from blob_tracker.calibration.light_path import covered
from blob_tracker.calibration.rays import Rays
from blob_tracker.simulation.turned_body import TurnedBody
import numpy as np
from scipy.spatial.transform import Rotation

PLACES = np.array([[0.2, 0.1, 0.0], [0.2, -0.1, 0.0], [-0.2, 0.1, 0.1], [0.0, 0.0, 0.2]])
STEP = 1e-5  # rad and m


def test_the_gradient_is_that_of_chi_square() -> None:
    """Along random ways of the places and of the motion, but for what rays do not tell."""
    rng = np.random.default_rng(1)
    rays = [Rays(*each) for each in TurnedBody(PLACES).seen(rng, seconds=1.0)]
    path = covered([[each.times for each in rays]], 0.1, 4)
    turns = Rotation.from_rotvec(rng.normal(0.0, 0.2, (path.size, 3))).as_quat()
    unknown = Unknown(PLACES, turns, np.tile([0.0, 0.0, 2.0], (path.size, 1)))
    # Restraints that weigh nothing: chi2 has none.
    equations = Equations(Measured.along(rays, path), path, np.array([1e9, 1e9]))
    weight = np.ones(len(equations.measured.light))
    linear = equations.linear(unknown, weight)
    for _ in range(5):
        way = rng.normal(size=12), rng.normal(size=6 * path.size)
        there, back = (
            equations.chi2(unknown.moved((step * way[0], step * way[1])), weight)
            for step in (STEP, -STEP)
        )
        downhill = linear.right_outer @ way[0] + linear.right_path @ way[1]
        np.testing.assert_allclose((back - there) / (4.0 * STEP), downhill, rtol=1e-5)


def test_rays_do_not_tell_shift_turn_and_size() -> None:
    """What is loose moves the lights as a whole, or makes the body larger."""
    free = loose(PLACES)
    np.testing.assert_allclose(free.T @ free, np.eye(7), atol=1e-12)
    turn = Rotation.from_rotvec([1e-6, -2e-6, 3e-6]).apply(PLACES) - PLACES
    for moved in (np.ones((4, 1)) * [1.0, 2.0, 3.0], 1e6 * turn, PLACES):
        flat = np.ravel(moved)
        np.testing.assert_allclose(free @ (free.T @ flat), flat, atol=1e-5)

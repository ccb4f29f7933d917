"""Rays of a light: their angles and derivatives, and how often they come."""

from __future__ import annotations

from blob_tracker.calibration.rays import Rays
from blob_tracker.tracking.rays import angles_of, by_place_of
import numpy as np


def test_angles_and_their_derivatives() -> None:
    """Ahead and behind, as differences have them."""
    places = np.random.default_rng(3).normal(size=(20, 3))
    found = by_place_of(places)
    for axis, step in enumerate(1e-6 * np.eye(3)):
        expected = (angles_of(places + step) - angles_of(places - step)) / 2e-6
        np.testing.assert_allclose(found[:, :, axis], expected, rtol=1e-4, atol=1e-6)
    rays = Rays(np.arange(20.0), angles_of(places), np.zeros((20, 2, 2)))
    directions = places / np.linalg.norm(places, axis=1, keepdims=True)
    np.testing.assert_allclose(rays.directions, directions, atol=1e-12)


def test_the_interval_is_that_of_a_light_that_is_seen() -> None:
    """Where it was hidden for seconds does not count; of a single ray there is none."""
    times = np.array([0.0, 0.1, 0.2, 5.2, 5.3])
    rays = Rays(times, np.zeros((5, 2)), np.zeros((5, 2, 2)))
    np.testing.assert_allclose(rays.interval(), 0.1)
    assert np.isnan(rays.part(times < 0.05).interval())

"""Small matrices, and the poses that a search returns."""

from __future__ import annotations

from blob_tracker.constellation.search import diagonalise, invert, mirrored, spread
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

RANDOM = np.random.default_rng(1)


@pytest.mark.parametrize('size', [6, 12])
def test_the_inverse_of_a_covariance(size: int) -> None:
    """As NumPy has it; of a singular matrix there is none."""
    root = RANDOM.normal(size=(size, size))
    matrix, inverse = np.zeros((12, 12)), np.zeros((12, 12))
    matrix[:size, :size] = root @ root.T
    assert invert(matrix, size, inverse)
    np.testing.assert_allclose(
        inverse[:size, :size], np.linalg.inv(matrix[:size, :size]), rtol=1e-6, atol=1e-9)
    matrix[0] = matrix[:, 0] = 0.0
    assert not invert(matrix, size, inverse)


def test_the_axes_of_a_symmetric_matrix() -> None:
    """Moments are those along the axes."""
    for scale in (1.0, 1e-12):
        root = RANDOM.normal(size=(3, 3))
        matrix = scale * root @ root.T
        turned, axes = matrix.copy(), np.empty((3, 3))
        diagonalise(turned, axes)
        np.testing.assert_allclose(
            axes @ np.diag(turned.diagonal()) @ axes.T, matrix, atol=1e-12 * scale)
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)


@pytest.mark.parametrize('beside, is_line', [(0.0, True), (0.005, True), (0.2, False)])
def test_points_in_a_line(beside: float, is_line: bool) -> None:
    """By how far they are spread across it."""
    points = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, beside], [1.0, 0.0, 0.0]]) @ (
        Rotation.from_euler('xyz', [0.3, 1.0, -2.0]).as_matrix())
    assert (spread(points, np.empty(3)) < 4e-4) is is_line


def test_the_mirrored_pose_of_a_plane_looks_nearly_alike() -> None:
    """The further away the more so; mirrored again it is the one that was."""
    places = np.array([[0.1, 0.1, 0.0], [-0.1, 0.12, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.09, 0.0]])
    rotation, position = Rotation.from_euler('xyz', [0.4, 0.3, 0.9]).as_matrix(), np.array(
        [0.2, 0.1, 20.0])
    other, place = np.empty((3, 3)), np.empty(3)
    mirrored(places, rotation, position, other, place)
    assert np.linalg.det(other) == pytest.approx(1.0)
    one, two = (
        points / points[:, 2:] for points in (
            places @ rotation.T + position, places @ other.T + place)
    )
    assert np.abs(one - two).max() < 0.01 * np.abs(one).max()
    again, there = np.empty((3, 3)), np.empty(3)
    mirrored(places, other, place, again, there)
    np.testing.assert_allclose(again, rotation, atol=1e-12)
    np.testing.assert_allclose(there, position, atol=1e-12)

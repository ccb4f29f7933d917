"""
The projections of a board in all views, linear about a camera and its poses.

With r the residuals, A and B their derivatives by camera and pose, the poses are eliminated (the
Schur complement; Triggs et al., Bundle adjustment, Vision Algorithms 1883 (2000) 298, section 6):

    S = sum A^T A - A^T B (B^T B)^-1 B^T A,   S d = sum A^T r - A^T B (B^T B)^-1 B^T r
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from blob_tracker.calibration.boards import View
from blob_tracker.camera import CameraModel
from blob_tracker.camera.lens import LENSES
from blob_tracker.camera.lens.definition import Projection
import numpy as np
from numpy.typing import NDArray

STEPS = 50
CLOSE_ENOUGH = 1e-9  # of the sum of squares
MOST_DAMPING = 1e9

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Bundle:
    """
    A camera and the poses of a board.

    Parameters
    ----------
    model : CameraModel
        The camera.
    rotations, translations : (M, 3) arrays
        Of the board in each view: rotation vector, rad, and place of its origin, mm.

    """

    model: CameraModel
    rotations: Array
    translations: Array

    @property
    def parameters(self) -> Array:
        """Return fx, fy, cx, cy, px, and the distortion coefficients."""
        distortion = np.asarray(self.model.distortion, dtype=float)
        return np.concatenate([self.model.matrix[[0, 1, 0, 1], [0, 1, 2, 2]], distortion])

    def moved(self, step: Array, pose_steps: Array) -> Bundle:
        """Return the bundle with steps of the parameters (n,) and of the poses (M, 6) added."""
        values = self.parameters + step
        matrix = np.array([[values[0], 0.0, values[2]], [0.0, values[1], values[3]], [0, 0, 1.0]])
        return Bundle(
            replace(self.model, matrix=matrix, distortion=values[4:]),
            self.rotations + pose_steps[:, :3],
            self.translations + pose_steps[:, 3:],
        )


def project(points: Array, rotation: Array, translation: Array, model: CameraModel) -> Projection:
    """
    Image points, with all derivatives.

    Parameters
    ----------
    points : (N, 3) array
        mm on the board.
    rotation, translation : (3,) array
        Of the board.
    model : CameraModel
        The camera.

    Returns
    -------
    Projection
        Places in px; their derivatives by fx, fy, cx, cy and the distortion coefficients, and
        by rotation and translation.

    """
    coefficients = np.asarray(model.distortion, dtype=float)
    lens = LENSES[model.distortion_model]
    return lens.project(points, rotation, translation, model.matrix, coefficients)


def residuals(views: Sequence[View], bundle: Bundle) -> list[Array]:
    """Return place less projection of each view, (N, 2), px."""
    return [view.places - places for view, (places, _, _) in _projections(views, bundle)]


def parts(views: Sequence[View], bundle: Bundle) -> tuple[Array, Array]:
    """
    Return what each view tells of the parameters, its pose apart.

    Parameters
    ----------
    views : sequence of View
        Points and places, M views.
    bundle : Bundle
        About which the projections are linear.

    Returns
    -------
    (M, n, n) array, (M, n) array
        The terms of S at a sigma of 1 px, and of S d: how each view pulls the parameters.

    """
    information, pulls = [], []
    for view, (places, by_camera, by_pose) in _projections(views, bundle):
        beyond = by_camera - by_pose @ np.linalg.lstsq(by_pose, by_camera, rcond=None)[0]
        information.append(beyond.T @ beyond)
        pulls.append(beyond.T @ (view.places - places).ravel())
    return np.array(information), np.array(pulls)


def adjust(views: Sequence[View], bundle: Bundle, prior: Array) -> Bundle:
    """
    Minimise the squared residuals plus prior . parameters^2 (Levenberg and Marquardt).

    Parameters
    ----------
    views : sequence of View
        Points and places.
    bundle : Bundle
        Where to start.
    prior : (n,) array
        Weight of each parameter's distance from zero, px^2 over its unit squared.

    Returns
    -------
    Bundle
        At the least sum.

    """
    damping, cost = 1e-3, _cost(views, bundle, prior)
    while damping < MOST_DAMPING:
        for _ in range(STEPS):
            trial = bundle.moved(*_step(views, bundle, prior, damping))
            trial_cost = _cost(views, trial, prior)
            if not trial_cost < cost:
                break
            settled = cost - trial_cost < CLOSE_ENOUGH * cost
            bundle, cost, damping = trial, trial_cost, 0.1 * damping
            if settled:
                return bundle
        damping *= 10.0
    return bundle


def _projections(
    views: Sequence[View], bundle: Bundle
) -> list[tuple[View, Projection]]:
    """Return each view with its projection and derivatives."""
    return [
        (view, project(
            np.column_stack([view.points, np.zeros(len(view.points))]),
            rotation, translation, bundle.model,
        ))
        for view, rotation, translation in zip(views, bundle.rotations, bundle.translations)
    ]


def _cost(views: Sequence[View], bundle: Bundle, prior: Array) -> float:
    squares = sum(float((each**2).sum()) for each in residuals(views, bundle))
    return squares + float(prior @ bundle.parameters**2)


def _step(
    views: Sequence[View], bundle: Bundle, prior: Array, damping: float
) -> tuple[Array, Array]:
    """Return the damped step of the parameters (n,), and of the poses (M, 6)."""
    normal, gradient = np.diag(prior), -prior * bundle.parameters
    back = []
    for view, (places, by_camera, by_pose) in _projections(views, bundle):
        residual = (view.places - places).ravel()
        own = by_pose.T @ by_pose
        own[np.diag_indices(6)] *= 1.0 + damping
        cross, pull = by_pose.T @ by_camera, by_pose.T @ residual
        solved = np.linalg.solve(own, np.column_stack([cross, pull]))
        normal = normal + by_camera.T @ by_camera - cross.T @ solved[:, :-1]
        gradient = gradient + by_camera.T @ residual - cross.T @ solved[:, -1]
        back.append(solved)
    normal[np.diag_indices(len(normal))] *= 1.0 + damping
    scale = np.sqrt(np.diag(normal))
    step = np.linalg.solve(normal / np.outer(scale, scale), gradient / scale) / scale
    return step, np.array([each[:, -1] - each[:, :-1] @ step for each in back])

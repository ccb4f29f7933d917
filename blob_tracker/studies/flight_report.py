"""A body's flight as a picture: where it was and how it was turned, and what its poses are off."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

TRUE, FOUND = '#2c3e50', '#c0392b'
SHOWN = 5  # bodies along the flight
CAMERA_M = 0.02  # m: a fourth of half its width
MM_PER_M = 1e3


def draw_flight(
    path: Path, times: Array, true: Array, true_turns: Rotation, positions: Array,
    turns: Rotation, errors: Array, covariances: Array, lights: Array,
) -> None:
    """
    Write the picture of a flight before the camera.

    Parameters
    ----------
    path : Path
        The PNG to write.
    times : (n,) array
        Of the poses, s.
    true, positions : (n, 3) arrays
        Where the body was, and was said to be, in the optical frame, m.
    true_turns, turns : Rotation
        How it was turned, and was said to be.
    errors : (n, 6) array
        Of the poses, m and rad.
    covariances : (n, 6, 6) array
        Of them.
    lights : (m, 3) array
        Where the lights are on the body, m.

    """
    figure = Figure(figsize=(14, 6.4), layout='constrained')
    left, right = np.asarray(figure.subfigures(1, 2, width_ratios=[1.2, 1.0]))
    scene = left.add_subplot(projection='3d')
    scene.plot(*_in_room(true), color=TRUE, linewidth=1.0, alpha=0.4)
    scene.plot(*_in_room(positions), '.', color=FOUND, markersize=2.5)
    for number, index in enumerate(np.linspace(0, len(times) - 1, SHOWN).astype(int)):
        for turn, place, colour, width, label in (
            (true_turns[index], true[index], TRUE, 5.0, 'as it was'),
            (turns[index], positions[index], FOUND, 1.5, 'as it was seen'),
        ):
            for light in turn.apply(lights) + place:
                scene.plot(
                    *_in_room(np.stack([place, light])), color=colour, linewidth=width,
                    alpha=0.35 if colour == TRUE else 0.9,
                )
            scene.plot(
                *_in_room(turn.apply(lights) + place), 'o', color=colour, markersize=1.5 + width,
                alpha=0.35 if colour == TRUE else 0.9, label=label if number == 0 else None,
            )
    _draw_camera(scene)
    scene.set_title(f'{len(times)} poses before the camera')
    scene.set_xlabel('ahead (m)', labelpad=12.0)  # clear of the numbers
    scene.set_ylabel('left (m)', labelpad=8.0)
    scene.zaxis.set_rotate_label(False)
    scene.set_zlabel('up (m)', rotation=90.0)
    scene.set_aspect('equal')
    scene.locator_params(axis='y', nbins=4)
    scene.view_init(elev=24.0, azim=-112.0)
    scene.legend(loc='upper left')
    upper, lower = right.subplots(2, 1, sharex=True)
    deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    _draw_errors(upper, times, MM_PER_M * errors[:, :3], MM_PER_M * deviations[:, :3])
    upper.set(ylabel='position off (mm)', title='Errors, and two standard deviations of each')
    _draw_errors(lower, times, np.degrees(errors[:, 3:]), np.degrees(deviations[:, 3:]))
    lower.set(ylabel='rotation off (degrees)', xlabel='time (s)')
    upper.legend(loc='upper right', ncols=3)
    figure.savefig(path, dpi=110)


def _in_room(points: Array) -> Array:
    """Return x ahead, y left and z up of points of the optical frame, (3, n)."""
    x, y, z = points.T
    return np.array([z, -x, -y])


def _draw_camera(scene: Axes) -> None:
    """Draw the camera as a pyramid that looks ahead."""
    corners = CAMERA_M * np.array([[-4, -3, 6], [4, -3, 6], [4, 3, 6], [-4, 3, 6], [-4, -3, 6]])
    scene.plot(*_in_room(corners), color='grey')
    for corner in corners[:4]:
        scene.plot(*_in_room(np.stack([np.zeros(3), corner])), color='grey')


def _draw_errors(axes: Axes, times: Array, errors: Array, deviations: Array) -> None:
    """Draw the errors along or about three axes beside what the covariance predicts."""
    for axis, colour, values, sigma in zip(
        'xyz', ('#c0392b', '#27ae60', '#2980b9'), errors.T, deviations.T, strict=True
    ):
        axes.vlines(times, -2.0 * sigma, 2.0 * sigma, color=colour, alpha=0.18, linewidth=2.0)
        axes.plot(times, values, 'o', color=colour, markersize=3.0, label=axis)
    reach = 5.0 * float(np.median(deviations.max(axis=1)))
    axes.set_ylim(-reach, reach)
    axes.axhline(0.0, color='grey', linewidth=0.5)

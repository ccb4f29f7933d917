"""A body's flight as a picture: where it was and how it was turned, and what its poses are off."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

TRUE, FOUND = '#2c3e50', '#c0392b'
SHOWN = 7  # bodies along the flight
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
    figure = Figure(figsize=(13, 6.4), layout='constrained')
    left, right = figure.subfigures(1, 2, width_ratios=[1.15, 1.0])
    scene = left.add_subplot(projection='3d')
    to_room = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # x ahead, z up
    scene.plot(*(true @ to_room.T).T, color=TRUE, linewidth=3, alpha=0.25, label='true path')
    scene.plot(*(positions @ to_room.T).T, '.', color=FOUND, markersize=2.5, label='poses')
    for index in np.linspace(0, len(times) - 1, SHOWN).astype(int):
        for turn, place, colour, width in (
            (true_turns[index], true[index], TRUE, 3.0),
            (turns[index], positions[index], FOUND, 1.0),
        ):
            body = (turn.apply(lights) + place) @ to_room.T
            for one, other in combinations(body, 2):
                scene.plot(
                    *np.stack([one, other]).T, color=colour, linewidth=width,
                    alpha=0.3 if colour == TRUE else 0.8,
                )
            scene.scatter(*body.T, color=colour, s=6.0 * width, alpha=0.5)
    scene.set(
        xlabel='ahead of the camera (m)', ylabel='left (m)', zlabel='up (m)',
        title=f'{len(times)} poses of the body: grey as it was, red as it was seen',
    )
    scene.set_aspect('equal')
    scene.view_init(elev=22.0, azim=-125.0)
    scene.legend(loc='upper left')
    upper, lower = right.subplots(2, 1, sharex=True)
    deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    _draw_errors(upper, times, MM_PER_M * errors[:, :3], MM_PER_M * deviations[:, :3])
    upper.set(ylabel='place off (mm)', title='Errors, and twice their standard deviation')
    _draw_errors(lower, times, np.degrees(errors[:, 3:]), np.degrees(deviations[:, 3:]))
    lower.set(ylabel='turn off (degrees)', xlabel='time (s)')
    upper.legend(loc='upper right', ncols=3)
    figure.savefig(path, dpi=110)


def _draw_errors(axes: Axes, times: Array, errors: Array, deviations: Array) -> None:
    """Draw the errors along and about three axes beside what the covariance predicts."""
    for axis, colour, values, sigma in zip(
        'xyz', ('#c0392b', '#27ae60', '#2980b9'), errors.T, deviations.T, strict=True
    ):
        axes.fill_between(times, -2.0 * sigma, 2.0 * sigma, color=colour, alpha=0.12, linewidth=0)
        axes.plot(times, values, '.', color=colour, markersize=3, label=axis)
    reach = 4.0 * float(np.median(deviations.max(axis=1)))
    axes.set_ylim(-reach, reach)
    axes.axhline(0.0, color='grey', linewidth=0.5)

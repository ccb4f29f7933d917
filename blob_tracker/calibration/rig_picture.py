"""A rig in space: its cameras, and where the light was waved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.calibration.rig import RigCalibration
from blob_tracker.calibration.space_picture import AXES, draw_in_space
import numpy as np

LONG = 0.25  # of the greatest distance between cameras: the axes that are drawn
# Down in the optical frame is down in the picture.
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def draw_rig(path: Path, result: RigCalibration) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    result : RigCalibration
        What to draw.

    """
    draw_in_space(
        path, lambda space: _fill(space, result), result.names, result.residuals, result.used,
        result.left_out,
    )


def _fill(space: Any, result: RigCalibration) -> None:
    """Draw the cameras and the light."""
    unit = 'm' if result.is_metric else 'of the first distance'
    light = result.path @ UPRIGHT.T
    space.scatter(*light.T, s=2, color='#7f8c8d', label='light')
    places = result.positions @ UPRIGHT.T
    length = LONG * float(np.linalg.norm(places - places[0], axis=1).max())
    for name, place, rotation in zip(result.names, places, result.rotations, strict=True):
        for axis, (label, colour) in enumerate(AXES):
            end = place + length * UPRIGHT @ rotation[:, axis]
            first = name == result.names[0]
            space.plot(
                *np.stack([place, end]).T, color=colour, label=label if first else None
            )
        space.text(*place, f' {name}')
    space.set(
        title='Cameras with their optical axes (z looks ahead), and the light',
        xlabel=f'x ({unit})', ylabel=f'z ({unit})', zlabel=f'-y ({unit})',
    )

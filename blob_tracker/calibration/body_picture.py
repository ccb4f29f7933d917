"""The lights of a body in space, and how well their rays fit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.calibration.body import BodyCalibration
from blob_tracker.calibration.space_picture import AXES, draw_in_space
import numpy as np

LONG = 0.3  # of the body's size: the axes that are drawn
MM_PER_M = 1e3


def draw_body(path: Path, result: BodyCalibration) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    result : BodyCalibration
        What to draw.

    """
    draw_in_space(
        path, lambda space: _fill(space, result), result.names, result.residuals, result.used,
        result.left_out,
    )


def _fill(space: Any, result: BodyCalibration) -> None:
    """Draw the lights and the frame of the body."""
    unit, size = ('mm', MM_PER_M) if result.is_metric else ('of the first distance', 1.0)
    places = size * result.places
    middle = places.mean(axis=0)
    for place in places:
        space.plot(*np.stack([middle, place]).T, color='#bdc3c7', linewidth=1.0)
    space.scatter(*places.T, s=30, color='#2c3e50')
    for name, place, sigma in zip(result.names, places, size * result.sigmas, strict=True):
        space.text(*place, f' {name} ± {sigma:.2g}')
    length = LONG * float(np.ptp(places, axis=0).max())
    for axis, (label, colour) in zip(np.eye(3), AXES, strict=True):
        space.plot(*np.stack([0.0 * axis, length * axis]).T, color=colour, label=label)
    space.set(
        title='The lights in the frame of the body, with the sigma along an axis',
        xlabel=f'x ({unit})', ylabel=f'y ({unit})', zlabel=f'z ({unit})',
    )

"""A rig in space: its cameras, and where the light was waved."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.rig import RigCalibration
from matplotlib.figure import Figure
import numpy as np

AXES = (('x', '#c0392b'), ('y', '#27ae60'), ('z', '#2980b9'))
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
    figure = Figure(figsize=(12, 6), layout='constrained')
    space = figure.add_subplot(1, 2, 1, projection='3d')
    bars = figure.add_subplot(1, 2, 2)
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
    space.set_aspect('equal')
    space.locator_params(nbins=4)
    space.legend(loc='upper left')
    numbers = np.arange(len(result.names))
    bars.bar(numbers, result.residuals, color='#2980b9')
    bars.axhline(1.0, color='#c0392b', linewidth=1.0, label='what the covariances say')
    bars.set_xticks(numbers, [
        f'{name}\n{used} rays\n{gone} left out'
        for name, used, gone in zip(result.names, result.used, result.left_out, strict=True)
    ])
    bars.set(
        title='Residuals', ylabel='rms over the standard deviation of the rays', ylim=(0.0, None)
    )
    bars.legend(loc='lower right')
    figure.savefig(path, dpi=110)

"""The lights of a body in space, and how well their rays fit."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.body import BodyCalibration
from matplotlib.figure import Figure
import numpy as np

AXES = (('x', '#c0392b'), ('y', '#27ae60'), ('z', '#2980b9'))
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
    figure = Figure(figsize=(12, 6), layout='constrained')
    space = figure.add_subplot(1, 2, 1, projection='3d')
    bars = figure.add_subplot(1, 2, 2)
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

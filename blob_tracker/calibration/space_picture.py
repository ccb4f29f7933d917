"""Something in space beside how well the rays fit: the form of the pictures of rigs and bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

AXES = (('x', '#c0392b'), ('y', '#27ae60'), ('z', '#2980b9'))


def draw_in_space(
    path: Path,
    fill: Callable[[Any], None],
    names: Sequence[str],
    residuals: NDArray[np.float64],
    used: NDArray[np.intp],
    left_out: NDArray[np.intp],
) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    fill : callable
        Draws into the axes in space, and gives them their title and labels.
    names : sequence of str
        Of those whose rays they are.
    residuals : (n,) array
        rms over the standard deviations of the rays.
    used, left_out : (n,) arrays
        How many rays.

    """
    figure = Figure(figsize=(12, 6), layout='constrained')
    space = figure.add_subplot(1, 2, 1, projection='3d')
    bars = figure.add_subplot(1, 2, 2)
    fill(space)
    space.set_aspect('equal')
    space.locator_params(nbins=4)
    space.legend(loc='upper left')
    numbers = np.arange(len(names))
    bars.bar(numbers, residuals, color='#2980b9')
    bars.axhline(1.0, color='#c0392b', linewidth=1.0, label='what the covariances say')
    bars.set_xticks(numbers, [
        f'{name}\n{count} rays\n{gone} left out'
        for name, count, gone in zip(names, used, left_out, strict=True)
    ])
    bars.set(
        title='Residuals', ylabel='rms over the standard deviation of the rays', ylim=(0.0, None)
    )
    bars.legend(loc='lower right')
    figure.savefig(path, dpi=110)

"""What the axes of a pan/tilt leave of where a light is seen, by the angles of its joints."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.hand_eye import HandEyeCalibration
from matplotlib.figure import Figure
import numpy as np

WIDEST = 5.0  # standard deviations
BINS = 41


def draw_hand_eye(path: Path, result: HandEyeCalibration) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    result : HandEyeCalibration
        The fit.

    """
    figure = Figure(figsize=(14, 4.6), layout='constrained')
    pan, tilt, all_of_them = figure.subplots(1, 3)
    degrees = np.degrees(result.angles)
    for axes, angles, name in ((pan, degrees[:, 0], 'pan'), (tilt, degrees[:, 1], 'tilt')):
        for direction, residuals, colour in zip(
            ('right', 'up'), result.residuals.T, ('#2980b9', '#c0392b')
        ):
            axes.plot(angles, residuals, '.', color=colour, markersize=3, label=direction)
        axes.axhline(0.0, color='grey', linewidth=0.8)
        axes.set(xlabel=f'{name} (degrees)', ylabel='measured - fit (standard deviations)')
    pan.set_title('A curve here is the lens; two branches, backlash')
    tilt.legend(loc='upper right')
    edges = np.linspace(-WIDEST, WIDEST, BINS)
    all_of_them.hist(result.residuals.ravel(), edges, density=True, color='#95a5a6')
    all_of_them.plot(edges, np.exp(-0.5 * edges**2) / np.sqrt(2.0 * np.pi), 'k', linewidth=0.8)
    all_of_them.set(
        title='All of them, and a Gaussian of 1', xlabel='standard deviations', ylabel='density'
    )
    figure.savefig(path, dpi=110)

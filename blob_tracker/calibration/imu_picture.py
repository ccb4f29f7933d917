"""What a gyro leaves of how a light moves in the picture."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.imu import ImuCalibration
from matplotlib.figure import Figure
import numpy as np

WIDEST = 5.0  # standard deviations
BINS = 41


def draw_imu(path: Path, result: ImuCalibration) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    result : ImuCalibration
        The fit.

    """
    figure = Figure(figsize=(12, 4.6), layout='constrained')
    left, right = figure.subplots(1, 2, width_ratios=(2, 1))
    for name, residuals, colour in zip(
        ('right', 'up'), result.residuals.T, ('#2980b9', '#c0392b')
    ):
        left.plot(result.times, residuals, '.', color=colour, markersize=3, label=name)
    left.axhline(0.0, color='grey', linewidth=0.8)
    left.set(
        title='A swing here is a light that moves, or an IMU that is not rigid with the camera',
        xlabel='time (s)', ylabel='measured - predicted (standard deviations)',
    )
    left.legend(loc='upper right')
    edges = np.linspace(-WIDEST, WIDEST, BINS)
    right.hist(result.residuals.ravel(), edges, density=True, color='#95a5a6')
    right.plot(edges, np.exp(-0.5 * edges**2) / np.sqrt(2.0 * np.pi), 'k', linewidth=0.8)
    right.set(
        title='All of them, and a Gaussian of 1', xlabel='standard deviations', ylabel='density'
    )
    figure.savefig(path, dpi=110)

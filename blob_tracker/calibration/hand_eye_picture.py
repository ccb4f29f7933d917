"""What the axes of a pan/tilt leave of where a light is seen, by the angles of its joints."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.hand_eye import HandEyeCalibration
from blob_tracker.calibration.residual_picture import draw_over, draw_spread
from matplotlib.figure import Figure
import numpy as np


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
        draw_over(axes, angles, result.residuals)
        axes.set(xlabel=f'{name} (degrees)', ylabel='measured - fit (standard deviations)')
    pan.set_title('A curve here is the lens; two branches, backlash')
    tilt.legend(loc='upper right')
    draw_spread(all_of_them, result.residuals)
    figure.savefig(path, dpi=110)

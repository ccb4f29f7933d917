"""What a gyro leaves of how a light moves in the picture."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.imu import ImuCalibration
from blob_tracker.calibration.residual_picture import draw_over, draw_spread
from matplotlib.figure import Figure


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
    draw_over(left, result.times, result.residuals)
    left.set(
        title='A swing here is a light that moves, or an IMU that is not rigid with the camera',
        xlabel='time (s)', ylabel='measured - predicted (standard deviations)',
    )
    left.legend(loc='upper right')
    draw_spread(right, result.residuals)
    figure.savefig(path, dpi=110)

"""The bands of a lamp in the lines of a rolling shutter, measured and fitted."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.line_time import LineTimeMeasurement
from matplotlib.figure import Figure
import numpy as np

SHOWN = 4  # frames beside each other
COLOURS = ('#2980b9', '#c0392b')


def draw_line_time(path: Path, measurement: LineTimeMeasurement) -> None:
    """
    Write the picture: the line number goes down, as on a screen.

    Parameters
    ----------
    path : Path
        The PNG to write.
    measurement : LineTimeMeasurement
        What was measured.

    """
    count, height = measurement.profiles.shape
    lines = np.arange(height)
    figure = Figure(figsize=(9, 6), layout='constrained')
    shown = range(min(SHOWN, count))
    all_axes = figure.subplots(1, len(shown), sharey=True, squeeze=False)[0]
    for frame, axes in zip(shown, all_axes):
        axes.plot(
            100.0 * measurement.profiles[frame], lines, color=COLOURS[0], linewidth=0.8,
            label='measured',
        )
        axes.plot(
            100.0 * measurement.fitted[frame], lines, color=COLOURS[1], linewidth=1.2,
            label='fitted',
        )
        axes.set(title=f'frame {frame}', xlabel='over the mean (%)', ylim=(height - 0.5, -0.5))
    all_axes[0].set_ylabel('line')
    all_axes[0].legend(loc='best')
    figure.suptitle(
        f'Bands {measurement.spacing:.2f} lines apart, {measurement.frequency:g} Hz: '
        f'{1e6 * measurement.line_time:.4f} us a line'
    )
    figure.savefig(path, dpi=110)

"""Offset against line, as in thesis Figure 2.4."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.line_jitter import LineJitterMeasurement
from matplotlib.figure import Figure
import numpy as np

COLOURS = ('#c0392b', '#2980b9')


def draw_line_jitter(path: Path, measurement: LineJitterMeasurement) -> None:
    """
    Write the picture: the line number goes down, as on a screen.

    Parameters
    ----------
    path : Path
        The PNG to write.
    measurement : LineJitterMeasurement
        What was measured.

    """
    jitter, fields = measurement.jitter, measurement.fields
    lines = np.arange(len(jitter.offsets))
    figure = Figure(figsize=(7, 8), layout='constrained')
    axes = figure.subplots()
    for field in range(fields):
        part = lines[field::fields]
        offsets, sigma = jitter.offsets[part], jitter.sigma[part]
        name = 'all lines' if fields == 1 else ('even lines', 'odd lines')[field]
        axes.fill_betweenx(
            part, offsets - sigma, offsets + sigma, color=COLOURS[field], alpha=0.25, linewidth=0
        )
        axes.plot(offsets, part, color=COLOURS[field], linewidth=1.2, label=name)
    missing = lines[~measurement.measured]
    if len(missing):
        axes.plot(jitter.offsets[missing], missing, 'kx', markersize=5, label='interpolated')
    axes.set(
        title='Line jitter; from frame to frame '
        f'{jitter.sigma_from_frame_to_frame:.3f} px more',
        xlabel='mean offset, less a straight line (px)',
        ylabel='line',
        ylim=(len(lines) - 0.5, -0.5),
    )
    axes.axvline(0.0, color='grey', linewidth=0.8)
    axes.legend(loc='best')
    figure.savefig(path, dpi=110)

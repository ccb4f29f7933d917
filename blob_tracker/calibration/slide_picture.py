"""The path of a control point against the readings of the slide."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.slide import SlideCalibration
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray


def draw_slide(path: Path, slide: NDArray[np.float64], result: SlideCalibration) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    slide : (n,) array
        Readings, mm.
    result : SlideCalibration
        The fit to them.

    """
    figure = Figure(figsize=(12, 5.4), layout='constrained')
    left, right = figure.subplots(1, 2)
    scale, sigma = result.pixels_per_mm
    along = result.scale / scale
    across = np.array([-along[1], along[0]])
    ends = np.array([slide.min(), slide.max()])
    left.plot(ends, scale * (ends - slide.min()), color='#2c3e50', label='fitted')
    left.plot(
        slide, scale * (slide - slide.min()) + result.residuals @ along, 'o', color='#c0392b',
        markersize=5, label='measured',
    )
    left.set(
        title=f'{scale:.5g} ± {sigma:.2g} px/mm',
        xlabel='slide (mm)',
        ylabel='way in the picture (px)',
    )
    left.legend()
    right.plot(slide, result.residuals @ along, 'o-', label='along the path', markersize=5)
    right.plot(slide, result.residuals @ across, 'x-', label='across the path', markersize=6)
    right.axhline(0.0, color='grey', linewidth=0.8)
    right.set(
        title='A bow: image plane not parallel, or lens distortion',
        xlabel='slide (mm)',
        ylabel='measured - fitted (px)',
    )
    right.legend()
    figure.savefig(path, dpi=110)

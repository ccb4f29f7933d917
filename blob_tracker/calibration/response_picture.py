"""The response as a picture: the curve, what is left of it, and the noise before and after."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.response_measurement import ResponseMeasurement
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

POINTS, CURVE, LINE = '#0050c8', '#c40000', '#606060'


def draw_response(path: Path, measurement: ResponseMeasurement) -> None:
    """
    Draw the response beside a straight one, its residuals, and variance over level twice.

    Parameters
    ----------
    path : Path
        The PNG to write.
    measurement : ResponseMeasurement
        What was measured.

    """
    figure = Figure(figsize=(12.0, 8.0), layout='constrained')
    (curve, raw), (left, linear) = figure.subplots(2, 2)
    response = measurement.response
    curve.plot(response.linear, response.levels, color=CURVE)
    sides = [response.linear + sign * response.sigma for sign in (-1.0, 1.0)]
    curve.fill_betweenx(response.levels, *sides, color=CURVE, alpha=0.3, linewidth=0.0)
    ends = [0.0, response.linear[-1]], [0.0, response.levels[-1]]
    curve.plot(*ends, color=LINE, linestyle='--', label='a linear camera')
    curve.axvline(measurement.black_level[0], color=LINE, linestyle=':', label='black level')
    curve.set_xlabel('linear DN')
    curve.set_ylabel('raw DN')
    curve.set_title(f'response, like an exponent of {measurement.exponent:.2f}')
    curve.legend(loc='lower right')
    left.plot(
        measurement.levels, measurement.residuals, '.', color=POINTS, markersize=2, alpha=0.3
    )
    left.axhline(0.0, color=CURVE)
    left.set_xlabel('raw DN')
    left.set_ylabel('left of the points, raw DN')
    _draw_variance(raw, measurement.variances, 'raw')
    _draw_variance(linear, measurement.linear_variances, 'linear')
    line = measurement.line
    if line is not None:
        span = np.array([0.0, response.linear[-1]])
        linear.plot(
            span, line.foot + line.slope * span, color=CURVE,
            label=f'gain {line.gain:.4g} e\u207b/DN',
        )
        linear.legend(loc='upper left')
    figure.savefig(path, dpi=110)


def _draw_variance(axes: Axes, found: NDArray[np.float64], scale: str) -> None:
    """Draw the variance over the level, with its bars."""
    level, variance, scatter = found
    if level.size:
        axes.errorbar(
            level, variance, np.sqrt(scatter) * variance, fmt='o', color=POINTS, markersize=4
        )
    else:
        axes.text(0.5, 0.5, 'no frames in pairs', ha='center', transform=axes.transAxes)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(f'level, {scale} DN')
    axes.set_ylabel(f'temporal variance, {scale} DN\u00b2')

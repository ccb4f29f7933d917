"""The figures of the servo study: step, disturbance, and size of the disturbance."""

from __future__ import annotations

from collections.abc import Mapping

from blob_tracker.studies.axes import COLOURS, legend_below, new_axes
from blob_tracker.studies.beyond.servo_scenario import Scenario
from blob_tracker.studies.study import Measured
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np


def draw_step(runs: Mapping[str, Measured]) -> Figure:
    """Draw the pointing error from 10 degrees off on, whole and near 0."""
    figure, (left, right) = new_axes(2)
    left.set(xlabel='time, s', ylabel='pointing error, mrad')
    right.set(xlabel='time, s', ylabel='pointing error, mrad', yscale='log')
    for (law, found), colour in zip(runs.items(), COLOURS):
        left.plot(found['times'], found['errors'], color=colour, label=law)
        right.plot(found['times'], np.maximum(found['errors'], 1e-3), color=colour, label=law)
    right.axhline(1.0, color='black', linestyle=':', label='1 mrad')
    legend_below(figure, right)
    return figure


def draw_disturbance(
    runs: Mapping[str, Measured], scenario: Scenario, goal: float, worst: float
) -> Figure:
    """Draw the pointing error against time on the normal boat, all laws and the predictions."""
    figure, (left, right) = new_axes(2)
    left.set(xlabel='time, s', ylabel='pointing error, mrad', yscale='log')
    right.set(xlabel='time, s', ylabel='pointing error, mrad')
    for (law, found), colour in zip(runs.items(), COLOURS):
        times = np.array(found['times'])
        shown = times <= 12.0
        errors = np.maximum(found['errors'], 1e-3)
        left.plot(times[shown], errors[shown], color=colour, linewidth=0.9, label=law)
        if law.startswith('predicted'):
            right.plot(times[shown], errors[shown], color=colour, linewidth=0.9)
    for axes in (left, right):
        _demand(axes, goal, worst)
        end = axes.get_xlim()[1]
        for strike in np.arange(scenario.rock_first, end, scenario.rock_every):
            axes.axvline(strike, color='grey', linewidth=0.8, linestyle='-.')
    right.set_ylim(0.0, 3.0)
    left.plot([], [], color='grey', linestyle='-.', label='a rock')
    legend_below(figure, left)
    return figure


def draw_sizes(
    sizes: Mapping[str, Mapping[float, tuple[float, float]]], goal: float, worst: float
) -> Figure:
    """Draw rms and worst error against the size of the motion."""
    figure, (axes,) = new_axes()
    axes.set(
        xlabel='motion of the boat and rocks, times the normal', ylabel='pointing error, mrad',
        yscale='log',
    )
    for (law, found), colour in zip(sizes.items(), COLOURS):
        at = list(found)
        axes.plot(at, [one[0] for one in found.values()], 'o-', color=colour, label=f'{law}: rms')
        axes.plot(at, [one[1] for one in found.values()], 'v--', color=colour,
                  label=f'{law}: worst')
    _demand(axes, goal, worst)
    legend_below(figure, axes, 3)
    return figure


def _demand(axes: Axes, goal: float, worst: float) -> None:
    """Draw what is asked for."""
    axes.axhline(goal, color='black', linestyle=':', label=f'{goal:g} mrad: rms asked for')
    axes.axhline(worst, color='black', linestyle='--', label=f'{worst:g} mrad: worst asked for')

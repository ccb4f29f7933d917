"""The lights that blink as a picture: where they are, and their brightness over time and phase."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from blob_tracker.blinking.recognition import envelope
from blob_tracker.blinking.survey import Light
from blob_tracker.blinking.wording import describe
from blob_tracker.types import Pixels
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

COLOURS = ('#c0392b', '#2471a3', '#1e8449', '#b7950b', '#7d3c98', '#117a65', '#a04000', '#34495e')
SHOWN_S = 2.0  # of the brightness over time
ROW = 2.2  # height of the two plots of a light, inches
FINE = 2000  # points of the fitted pattern
STRETCH = (1.0, 99.9)  # percentiles of the scene that are black and white


def draw_flash(path: Path, scene: Pixels, lights: Sequence[Light]) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    scene : (h, w) array
        A frame, DN.
    lights : sequence of Light
        In the order of their numbers.

    """
    count = max(len(lights), 1)
    figure = Figure(figsize=(12.0, 5.5 + ROW * count), layout='constrained')
    grid = figure.add_gridspec(1 + count, 2, height_ratios=[5.5, *[ROW] * count])
    top = figure.add_subplot(grid[0, :])
    low, high = np.percentile(scene, STRETCH)
    top.imshow(scene, cmap='gray', vmin=low, vmax=max(high, low + 1.0))
    top.set(title='the lights that blink', xlabel='x (px)', ylabel='y (px)')
    for index, light in enumerate(lights):
        colour = COLOURS[index % len(COLOURS)]
        x, y = light.path.x, light.path.y
        top.plot(x, y, '-', color=colour, linewidth=0.8)
        top.plot(x[-1], y[-1], 'o', color=colour, fillstyle='none', markersize=12)
        top.annotate(
            str(index + 1), (float(x[-1]), float(y[-1])), (9, 9), textcoords='offset points',
            color=colour, fontsize=12, fontweight='bold',
        )
        time = figure.add_subplot(grid[1 + index, 0])
        phase = figure.add_subplot(grid[1 + index, 1])
        _draw_light(time, phase, light, colour)
        time.set_title(f'{index + 1}: {describe(light)}', fontsize=9)
    figure.savefig(path, dpi=110)


def _draw_light(time: Axes, phase: Axes, light: Light, colour: str) -> None:
    """Draw the brightness of a light over time, and folded at its period."""
    clock, rhythm = light.brightness.clock, light.rhythm
    fits = rhythm.kind in ('wave', 'code')
    share = rhythm.share(clock) if fits else None
    level = light.brightness.flux / envelope(light.brightness, share)
    shown = clock < clock[0] + SHOWN_S * light.rate
    time.plot(clock[shown] / light.rate, level[shown], '.-', color=colour, linewidth=0.5)
    time.set(xlabel='time (s)', ylabel='of full light', ylim=(-0.1, 1.4))
    if not rhythm.period:
        phase.set_axis_off()
        phase.text(0.5, 0.5, 'no period', ha='center', va='center')
        return
    part = (clock - rhythm.rise) / rhythm.period % 1.0
    phase.plot(part, level, '.', color=colour, markersize=3)
    if fits:
        fine = np.linspace(0.0, 1.0, FINE)
        phase.plot(fine, rhythm.share(rhythm.rise + fine * rhythm.period), 'k', linewidth=0.8)
    phase.set(
        xlabel=f'phase, of {1e3 * rhythm.period / light.rate:.4g} ms', ylim=(-0.1, 1.4),
        xlim=(0.0, 1.0),
    )

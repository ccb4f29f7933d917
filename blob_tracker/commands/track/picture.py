"""A track as a picture: the path, how its places scatter, and how many came in a second."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.commands.track.outcome import Summary, Trail
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

COLOURS = ('#c0392b', '#2980b9', '#27ae60', '#8e44ad', '#d35400', '#16a085')
FEWEST = 5  # places to a divided difference
GAP = 2.5  # usual intervals between neighbours: one place may be missing, not more
BREAK = 10.0  # usual intervals, beyond which the path is not joined
WIDEST = 5.0  # sigma
BINS = 41
SLICES = 60  # of the time, at most
ROOM = 1.3  # of the height of what is drawn, for the legend


def draw_track(path: Path, summary: Summary, size: tuple[int, int]) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    summary : Summary
        With one place at least.
    size : (int, int)
        Width and height of the frames, px.

    """
    figure = Figure(figsize=(13, 7), layout='constrained')
    places = figure.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
    _draw_path(figure.add_subplot(places[:, 0]), summary, size)
    _draw_scatter(figure.add_subplot(places[0, 1]), summary)
    _draw_rate(figure.add_subplot(places[1, 1]), summary)
    figure.savefig(path, dpi=110)


def _draw_path(axes: Axes, summary: Summary, size: tuple[int, int]) -> None:
    """Draw where the lights were, in angles as one looks at them, or in the frame."""
    for (light, trail), colour in zip(summary.trails.items(), _colours(summary)):
        places = np.array(trail.places)
        apart = np.diff(trail.stamps)
        usual = np.median(apart) if len(apart) else 0.0
        for part in np.split(places, np.flatnonzero(apart > BREAK * usual) + 1):
            axes.plot(*part.T, color=colour, linewidth=0.8, alpha=0.5)
        axes.plot(*places.T, '.', color=colour, markersize=3, label=light or 'light')
        axes.plot(*places[0], 'o', color=colour, markersize=8, fillstyle='none')
    axes.plot([], [], 'o', color='grey', fillstyle='none', label='first')
    title = f'{summary.placed} positions in {len(summary.frames)} frames'
    if summary.angles:
        axes.set(title=title, xlabel='azimuth (mrad)', ylabel='elevation (mrad)')
        axes.set_aspect('equal', adjustable='datalim')
    else:
        axes.set(
            title=f'{title} (no calibration: no angles)', xlabel='x (px)', ylabel='y (px)',
            xlim=(-0.5, size[0] - 0.5), ylim=(size[1] - 0.5, -0.5), aspect='equal',
        )
    axes.grid(alpha=0.3)
    axes.legend(loc='best')


def _draw_scatter(axes: Axes, summary: Summary) -> None:
    """Draw the differences of neighbours over the sigma that the covariances give them."""
    grid = np.linspace(-WIDEST, WIDEST, 300)
    bins = np.linspace(-WIDEST, WIDEST, BINS)
    for (light, trail), colour in zip(summary.trails.items(), _colours(summary)):
        values = normalised_differences(trail)
        found = trail.scatter()
        if not values.size or found is None:
            continue
        axes.hist(
            np.clip(values, -WIDEST, WIDEST), bins=bins.tolist(), density=True, color=colour,
            alpha=0.5,
            label=f'{light or "light"}: scatter / sigma {found.ratio:.2f} +- {found.error:.2f}',
        )
    axes.plot(
        grid, np.exp(-0.5 * grid**2) / np.sqrt(2.0 * np.pi), color='#2c3e50',
        label='as the sigmas say',
    )
    axes.set(
        title='Scatter against sigma', ylabel='density',
        xlabel='fourth difference of neighbours / its sigma',
    )
    if not axes.patches:
        axes.text(
            0.5, 0.5, 'too few positions without a gap', ha='center', transform=axes.transAxes)
    _make_room(axes)


def _draw_rate(axes: Axes, summary: Summary) -> None:
    """Draw how many frames and places there were in a second."""
    first = summary.frames[0]
    frames = (np.array(summary.frames) - first) / 1e9
    length = max(float(frames.max()), 1e-9)
    slices = int(np.clip(len(frames) // 10, 1, SLICES))
    edges = np.linspace(0.0, length * (1.0 + 1e-9), slices + 1)
    width = length / slices
    axes.stairs(
        np.histogram(frames, edges)[0] / width, edges, color='#2c3e50', label='frames'
    )
    for (light, trail), colour in zip(summary.trails.items(), _colours(summary)):
        places = np.clip((np.array(trail.stamps) - first) / 1e9, 0.0, length)
        axes.stairs(
            np.histogram(places, edges)[0] / width, edges, color=colour, linewidth=1.6,
            label=light or 'light',
        )
    axes.set(title='Rate', xlabel='time (s)', ylabel='in a second (Hz)', xlim=(0.0, length))
    axes.grid(alpha=0.3)
    _make_room(axes)


def _make_room(axes: Axes) -> None:
    """Put the legend above all that is drawn."""
    axes.set_ylim(0.0, ROOM * axes.get_ylim()[1])
    axes.legend(loc='upper right', ncols=2)


def normalised_differences(trail: Trail) -> NDArray[np.float64]:
    """
    Return the fourth divided differences of both coordinates over their sigmas.

    As in `blob_tracker.location.scatter`: free of the motion, standard normal where the
    covariances are true. Those across a gap are left out.
    """
    stamps = np.array(trail.stamps, dtype=np.int64)
    apart = np.diff(stamps)
    if len(stamps) < FEWEST or not (apart > 0).any():
        return np.zeros(0)
    usual = float(np.median(apart[apart > 0]))
    rows = np.arange(len(stamps) - FEWEST + 1)[:, None] + np.arange(FEWEST)
    times = (stamps[rows] - stamps[rows[:, :1]]) / usual
    steps = np.diff(times, axis=1)
    rows, times = (each[((steps > 0.0) & (steps <= GAP)).all(axis=1)] for each in (rows, times))
    between = times[:, :, None] - times[:, None, :] + np.eye(FEWEST)
    weights = 1.0 / between.prod(axis=2)
    differences = np.einsum('ik,ikp->ip', weights, np.array(trail.places)[rows])
    covariances = np.array(trail.covariances)[rows]
    variances = np.einsum('ik,ikpp->ip', weights**2, covariances)
    return np.asarray((differences / np.sqrt(variances)).ravel())


def _colours(summary: Summary) -> list[str]:
    return [COLOURS[index % len(COLOURS)] for index in range(len(summary.trails))]

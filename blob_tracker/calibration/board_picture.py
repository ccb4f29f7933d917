"""A board's calibration as a picture: where the points were, the tilts, what is left."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.board import BoardCalibration
from blob_tracker.calibration.board_advice import BORDERS, tilts
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
import numpy as np

POINT, LINE, ARROW = '#2980b9', '#2c3e50', '#c0392b'
SUFFIXES = tuple(  # all but that for which matplotlib needs a LaTeX
    f'.{each}' for each in sorted(FigureCanvasAgg.get_supported_filetypes()) if each != 'pgf'
)
ARROW_LENGTH = 0.04  # of the width: what the rms of the residuals is drawn as
BINS = 60


def draw_board_calibration(path: Path, found: BoardCalibration) -> None:
    """
    Write the picture of a calibration.

    Parameters
    ----------
    path : Path
        The picture to write, of one of `SUFFIXES`; folders that are missing are made.
    found : BoardCalibration
        The calibration.

    Raises
    ------
    OSError
        If writing there fails.

    """
    figure = Figure(figsize=(13.0, 10.0), layout='constrained')
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, 2)
    _coverage(figure.add_subplot(grid[0, 0]), found)
    _residuals(figure.add_subplot(grid[0, 1]), found)
    _tilts(figure.add_subplot(grid[1, 0]), found)
    _histogram(figure.add_subplot(grid[1, 1]), found)
    model = found.model
    figure.suptitle(
        f'{model.name}: {model.width} x {model.height} px, {model.distortion_model}, '
        f'{len(found.views)} views, {found.rms:.4f} px rms',
        fontsize=15,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100)


def _frame(axes: Axes, found: BoardCalibration, title: str) -> None:
    """Make axes those of the image: y down, equal scales."""
    model = found.model
    axes.set(
        title=title,
        xlabel='x (px)',
        ylabel='y (px)',
        xlim=(-0.5, model.width - 0.5),
        ylim=(model.height - 0.5, -0.5),
        aspect='equal',
    )


def _coverage(axes: Axes, found: BoardCalibration) -> None:
    """Draw all points over the image, and the fields that should each hold some."""
    places = np.vstack([view.places for view in found.views])
    _frame(axes, found, f'{len(places)} points: each of the nine fields needs some')
    for part in BORDERS:
        axes.axvline(part * found.model.width - 0.5, color='0.8', zorder=0)
        axes.axhline(part * found.model.height - 0.5, color='0.8', zorder=0)
    axes.plot(*places.T, '.', color=POINT, markersize=4, alpha=0.6)
    principal = float(found.values[2]), float(found.values[3])
    axes.plot(*principal, '+', color=ARROW, markersize=16, markeredgewidth=2)
    axes.annotate(
        'principal point', principal, (8, 8), textcoords='offset points', color=ARROW,
        bbox={'facecolor': 'white', 'edgecolor': 'none', 'alpha': 0.8, 'pad': 1.5},
    )


def _residuals(axes: Axes, found: BoardCalibration) -> None:
    """Draw what is left at each point, enlarged."""
    places = np.vstack([view.places for view in found.views])
    left = np.vstack(found.residuals)
    scale = ARROW_LENGTH * found.model.width / max(found.rms, 1e-12)
    digits = 10.0 ** np.floor(np.log10(scale))
    scale = digits * np.floor(scale / digits)  # one digit, which a reader can work with
    _frame(axes, found, f'residuals, {scale:g} times enlarged')
    axes.quiver(
        *places.T, *left.T, angles='xy', scale_units='xy', scale=1.0 / scale, color=ARROW,
        width=0.002,
    )


def _tilts(axes: Axes, found: BoardCalibration) -> None:
    """Draw how far each view is turned; the colour is its rms."""
    turned = np.degrees(tilts(found))
    reach = max(50.0, 1.1 * float(np.abs(turned).max()))
    for radius in (15.0, 30.0, 45.0):
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color='0.85', zorder=0)
        axes.annotate(f'{radius:.0f}°', (0.0, radius), color='0.5', ha='center', va='bottom')
    dots = axes.scatter(
        turned[:, 0], turned[:, 1], c=1e3 * found.view_rms, s=60, cmap='viridis', edgecolor=LINE,
        linewidth=0.6,
    )
    axes.figure.colorbar(dots, ax=axes, label='rms of the view (0.001 px)')
    axes.set(
        title='tilt of the views: they should lie all round, 20° to 45° out',
        xlabel='turned about the upright axis (degrees)',
        ylabel='turned about the level axis (degrees)',
        xlim=(-reach, reach),
        ylim=(-reach, reach),
        aspect='equal',
    )


def _histogram(axes: Axes, found: BoardCalibration) -> None:
    """Draw the residuals of both coordinates beside the Gaussian of their sigma."""
    values = np.vstack(found.residuals).ravel()
    reach = max(5.0 * found.sigma, float(np.abs(values).max()))
    bins = np.linspace(-reach, reach, BINS + 1)
    axes.hist(values, bins=bins.tolist(), color=POINT, alpha=0.7, label='residuals of x and y')
    places = np.linspace(-reach, reach, 401)
    expected = np.exp(-0.5 * (places / found.sigma) ** 2) / (np.sqrt(2 * np.pi) * found.sigma)
    axes.plot(
        places, expected * len(values) * (bins[1] - bins[0]), color=LINE, linewidth=2,
        label=f'Gaussian of sigma {found.sigma:.4f} px',
    )
    axes.set(title='residuals: place less projection', xlabel='px', ylabel='count')
    axes.margins(y=0.18)
    axes.legend(loc='upper right')

"""A learned pulse: its surface, its sections beside a Gaussian, and how surely it is known."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.location import Learned
from matplotlib.figure import Figure
import numpy as np

POINTS = 121
REACH = 5.0  # sigma


def draw_pulse(
    path: Path, learned: Learned, phase: np.ndarray, residual: np.ndarray, error: np.ndarray
) -> None:
    """
    Write the picture.

    Parameters
    ----------
    path : Path
        The PNG to write.
    learned : Learned
        The pulse.
    phase, residual, error : (m,) arrays
        Sub-pixel phase along x, px, the mean residual of the pixels at a window's peak there,
        and its standard error, in standard deviations of a pixel.

    """
    pulse = learned.pulse
    reach = min(pulse.reach, max(REACH * pulse.sigma, 3.0))
    along = np.linspace(-reach, reach, POINTS)
    figure = Figure(figsize=(11, 3.8), layout='constrained')
    surface, section, phases = figure.subplots(1, 3)
    picture = surface.imshow(
        pulse.value(along[None, :], along[:, None]), extent=(-reach, reach, reach, -reach),
        cmap='magma',
    )
    figure.colorbar(picture, ax=surface, shrink=0.8)
    surface.set(title=f'Pulse of {learned.windows} windows', xlabel='x (px)', ylabel='y (px)')
    width = np.sqrt(pulse.sigma**2 + 1.0 / 12.0)  # with the pixel in it
    section.plot(along, np.exp(-0.5 * (along / width) ** 2), 'k:', label='Gaussian')
    section.plot(along, pulse.value(along, 0.0), label='along x')
    section.plot(along, pulse.value(0.0, along), label='along y')
    section.set(title='Sections through the centre', xlabel='offset (px)')
    section.legend()
    phases.axhline(0.0, color='grey', linewidth=0.8)
    phases.errorbar(phase, residual, error, fmt='o-', capsize=3)
    phases.set(
        title='What the pulse leaves at the peak', xlabel='sub-pixel phase along x (px)',
        ylabel='mean residual (standard deviations)',
    )
    figure.savefig(path, dpi=110)

"""trackpy: iterated centre of mass in a circular mask (Crocker and Grier)."""

from __future__ import annotations

from benchmarks.contender import Contender
from benchmarks.windows import mosaic, Positions, signal, Windows
import numpy as np
from trackpy.refine.center_of_mass import refine_com_arr

TURNS = 3  # the blob is within a pixel of the middle


def _refine(windows: Windows) -> Positions:
    height, width = windows.lit.shape[1:]
    radius = (min(height, width) - 1) // 2
    # The mask walks by a pixel a turn: the margin keeps it off the next window.
    picture, (columns, rows) = mosaic(np.maximum(signal(windows), 0.0), TURNS)
    start = np.stack([rows + (height - 1) / 2, columns + (width - 1) / 2], axis=1)
    found = refine_com_arr(
        picture,
        picture,
        radius,
        start,
        max_iterations=TURNS,
        characterize=False,
        engine='numba',
    )
    return found[:, 1] - columns, found[:, 0] - rows


PEERS = (
    Contender(
        'trackpy refine_com',
        'background subtracted, below zero set to zero, mask as wide as the window',
        _refine,
    ),
)

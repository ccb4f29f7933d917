"""Where the charge goes that a full pixel cannot hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def spill(charge: NDArray[np.float32], full_well: float) -> None:
    """
    Let what a pixel cannot hold run along its column, half of it up and half of it down.

    Each pixel on the way takes what it has room for; what comes to the end of the column is
    lost. All else stays: the sum over the column does not change.

    Parameters
    ----------
    charge : (..., h, w) array
        Of any unit; written to.
    full_well : float
        What a pixel holds, of the same unit.

    """
    excess = np.maximum(charge - full_well, 0.0)
    columns = excess.any(axis=-2)
    if not columns.any():
        return
    rows = np.moveaxis(charge, -2, 0)
    held = np.minimum(rows[:, columns], full_well)
    halves = 0.5 * np.moveaxis(excess, -2, 0)[:, columns]
    for order in (range(len(held)), reversed(range(len(held)))):
        running = np.zeros_like(held[0])
        for row in order:
            running += halves[row]
            taken = np.minimum(running, full_well - held[row])
            held[row] += taken
            running -= taken
    rows[:, columns] = held

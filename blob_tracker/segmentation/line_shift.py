"""Whether a light in both frames of a pair is shared between them line by line."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

# Flashes over which a shift between the lit and the unlit frame is measured, and those it takes.
MOST_SHIFTS, LEAST_SHIFTS = 48, 12
CHECKED = 6  # flashes from one look at them to the next
LEAST_T = 5.0  # of its standard deviations, from which on it is one
# Of the square of a column of the line's equations, what the columns before it leave of it: less
# is rounding.
INDEPENDENT = 1e-12


class LineShift(NamedTuple):
    """
    Where a light that is in both frames of a pair stands in the one and in the other.

    A light that is switched while its lines are read one after the other stands higher in the one
    frame: that has its upper lines, the other its lower ones.

    Parameters
    ----------
    places : (3,) array
        Its rows in the last lit frames, px.
    rows : (n, 3) array
        Of the last flashes in turn: what it moved by since the flash before, how its path bent,
        and how far below its place in the lit frame it stood in the unlit one, px.
    counts : (3,) int64 array
        Lit frames and rows so far, and whether a shift is seen that neither its speed nor the
        bend of its path explains, 1 or 0.

    """

    places: Array
    rows: Array
    counts: NDArray[np.int64]


def no_shift() -> LineShift:
    """Return the memory of a light of which nothing is known."""
    return LineShift(np.empty(3), np.empty((MOST_SHIFTS, 3)), np.zeros(3, np.int64))


@kernel
def take_rows(shift: LineShift, lit_y: float, unlit_y: float, there: bool) -> bool:
    """
    Take where the light is in a lit frame and in the unlit one before; tell whether it is shifted.

    Parameters
    ----------
    shift : LineShift
        Of the flashes before; this one is added.
    lit_y, unlit_y : float
        Its rows, px.
    there : bool
        Whether it is in the unlit frame.

    """
    places, rows, counts = shift
    places[0], places[1], places[2] = places[1], places[2], lit_y
    counts[0] += 1
    if there and counts[0] >= 3:
        row = rows[counts[1] % MOST_SHIFTS]
        row[0] = places[2] - places[1]
        row[1] = places[2] - 2.0 * places[1] + places[0]
        row[2] = unlit_y - places[2]
        counts[1] += 1
        if counts[1] >= LEAST_SHIFTS and counts[1] % CHECKED == 0:
            counts[2] = _is_shifted(rows[:min(counts[1], MOST_SHIFTS)])
    return bool(counts[2])


@kernel
def _is_shifted(rows: Array) -> bool:
    """
    Tell whether the last column has a mean that the others, speed and bend, do not explain.

    It is the first coefficient of a linear fit by a constant, the speed and the bend: with e what
    is left of the constant when the two others are taken off it, (e . y) / (e . e), and its
    variance is that of the residuals over e . e.
    """
    count = rows.shape[0]
    columns = np.empty((4, count))  # speed, bend, constant, shift: each less those before it
    for k in range(count):
        columns[0, k], columns[1, k] = rows[k, 0], rows[k, 1]
        columns[2, k], columns[3, k] = 1.0, rows[k, 2]
    squares, mean = np.empty(3), 0.0
    for c in range(4):
        whole = (columns[c] ** 2).sum()
        for before in range(c):
            part = (columns[c] * columns[before]).sum() / squares[before]
            columns[c] -= part * columns[before]
            if c == 3:
                mean = part  # the last one is that of the constant
        if c < 3:
            squares[c] = (columns[c] ** 2).sum()
            if squares[c] <= INDEPENDENT * max(whole, count):
                return False
    variance = (columns[3] ** 2).sum() / (count - 3) / squares[2]
    return bool(mean * mean > LEAST_T * LEAST_T * variance)

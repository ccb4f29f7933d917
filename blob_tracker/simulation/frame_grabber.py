"""Lines of a camera's cells on the pixels of a frame grabber, whose clock is not the camera's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CELLS, PIXELS = 641, 640  # in a line of the Pulnix TM-7, and of the grabber (thesis, page 11)


def grabbed(
    cells: NDArray[np.floating], *, first: int, count: int, cells_in_line: int = CELLS,
    pixels_in_line: int = PIXELS,
) -> NDArray[np.float64]:
    """
    Return the pixels of a grabber that samples a line in its own time.

    The camera holds the signal of each cell until the next one, so the line is a staircase;
    the grabber's low-pass takes its mean over each of its pixels, which begin and end with the
    line. A point at the place c of the cells is seen at (c + 1/2) p / n - 1/2 of the p pixels,
    n being the cells in a line.

    Parameters
    ----------
    cells : (..., w) array
        Mean signal of part of a line, DN.
    first : int
        Which cell of the line the first one is; the first pixel that is returned is of this
        number too.
    count : int
        Pixels to return.
    cells_in_line, pixels_in_line : int
        Of the camera and of the grabber.

    Returns
    -------
    (..., count) array
        DN.

    Raises
    ------
    ValueError
        If the cells do not cover the pixels.

    """
    ratio = cells_in_line / pixels_in_line
    borders = (first + np.arange(count + 1)) * ratio - first
    if first < 0 or borders[-1] > cells.shape[-1] + 1e-9:
        raise ValueError(
            f'{cells.shape[-1]} cells from number {first} do not cover {count} pixels of '
            f'{ratio:.4f} cells each'
        )
    steps = np.arange(cells.shape[-1] + 1)
    sums = np.concatenate(
        [np.zeros((*cells.shape[:-1], 1)), np.cumsum(cells, axis=-1)], axis=-1
    ).reshape(-1, steps.size)
    integral = np.stack([np.interp(borders, steps, row) for row in sums])
    return (np.diff(integral, axis=-1) / ratio).reshape(*cells.shape[:-1], count)

"""Pixels of a window that do not see the light: stuck at a value, or black."""

from __future__ import annotations

from blob_tracker.kernel import kernel
from blob_tracker.types import Pixels
import numpy as np

# Standard deviations of lit less unlit, by which all about a pixel must stand out; of one that is
# the same in both frames, to the DN, noise makes less.
LEAST_NOISES, STUCK_NOISES = 6.0, 3.0
DIP_FRACTION = 0.5  # of what both of any two opposite neighbours rose by, or a dead pixel has less


@kernel
def cut_out(
    lit: Pixels, unlit: Pixels, x0: int, y0: int, x1: int, y1: int, saturation: int, noise: float
) -> tuple[Pixels, Pixels]:
    """
    Return copies of a part of two frames, with what is dead in the lit one marked.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous, of one type.
    x0, y0, x1, y1 : int
        Columns x0 to x1 and rows y0 to y1, px.
    saturation, noise
        Those of `mark_dead`.

    Returns
    -------
    lit, unlit : (y1 - y0, x1 - x0) arrays
        DN.

    """
    above, below = lit[y0:y1, x0:x1].copy(), unlit[y0:y1, x0:x1].copy()
    mark_dead(above, below, saturation, noise)
    return above, below


@kernel
def mark_dead(lit: Pixels, unlit: Pixels, saturation: int, noise: float) -> int:
    """
    Set to full scale what cannot be light: the location leaves it out as it does the clipped.

    A pulse has no dip: wherever a pixel lies on it, it rises at least as far as the lower one of
    two opposite neighbours. A pixel that rises by less than half of that, through all four pairs,
    does not see the light. One that is black in both frames where all about it is not even without
    the light, is dead as well, on the faintest flank. (Full scale is the one value that window,
    message and location agree on for a pixel that tells nothing.)

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous, of one type; `lit` is changed.
    saturation : int
        The DN at which a pixel is clipped.
    noise : float
        Standard deviation of lit less unlit, DN.

    Returns
    -------
    int
        How many there are.

    """
    count = 0
    height, width = lit.shape
    for j in range(1, height - 1):
        for i in range(1, width - 1):
            if lit[j, i] >= saturation or unlit[j, i] >= saturation:
                continue
            rise = float(lit[j, i]) - float(unlit[j, i])
            bound = STUCK_NOISES if rise == 0.0 else LEAST_NOISES
            least = np.inf
            for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
                for u, v in ((i - dx, j - dy), (i + dx, j + dy)):
                    least = min(least, float(lit[v, u]) - float(unlit[v, u]))
                # Most pixels are told by the first pair.
                if least <= bound * noise or rise >= DIP_FRACTION * least:
                    break
            dead = least > bound * noise and rise < DIP_FRACTION * least
            if not dead and lit[j, i] == 0 and unlit[j, i] == 0:
                dead = True
                for v in range(j - 1, j + 2):
                    for u in range(i - 1, i + 2):
                        if (v != j or u != i) and unlit[v, u] < LEAST_NOISES * noise:
                            dead = False
            if dead:
                lit[j, i] = saturation
                count += 1
    return count

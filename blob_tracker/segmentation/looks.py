"""Several looks at a still target, summed into one window."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.types import Pixels
import numpy as np

FULL = 65535  # DN: clipped, in a sum of looks


def most_looks(saturation: int) -> int:
    """Return how many looks of this full scale (DN) can be summed in 16 bits; 1 or more."""
    return max((FULL - 1) // max(saturation - 1, 1), 1)


def sum_looks(looks: Sequence[Pixels], saturation: int) -> Pixels:
    """
    Return the sum of n looks, pixel by pixel.

    A sum, not a mean: it keeps the electrons per DN, so that the shot noise m / gain of a pixel
    stays true, and rounds nothing away. The read noise grows by sqrt(n). The thesis averages 5
    looks (section 5.4).

    Parameters
    ----------
    looks : sequence of (h, w) arrays
        DN, of one type.
    saturation : int
        The DN at which a pixel of one look is clipped.

    Returns
    -------
    (h, w) uint16 array
        DN; 65535 where a pixel was clipped in any of the looks. Their one look where n is 1.

    Raises
    ------
    ValueError
        Where the sum does not fit into 16 bits.

    """
    if len(looks) == 1:
        return looks[0]
    if len(looks) > most_looks(saturation):
        raise ValueError(
            f'{len(looks)} looks of up to {saturation} DN do not fit into 16 bits; '
            f'at most {most_looks(saturation)} do'
        )
    total = np.zeros(looks[0].shape, dtype=np.uint16)
    clipped = np.zeros(looks[0].shape, dtype=bool)
    for look in looks:
        total += look
        clipped |= look >= saturation
    total[clipped] = FULL
    return total

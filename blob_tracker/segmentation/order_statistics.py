"""What stands at given ranks among a few pixels: their median, their quartiles."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray


@kernel
def fill_ranks(values: NDArray[np.floating], ranks: tuple[int, ...], out: Array) -> None:
    """
    Fill in what stands at each of the ranks, were the values sorted.

    For each value it is counted how many are below it, until all ranks are found. Pixels have few
    values, and counting goes in vectors: it is done before a sort has left its first branches.

    Parameters
    ----------
    values : (n,) float32 or float64 array
        None is NaN.
    ranks : tuple of int
        From 0 to n - 1.
    out : (len(ranks),) array
        Gets the values.

    """
    missing = (1 << len(ranks)) - 1
    for value in values:
        below, upto = np.int32(0), np.int32(0)
        for k in range(np.uint64(values.size)):
            below += np.int32(values[k] < value)
            upto += np.int32(values[k] <= value)
        for place in range(len(ranks)):
            if below <= ranks[place] < upto:
                out[place] = value
                missing &= ~(1 << place)
        if missing == 0:
            break

"""sep: the windowed centroid of Source Extractor (XWIN, YWIN)."""

from __future__ import annotations

from math import ceil

from benchmarks.contender import Contender
from benchmarks.windows import mosaic, Positions, signal, Windows
import sep


def _winpos(windows: Windows) -> Positions:
    half_height, half_width = ((size - 1) / 2 for size in windows.lit.shape[1:])
    # It reads a circle of 4 sigma: the margin keeps the next window out of it.
    margin = max(1, ceil(4 * windows.sigma + 1 - min(half_height, half_width)))
    picture, (columns, rows) = mosaic(signal(windows), margin)
    x, y, _ = sep.winpos(picture, columns + half_width, rows + half_height, windows.sigma)
    return x - columns, y - rows


PEERS = (
    Contender(
        'sep winpos',
        'background subtracted, told the true sigma, started in the middle; no mask (worse)',
        _winpos,
    ),
)

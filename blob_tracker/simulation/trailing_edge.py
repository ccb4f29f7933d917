"""Pictures of a camera that over-peaks its lines: they fall off fast behind what is bright."""

from __future__ import annotations

from typing import Any

from blob_tracker.camera.trailing_edge import fading_mean, TrailingEdge
import numpy as np
from numpy.typing import NDArray

# The thesis shows Figure 5.3 and prints no number of it; these are chosen so that the model does
# what the text says (pages 102 and 103): a blob some 10 px wide falls in two thirds of the length
# of its rise, one of 80 px and more within a tenth of it as it rose.
PEAKING = 1.0
MEMORY_PX = 4.0  # px: 0.3 us of a line of 52 us and 640 px


def peaked(mean: NDArray[Any], trailing_edge: TrailingEdge) -> NDArray[np.float64]:
    r"""
    Return the mean signal behind a camera's peaking filter, not yet clipped at black.

    With m the fading mean of what came before in the line (`TrailingEdge`),

        y_k = x_k + a (x_k - m_k),   m_k+1 = e m_k + (1 - e) x_k,   e = exp(-1 / tau)

    Why it takes small, bright blobs alone, and their right side alone: on the rise of a blob
    narrower than some tau the memory is still dark, and y = (1 + a) x has the blob's own shape.
    On its fall the memory is full, a m is taken off what is left, and the sum dives through
    black, where it is clipped. In a blob much wider than tau the memory keeps up, x - m is tau
    times the slope, and y = x + a tau dx/dk is the blob itself, a little earlier. Down a
    column each pixel has a line of its own: nothing happens. As the filter belongs to the camera
    it is there with any frame grabber (thesis, page 102).

    The dive grows with the blob's brightness while the background that holds it above black
    does not: a faint blob is filtered and not clipped, and the filter can be undone exactly.

    Parameters
    ----------
    mean : (..., w) array
        DN above black, lines along the last axis; what is left of the first pixel is as it.
    trailing_edge : TrailingEdge
        The filter.

    Returns
    -------
    (..., w) array
        DN, also below 0: `expose` adds the noise and clips.

    """
    rise = np.asarray(mean, dtype=float)
    rise = rise - rise[..., :1]
    memory = fading_mean(rise, trailing_edge.memory)
    return np.asarray(mean + trailing_edge.peaking * (rise - memory))

"""The light in which the scene is seen: it may change, and a rolling shutter shows it as bands."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.waveforms import SLICES, Waveform
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class AmbientLight:
    """
    A light on all that was drawn before it.

    Parameters
    ----------
    waveform : callable
        From times, s, to brightness; 1 leaves the picture as it is.
    readout : float
        Time from the first row's exposure to the last one's, as a part of the time between
        frames: 0 for a global shutter, near 1 for most rolling ones.

    """

    waveform: Waveform
    readout: float = 0.0

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Multiply each row by the mean brightness of its own exposure."""
        rows = (np.arange(len(picture)) + 0.5) / len(picture) - 0.5
        middles = shot.time + self.readout * shot.interval * rows
        # The integral at fine steps; a row's mean is the difference of two values.
        step = shot.exposure / SLICES
        first = middles[0] - 0.5 * shot.exposure
        count = int(np.ceil((middles[-1] - middles[0]) / step)) + SLICES + 1
        edges = first + step * np.arange(count + 1)
        total = np.concatenate([[0.0], np.cumsum(self.waveform(edges[:-1] + 0.5 * step)) * step])
        half = 0.5 * shot.exposure
        gained = np.interp(middles + half, edges, total) - np.interp(middles - half, edges, total)
        picture *= (gained / shot.exposure).astype(np.float32)[:, None]

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

    Examples
    --------
    A lamp that flickers at 100 Hz, and a frame exposed for all of its period:

    >>> from blob_tracker.simulation import Scene, sinusoid
    >>> lamp, picture = AmbientLight(sinusoid(100.0, 0.5)), np.full((48, 64), 40.0, np.float32)
    >>> lamp.draw(picture, Scene(width=64, height=48, rate=100.0, exposure=1.0).shot(0))
    >>> round(float(picture.mean()), 1)  # DN
    40.0

    """

    waveform: Waveform

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Multiply each row by the mean brightness of its own exposure."""
        middles = shot.time_of(np.arange(len(picture), dtype=float))
        # The integral at fine steps; a row's mean is the difference of two values.
        step = shot.exposure / SLICES
        first = middles[0] - 0.5 * shot.exposure
        count = int(np.ceil((middles[-1] - middles[0]) / step)) + SLICES + 1
        edges = first + step * np.arange(count + 1)
        total = np.concatenate([[0.0], np.cumsum(self.waveform(edges[:-1] + 0.5 * step)) * step])
        half = 0.5 * shot.exposure
        gained = np.interp(middles + half, edges, total) - np.interp(middles - half, edges, total)
        picture *= (gained / shot.exposure).astype(np.float32)[:, None]

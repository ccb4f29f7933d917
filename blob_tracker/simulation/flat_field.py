"""A sensor before an even light: what photon transfer looks at."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import Pixels
import numpy as np


@dataclass(frozen=True)
class FlatField:
    """
    A sensor, evenly lit.

    Parameters
    ----------
    sensor : Sensor
        Whose pixels may differ.
    width, height : int
        Size, px.

    Examples
    --------
    Pixels whose response differs by 1 %, at 100 DN:

    >>> field = FlatField(Sensor(prnu=0.01), width=160, height=120)
    >>> pixels = field.frame(100.0, np.random.default_rng(1))  # DN
    >>> pixels.shape, round(float(pixels.mean()))
    ((120, 160), 100)

    """

    sensor: Sensor
    width: int = 640
    height: int = 480

    def frame(self, signal: float, random: np.random.Generator) -> Pixels:
        """
        Return the (h, w) pixels of one frame, DN.

        Parameters
        ----------
        signal : float
            Mean signal above the black level, DN; 0 is dark.
        random : Generator
            Source of the temporal noise.

        """
        level = self.sensor.noise.black_level + signal
        return self.sensor.expose(np.full((self.height, self.width), level), random)

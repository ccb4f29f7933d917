"""A sensor before an even light: what photon transfer looks at."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Pixels, SensorNoise
import numpy as np


@dataclass(frozen=True)
class FlatField:
    """
    A sensor whose pixels differ, evenly lit.

    Parameters
    ----------
    noise : SensorNoise
        Gain, read noise and black level.
    prnu : float
        Standard deviation of the pixels' response over its mean.
    dsnu : float
        Standard deviation of the pixels' black levels, DN.
    saturation : int
        Full scale, DN.
    full_well : float
        Greatest charge of a pixel, as DN above its black level: charge beyond it is lost, and
        the noise of that charge with it.
    width, height : int
        Size, px.
    seed : int
        Of the pixels' differences.

    """

    noise: SensorNoise
    prnu: float = 0.0
    dsnu: float = 0.0
    saturation: int = 255
    full_well: float = inf
    width: int = 640
    height: int = 480
    seed: int = 1

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
        shape = (self.height, self.width)
        own = np.random.default_rng(self.seed)
        response = 1.0 + self.prnu * own.standard_normal(shape)
        black = self.noise.black_level + self.dsnu * own.standard_normal(shape)
        charge = signal * response
        shot_noise = np.sqrt(np.maximum(charge, 0.0) / self.noise.gain)
        charge += shot_noise * random.standard_normal(shape)
        # What is left is read out: its noise comes after the well.
        read_out = SensorNoise(inf, self.noise.read_noise)
        return expose(
            black + np.minimum(charge, self.full_well), read_out, random,
            saturation=self.saturation,
        )

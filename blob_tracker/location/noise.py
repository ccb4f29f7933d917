"""Variance of a pixel from its mean signal."""

from __future__ import annotations

from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray


def pixel_variance(mean: NDArray[np.float64], noise: SensorNoise) -> NDArray[np.float64]:
    """
    Return m / gain + read_noise^2 + 1/12 for each mean m.

    Parameters
    ----------
    mean : array
        Mean signal, DN; below zero it counts as zero.
    noise : SensorNoise
        Gain in electrons per DN, read noise in DN.

    Returns
    -------
    array
        Variance, DN^2 (EMVA 1288, eq. 12; the 1/12 is quantisation, thesis 2.2.2).

    """
    return np.maximum(mean, 0.0) / noise.gain + (noise.read_noise**2 + 1.0 / 12.0)

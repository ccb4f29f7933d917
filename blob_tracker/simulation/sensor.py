"""A sensor: mean signal in, noisy and quantised DN out."""

from __future__ import annotations

from blob_tracker.simulation.noise_bank import NoiseBank
from blob_tracker.types import Pixels, SensorNoise
import numpy as np
from numpy.typing import NDArray


def expose(
    mean: NDArray[np.floating],
    noise: SensorNoise,
    random: np.random.Generator | NoiseBank,
    *,
    saturation: int = 255,
) -> Pixels:
    """
    Draw pixels about their mean: shot noise, read noise, rounding, clipping.

    Shot noise is drawn as a Gaussian of the Poisson's variance, which is within a few per cent
    in every moment above about 20 electrons and several times faster.

    Parameters
    ----------
    mean : array
        DN, the black level included.
    noise : SensorNoise
        Gain in electrons per DN, read noise and black level in DN.
    random : Generator or NoiseBank
        Source of the noise; the same state gives the same bits.
    saturation : int
        Full scale, DN: 255 gives uint8, more gives uint16.

    Returns
    -------
    array of uint8 or uint16
        DN, of the shape of `mean`.

    """
    # In place: a new array of a frame's size costs more than the sums on it.
    deviation = np.maximum(mean, noise.black_level)
    deviation -= noise.black_level
    deviation /= noise.gain
    deviation += noise.read_noise**2
    np.sqrt(deviation, out=deviation)
    pixels = np.multiply(
        random.standard_normal(mean.shape, dtype=np.float32),
        deviation.astype(np.float32, copy=False),
    )
    pixels += mean.astype(np.float32, copy=False)
    np.rint(pixels, out=pixels)
    np.clip(pixels, 0, saturation, out=pixels)
    return pixels.astype(np.uint8 if saturation < 256 else np.uint16)

"""Variance of a pixel from its mean signal."""

from __future__ import annotations

import math

from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray


def pixel_variance(mean: NDArray[np.float64], noise: SensorNoise) -> NDArray[np.float64]:
    """
    Return max(m - black_level, 0) / gain + read_noise^2 + 1/12 for each mean m.

    Parameters
    ----------
    mean : array
        DN; below the black level there is no less noise than at it.
    noise : SensorNoise
        Gain in electrons per DN, read noise and black level in DN.

    Returns
    -------
    array
        Variance, DN^2 (EMVA 1288, eq. 12; the 1/12 is quantisation, thesis 2.2.2).

    """
    return np.maximum(mean, noise.black_level) / noise.gain + _floor(noise)


def variance_at(mean: float, noise: SensorNoise) -> float:
    """Return `pixel_variance` of one mean, DN, in a twentieth of the time."""
    return max(mean, noise.black_level) / noise.gain + _floor(noise)


def _floor(noise: SensorNoise) -> float:
    """Return the variance that a mean of 0 DN would have if shot noise went on below black."""
    return noise.read_noise**2 + 1.0 / 12.0 - noise.black_level / noise.gain


def noise_of_sum(noise: SensorNoise, looks: int) -> SensorNoise:
    """
    Return the noise of a pixel that is the sum of k frames.

    The sum keeps the electrons per DN; what each frame adds by itself is there k times:

        (m - k black_level) / gain + k (read_noise^2 + 1/12)

    with m the mean of the sum. The thesis averages 5 frames (section 5.4).

    Parameters
    ----------
    noise : SensorNoise
        Of one frame.
    looks : int
        k.

    Returns
    -------
    SensorNoise
        Whose own 1/12 is one of the k.

    """
    if looks == 1:
        return noise
    return SensorNoise(
        noise.gain,
        math.sqrt(looks * noise.read_noise**2 + (looks - 1) / 12.0),
        looks * noise.black_level,
    )


def variance_ratio(
    levels: NDArray[np.float64], first: SensorNoise, second: SensorNoise
) -> float:
    """
    Return the variance by one noise over that by another, where they differ most.

    Parameters
    ----------
    levels : (n,) array
        Means at which they are compared, DN.
    first, second : SensorNoise
        Above and below in the ratio.

    """
    ratios = pixel_variance(levels, first) / pixel_variance(levels, second)
    return float(ratios[np.abs(np.log(ratios)).argmax()])


def noise_in_words(noise: SensorNoise) -> str:
    """Return gain, read noise and black level with their units."""
    return f'{noise.gain:.4g} e-/DN, {noise.read_noise:.3g} DN, {noise.black_level:.4g} DN'

"""From a signal to digital numbers, and the model of it in the thesis."""

from __future__ import annotations

from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray


def quantise(signal: NDArray[np.float32], full_scale: int) -> Pixels:
    """
    Round to the nearest number of 0 to full scale.

    Parameters
    ----------
    signal : array
        DN; rounded in place.
    full_scale : int
        DN: 255 gives uint8, more gives uint16.

    Returns
    -------
    array of uint8 or uint16
        DN.

    """
    np.rint(signal, out=signal)
    np.clip(signal, 0, full_scale, out=signal)
    return signal.astype(np.uint8 if full_scale < 256 else np.uint16)


def gain_plus_uniform(
    signal: NDArray[np.floating],
    gain: float,
    random: np.random.Generator,
    *,
    deviation: float = 0.0,
) -> NDArray[np.float64]:
    """
    Return what a quantiser gives by the thesis' model of it, which rounds nothing.

        f = alpha I + u + n    (thesis, eq. 2.6 and 2.7)

    Parameters
    ----------
    signal : array
        I, DN.
    gain : float
        alpha, at most 1.
    random : Generator
        Of u, uniform over (-0.5, 0.5), and n.
    deviation : float
        Standard deviation of n, DN; 0 leaves it out (eq. 2.6).

    Returns
    -------
    array
        DN, real numbers.

    Examples
    --------
    The scatter of the uniform distribution, 1 / sqrt(12) DN:

    >>> given = gain_plus_uniform(np.full(10_000, 100.0), 0.9, np.random.default_rng(1))
    >>> round(float(given.mean())), round(float(given.std()), 2)  # DN
    (90, 0.29)

    """
    uniform = random.uniform(-0.5, 0.5, np.shape(signal))
    found = gain * np.asarray(signal, dtype=np.float64) + uniform
    if deviation:
        found += deviation * random.standard_normal(np.shape(signal))
    return found

"""The light of the target alone: lit less unlit, or lit less the window's border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from blob_tracker.location.noise import pixel_variance
from blob_tracker.types import SensorNoise


@dataclass(frozen=True)
class Signal:
    """
    Pixels of N windows above their background.

    Parameters
    ----------
    pixels : (N, h, w) array
        DN.
    variance : (N, h, w) array
        Noise of the pixels, DN^2; that of the background's mean is left out.
    background : (N,) array
        Level that was taken off (its mean where it was a window), DN.
    border : (h, w) array
        Weight of each lit pixel in the background; 0 where an unlit window gave it.

    """

    pixels: NDArray[np.float64]
    variance: NDArray[np.float64]
    background: NDArray[np.float64]
    border: NDArray[np.float64]

    def spread(self, influence: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Return the (N, P, P) covariance of P sums that move by `influence` with the pixels.

        `influence` is (N, P, h, w); a border pixel also moves the background, and with it all.
        """
        lifted = influence - influence.sum(axis=(2, 3), keepdims=True) * self.border
        count, sums = influence.shape[:2]
        flat = lifted.reshape(count, sums, -1)
        return (flat * self.variance.reshape(count, 1, -1)) @ flat.transpose(0, 2, 1)

    def quality(
        self, amplitude: NDArray[np.float64], model: NDArray[np.float64], parameters: int,
        noise: SensorNoise,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the SNR of the peak and the chi2 per degree of freedom of a (N, h, w) model."""
        peak = pixel_variance(amplitude + self.background, noise)
        if not self.border.any():
            peak = peak + pixel_variance(self.background, noise)
        squares = ((self.pixels - model) ** 2 / self.variance).sum(axis=(1, 2))
        return amplitude / np.sqrt(peak), squares / max(self.border.size - parameters, 1)


def signal_above_background(
    lit: NDArray[np.float64], unlit: NDArray[np.float64] | None, noise: SensorNoise
) -> Signal:
    """
    Return lit - unlit, or lit less the mean of the window's border where unlit is None.

    The mean, not the median: the median of rounded pixels moves in steps of half a DN.
    """
    border = np.zeros(lit.shape[1:])
    if unlit is not None:
        variance = pixel_variance(lit, noise) + pixel_variance(unlit, noise)
        return Signal(lit - unlit, variance, unlit.mean(axis=(1, 2)), border)
    border[0], border[-1], border[:, 0], border[:, -1] = 1.0, 1.0, 1.0, 1.0
    border /= border.sum()
    background = np.einsum('nhw,hw->n', lit, border)
    return Signal(
        lit - background[:, None, None], pixel_variance(lit, noise), background, border
    )


def count_clipped(lit: NDArray[np.float64], saturation: float | None) -> NDArray[np.int64]:
    """Return how many pixels of each (h, w) window are clipped."""
    if saturation is None:
        return np.zeros(lit.shape[0], dtype=np.int64)
    return (lit >= saturation).sum(axis=(1, 2))

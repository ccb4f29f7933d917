"""The light of the target alone: lit less unlit, or lit less the window's corners."""

from __future__ import annotations

from dataclasses import dataclass
import functools

from blob_tracker.location.noise import pixel_variance
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray


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
    corners : (h, w) array
        Weight of each lit pixel in the background; 0 where an unlit window gave it.

    """

    pixels: NDArray[np.float64]
    variance: NDArray[np.float64]
    background: NDArray[np.float64]
    corners: NDArray[np.float64]

    def spread(self, influence: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Return the (N, P, P) covariance of P sums that move by `influence` with the pixels.

        `influence` is (N, P, h, w); a pixel of the corners also moves the background, and with
        it all.
        """
        lifted = influence - influence.sum(axis=(2, 3), keepdims=True) * self.corners
        count, sums = influence.shape[:2]
        flat = lifted.reshape(count, sums, -1)
        return (flat * self.variance.reshape(count, 1, -1)) @ flat.transpose(0, 2, 1)

    def quality(
        self, amplitude: NDArray[np.float64], model: NDArray[np.float64], parameters: int,
        noise: SensorNoise,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the SNR of the peak and the chi2 per degree of freedom of a (N, h, w) model."""
        peak = pixel_variance(amplitude + self.background, noise)
        if not self.corners.any():
            peak = peak + pixel_variance(self.background, noise)
        squares = ((self.pixels - model) ** 2 / self.variance).sum(axis=(1, 2))
        return amplitude / np.sqrt(peak), squares / max(self.corners.size - parameters, 1)


@functools.cache
def corner_weights(height: int, width: int) -> NDArray[np.float64]:
    """
    Return the (h, w) weight of each lit pixel in the background where no unlit window gives it.

    The third of the window's border that lies nearest its corners, evenly: the skirt of a pulse
    reaches the middle of a side first and a corner last (at 9 x 9 and sigma 1.5 the whole border
    holds 1 % of the peak, these twelve pixels a tenth of that). A mean, not a median: the median
    of rounded pixels moves in steps of half a DN, and the mean's noise and its share of the
    pulse are those of a sum.
    """
    rows = np.abs(np.linspace(-1.0, 1.0, height))[:, None]
    columns = np.abs(np.linspace(-1.0, 1.0, width))
    # Of a border pixel one term is 1; 1e-9 is for the rounding of thirds.
    inside = (np.maximum(rows, columns) == 1.0) & (rows + columns >= 5.0 / 3.0 - 1e-9)
    return inside / inside.sum()


def signal_above_background(
    lit: NDArray[np.float64], unlit: NDArray[np.float64] | None, noise: SensorNoise
) -> Signal:
    """Return lit - unlit, or lit less the mean of the window's corners where unlit is None."""
    if unlit is not None:
        variance = pixel_variance(lit, noise) + pixel_variance(unlit, noise)
        none = np.zeros(lit.shape[1:])
        return Signal(lit - unlit, variance, unlit.mean(axis=(1, 2)), none)
    corners = corner_weights(*lit.shape[1:])
    background = np.einsum('nhw,hw->n', lit, corners)
    return Signal(
        lit - background[:, None, None], pixel_variance(lit, noise), background, corners
    )


def count_clipped(lit: NDArray[np.float64], saturation: float | None) -> NDArray[np.int64]:
    """Return how many pixels of each (h, w) window are clipped."""
    if saturation is None:
        return np.zeros(lit.shape[0], dtype=np.int64)
    return (lit >= saturation).sum(axis=(1, 2))

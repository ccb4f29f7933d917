"""
The Cramer-Rao bound of a scene, by numerical derivatives of the light itself.

Kept apart from `blob_tracker.location.limits` on purpose: a benchmark that took the bound from
the code that it judges would not notice an error in it. It also knows clipped pixels.
"""

from __future__ import annotations

from blob_tracker.location.noise import pixel_variance
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

STEP = 1e-4  # px and relative; the error of a central difference is of its square


def bound(
    shape: tuple[int, int],
    parameters: NDArray[np.float64],
    noise: SensorNoise,
    *,
    unlit: NDArray[np.float64] | None = None,
    used: NDArray[np.bool_] | None = None,
    elliptical: bool = False,
) -> NDArray[np.float64]:
    """
    Return the bound of x and y, (2, 2) px^2.

    I_pq = sum_k (d mu_k/d p)(d mu_k/d q) / v_k with the variance v_k of the pixel's mean
    (Huang et al., Nature Methods 10 (2013), eq. 3.6), inverted. Without an unlit window the
    background is a parameter; with one, the pixel is lit less unlit and its variance holds the
    unlit light and the fixed noise twice.

    Parameters
    ----------
    shape : (int, int)
        Height and width, px.
    parameters : (6,) array
        x, y, sigma_x, sigma_y (px), amplitude, background (DN).
    noise : SensorNoise
        Gain and read noise.
    unlit : (h, w) array or None
        Mean of the unlit window, DN.
    used : (h, w) bool array or None
        False where a pixel is clipped and tells nothing.
    elliptical : bool
        Two widths in the fit instead of one.

    """

    def mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y, sigma_x, sigma_y, amplitude, background = values
        return amplitude * pixel_integrated_gaussian(shape, x, y, sigma_x, sigma_y) + background

    def slope(direction: NDArray[np.float64]) -> NDArray[np.float64]:
        return (mean(parameters + direction) - mean(parameters - direction)) / (2 * STEP)

    steps = STEP * np.eye(6)
    directions = [steps[0], steps[1], steps[4]]
    directions += [steps[2], steps[3]] if elliptical else [steps[2] + steps[3]]
    if unlit is None:
        directions.append(steps[5])
        variance = pixel_variance(mean(parameters), noise)
    else:
        pulse = mean(parameters) - parameters[5]
        variance = pixel_variance(pulse + unlit, noise) + pixel_variance(unlit, noise)
    slopes = np.stack([slope(direction) for direction in directions])
    weight = 1.0 / variance
    if used is not None:
        weight = np.where(used, weight, 0.0)
    information = np.einsum('phw,qhw,hw->pq', slopes, slopes, weight)
    return np.linalg.inv(information)[:2, :2]

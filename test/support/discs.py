"""Windows of lights that are discs, drawn finely and summed."""

from __future__ import annotations

from blob_tracker.types import SensorNoise, Window
import numpy as np
from scipy.ndimage import gaussian_filter

NOISE = SensorNoise(40.0, 0.7)
BACKGROUND = 20.0  # DN
FINE = 7  # parts of a pixel


def disc_window(
    radius: float, psf_sigma: float, flux: float, side: int, random: np.random.Generator,
    *, unlit: bool = True,
) -> Window:
    """Return a noisy window with a disc, px and DN, near its middle."""
    x, y = (side - 1) / 2 + random.uniform(-0.5, 0.5, 2)
    at = (np.arange(side * FINE) + 0.5) / FINE - 0.5
    distances = np.hypot(at - x, at[:, None] - y)
    if radius > 0.0:
        disc = np.clip((radius - distances) * FINE + 0.5, 0.0, 1.0)
        light = gaussian_filter(disc / disc.sum(), psf_sigma * FINE, mode='constant')
    else:
        light = np.exp(-(distances**2) / (2.0 * psf_sigma**2))
        light /= light.sum()
    mean = BACKGROUND + flux * light.reshape(side, FINE, side, FINE).sum(axis=(1, 3))

    def exposed(mean: np.ndarray) -> np.ndarray:
        deviation = np.sqrt(mean / NOISE.gain + NOISE.read_noise**2)
        noisy = mean + deviation * random.normal(size=mean.shape)
        return np.rint(np.clip(noisy, 0.0, 65535.0)).astype(np.uint16)

    return Window(
        exposed(mean), exposed(np.full_like(mean, BACKGROUND)) if unlit else None,
        stamp_ns=10**18,
    )

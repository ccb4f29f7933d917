"""Where the light of a window is and how far it spreads: where the fits of shapes begin."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.location.hypotheses import Pair
import numpy as np
from numpy.typing import NDArray

PART_OF_PEAK = 0.3  # of the brightest 3 x 3 pixels, above which they are the light's
NARROWEST = 0.5  # px


@dataclass(frozen=True)
class LightMoments:
    """
    The pixels that are brighter than a part of the brightest ones.

    Parameters
    ----------
    x, y : float
        Their centroid, px.
    direction : (2,) array
        Unit vector along which they spread most.
    along, across : float
        Standard deviations along it and across, px.
    radius : float
        Within which nine tenths of them are, px.
    peak, background : float
        DN.

    """

    x: float
    y: float
    direction: NDArray[np.float64]
    along: float
    across: float
    radius: float
    peak: float
    background: float


def light_moments(pair: Pair) -> LightMoments:
    """Return the moments of the lit pixels, clipped ones as bright as the brightest."""
    height, width = pair.lit.shape
    edge = np.concatenate([
        pair.lit[0], pair.lit[-1], pair.lit[:, 0], pair.lit[:, -1],
    ])
    background = float(np.median(edge if pair.unlit is None else pair.unlit))
    signal = pair.lit - background
    padded = np.pad(signal, 1, mode='edge')
    smooth = np.mean(
        [padded[j:j + height, i:i + width] for j in range(3) for i in range(3)], axis=0
    )
    peak = float(smooth.max())
    rows, columns = np.nonzero(smooth >= min(PART_OF_PEAK * peak, peak))
    weight = np.maximum(smooth[rows, columns], 0.0)
    weight = weight / max(float(weight.sum()), 1e-9)
    x, y = float(weight @ columns), float(weight @ rows)
    apart = np.stack([columns - x, rows - y])
    values, axes = np.linalg.eigh((weight * apart) @ apart.T)
    return LightMoments(
        x, y, axes[:, 1], float(np.sqrt(max(values[1], NARROWEST**2))),
        float(np.sqrt(max(values[0], NARROWEST**2))),
        float(np.quantile(np.hypot(*apart), 0.9)), max(float(signal.max()), 1.0), background,
    )

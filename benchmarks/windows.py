"""The stack of windows that every contender gets, and what a peer may need to have done first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from blob_tracker.location.noise import pixel_variance
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

Positions = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True)
class Windows:
    """
    Raw windows of one size and one sensor.

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit is None if there is no unlit frame.
    noise : SensorNoise
        Gain and read noise of a pixel.
    saturation : int
        The DN at which a pixel is clipped.
    sigma : float
        Standard deviation of the blobs, px: told to the peers that must be told one.

    """

    lit: NDArray[Any]
    unlit: NDArray[Any] | None
    noise: SensorNoise
    saturation: int
    sigma: float


def take(windows: Windows, count: int) -> Windows:
    """Return the first `count` of the windows."""
    unlit = None if windows.unlit is None else windows.unlit[:count]
    return Windows(windows.lit[:count], unlit, windows.noise, windows.saturation, windows.sigma)


def signal(windows: Windows) -> NDArray[np.float64]:
    """Return (N, h, w) DN above the background: less unlit, or less the border's median."""
    lit = windows.lit.astype(float)
    if windows.unlit is not None:
        return lit - windows.unlit
    border = np.ones(lit.shape[1:], dtype=bool)
    border[1:-1, 1:-1] = False
    return lit - np.median(lit[:, border], axis=1)[:, None, None]


def signal_variance(windows: Windows) -> NDArray[np.float64]:
    """Return (N, h, w) DN^2, the variance of `signal` as the pixels themselves tell it."""
    variance = pixel_variance(windows.lit.astype(float), windows.noise)
    if windows.unlit is not None:
        variance += pixel_variance(windows.unlit.astype(float), windows.noise)
    return variance


def clipped(windows: Windows) -> NDArray[np.bool_]:
    """Return (N, h, w) True where a pixel is clipped."""
    return np.asarray(windows.lit >= windows.saturation)


def mosaic(stack: NDArray[np.float64], margin: int) -> tuple[NDArray[np.float64], Positions]:
    """
    Lay the windows out in one column with a margin of zeros around each.

    Trackers that work on a whole frame then take the stack in one call. Returned beside the
    picture are the columns and the rows of the windows' first pixels, px.
    """
    count, height, width = stack.shape
    pitch = height + 2 * margin
    picture = np.zeros((count, pitch, width + 2 * margin))
    picture[:, margin:-margin, margin:-margin] = stack
    columns, rows = np.full(count, float(margin)), np.arange(count) * float(pitch) + margin
    return np.reshape(picture, (count * pitch, -1)), (columns, np.asarray(rows))

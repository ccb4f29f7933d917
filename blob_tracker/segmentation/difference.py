"""Flash differencing: what became brighter from one frame to the next."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.types import Pixels
import cv2
import numpy as np

# Every eighth pixel along x and y is enough to know the noise to 2 % at 640 x 480.
NOISE_STEP = 8


class Rise(NamedTuple):
    """
    The strongest rise between two frames.

    Parameters
    ----------
    column, row : int
        Pixel of the strongest rise.
    height : float
        Rise in that pixel, DN.
    noise : float
        Standard deviation of the difference of two frames, DN.
    background : float
        Mean difference of the two frames, DN.

    """

    column: int
    row: int
    height: float
    noise: float
    background: float


def strongest_rise(
    current: Pixels,
    previous: Pixels,
    difference: Pixels | None = None,
) -> Rise:
    """
    Find the pixel that gained most light, in one pass over the whole frame.

    The difference is signed: it saturates at zero, so light that went out leaves nothing.

    Parameters
    ----------
    current, previous : (h, w) arrays of uint8 or uint16
        DN, of one type and size.
    difference : (h, w) array, optional
        Room for max(current - previous, 0), which is left in it.

    Returns
    -------
    Rise
        Place and height of the strongest rise, and the noise it stands in.

    """
    rise = cv2.subtract(current, previous, dst=difference)
    _, height, _, (column, row) = cv2.minMaxLoc(rise)
    coarse = np.subtract(
        current[::NOISE_STEP, ::NOISE_STEP], previous[::NOISE_STEP, ::NOISE_STEP], dtype=np.int32
    )
    # Mean absolute deviation of a Gaussian is sqrt(2 / pi) sigma; a target of a few pixels hardly
    # moves it, and unlike the median it does not step with the DN. Two roundings are the floor.
    noise = max(float(np.sqrt(np.pi / 2) * np.abs(coarse).mean()), float(np.sqrt(2 / 12)))
    return Rise(column, row, height, noise, float(coarse.mean()))

"""Flash differencing: what became brighter from one frame to the next."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray

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
    image : (h, w) array
        Rise of every pixel, DN; 0 where it fell.

    """

    column: int
    row: int
    height: float
    noise: float
    image: Pixels


def strongest_rise(current: Pixels, previous: Pixels) -> Rise:
    """
    Find the pixel of the whole frame that gained most light.

    The sign counts: what lost light is cut at zero, so a light that went out leaves nothing.

    Parameters
    ----------
    current, previous : (h, w) arrays of uint8 or uint16
        DN, of one type and size.

    Returns
    -------
    Rise
        Place and height of the strongest rise, and the noise it stands in.

    """
    rise: Pixels = np.asarray(cv2.subtract(current, previous))
    _, height, _, (column, row) = cv2.minMaxLoc(rise)
    coarse = signed_difference(
        current[::NOISE_STEP, ::NOISE_STEP], previous[::NOISE_STEP, ::NOISE_STEP]
    )
    # Mean absolute deviation of a Gaussian is sqrt(2 / pi) sigma; a target of a few pixels hardly
    # moves it, and unlike the median it does not step with the DN. Two roundings are the floor.
    noise = max(float(np.sqrt(np.pi / 2) * np.abs(coarse).mean()), float(np.sqrt(2 / 12)))
    return Rise(column, row, height, noise, rise)


def signed_difference(
    current: Pixels, previous: Pixels
) -> NDArray[np.int32]:
    """Return current - previous, DN, with its sign."""
    return current.astype(np.int32) - previous.astype(np.int32)

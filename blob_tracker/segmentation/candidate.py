"""What lit up but is not the target: hot pixels, edges, lamps that flicker, things that move."""

from __future__ import annotations

from blob_tracker.segmentation.box import Box, box_about
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.sigma_window import Extent
from blob_tracker.types import Pixels
import cv2
import numpy as np

# The four neighbours of the peak pixel have a third of its height where sigma is 0.6 px, and more
# where it is wider; those of a hot pixel have none but noise.
LONE = 0.1
LONGEST = 3.0  # times as long as wide: a moving edge, a glint's streak or a band is longer
# A lamp on the mains loses less than a fifth between two frames; of a flash nothing is left but
# the background, whose texture is not as many times higher than the flash.
STANDING = 5.0
# Two lit frames of a moving light leave a rise and an equal fall beside each other; a true flash
# leaves no fall but noise. Half-way between the two tells them apart.
LARGEST_FALL = 0.5
NOISE_FALL = 6.0  # standard deviations; no pixel of a window falls so far by noise alone


def reject(
    contrast: Contrast,
    extent: Extent | None,
    column: int,
    row: int,
    height: float,
    saturation: int,
) -> str:
    """
    Say why a peak is no target.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    extent : Extent or None
        The blob at the peak, as `measure_extent` has it.
    column, row : int
        Pixel of the peak.
    height : float
        Its height, DN.
    saturation : int
        The DN at which a pixel is clipped.

    Returns
    -------
    str
        Empty where nothing speaks against it.

    """
    if extent is None:
        return 'what lit up is no blob'
    near = box_about(column, row, 1, 1, contrast.shape)
    signal = contrast.signal(near) - contrast.background
    if signal.shape == (3, 3):
        beside = 0.25 * float(signal[0, 1] + signal[1, 0] + signal[1, 2] + signal[2, 1])
        if beside < LONE * float(signal[1, 1]):
            return f'a lone pixel rose by {height:.0f} DN: it is hot, or was hit by a particle'
    if extent.sigma_major > LONGEST * extent.sigma_minor:
        return (
            f'what lit up is {extent.sigma_major:.1f} px long and {extent.sigma_minor:.1f} px '
            'wide (sigma): an edge that moved, or a band'
        )
    if contrast.unlit is not None:
        reach = int(np.ceil(4.0 * extent.sigma_major)) + 1
        about = contrast.unlit[box_about(column, row, reach, reach, contrast.shape).slices]
        level = float(np.mean([about[0].mean(), about[-1].mean()]))
        stood = float(contrast.unlit[near.slices].mean()) - level
        rose = float(signal.mean())
        if stood > STANDING * rose:
            return (
                f'a rise of {rose:.0f} DN on {stood:.0f} DN that were there before: '
                'a lamp that flickers'
            )
        if about.max() >= saturation:
            return (
                f'a rise of {height:.0f} DN beside pixels that were clipped before: the rim of '
                'the sun or of a lamp'
            )
    return ''


def falls_beside(
    contrast: Contrast, box: Box, column: int, row: int, height: float
) -> str:
    """
    Say whether light went out beside a peak: something moved.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    box : Box
        Window of the peak; as far again on each side is looked at.
    column, row : int
        Pixel of the peak.
    height : float
        Its height, DN.

    Returns
    -------
    str
        Empty where nothing fell.

    """
    if contrast.unlit is None:
        return ''
    reach = max(box.x1 - box.x0, box.y1 - box.y0)
    about = box_about(column, row, reach, reach, contrast.shape)
    fall = contrast.background - float(contrast.signal(about).min())
    if fall <= max(LARGEST_FALL * height, NOISE_FALL * contrast.noise):
        return ''
    return (
        f'a rise of {height:.0f} DN beside a fall of {fall:.0f} DN: '
        'something moved, or the light was on in both frames'
    )


def suppress_connected(search: Pixels, column: int, row: int, least: float) -> None:
    """
    Set to 0 what hangs together with a pixel at or above a level, a whole moving edge at once.

    Parameters
    ----------
    search : (h, w) array
        DN; written to.
    column, row : int
        The pixel.
    least : float
        The level, DN.

    """
    mask = (search >= least).astype(np.uint8)
    cv2.floodFill(mask, None, (column, row), (2,), flags=8)
    search[mask == 2] = 0

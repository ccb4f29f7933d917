"""All that lit up in a contrast, judged."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, exact_kernel
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.candidates import Candidates
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.flood import flood_rise, whole_scene, without_flooded
from blob_tracker.segmentation.illumination import relit
from blob_tracker.segmentation.overexposure import clipped_pixels
from blob_tracker.segmentation.peaks import measure_peaks
from blob_tracker.segmentation.rejection import mark_glows
import numpy as np
from numpy.typing import NDArray

NO_MASK: NDArray[np.uint8] = np.empty((0, 0), np.uint8)  # the mask that leaves all open
SMALLEST_REGION_PX = 5  # px: less holds no blob with background about it
LARGEST_SIGMA_PX = 64.0  # px: what is wider is no blob
# Half of the quartiles' distance over the median of the rows' gains: exposure multiplies all by
# the same; 0.075 on real frames.
SAME_GAIN = 0.1
_NO_GAIN = (
    'not all of it by the same factor, as exposure would: keep other lights and their shadows, '
    'and what moves before the camera, out of the picture'
)
# Auto-exposure or a lamp: such a part of the scene's brightness came or went with the flash.
EXPOSURE_JUMP = 0.25
# DN that the level rises by where a flood is worth a look; where what was there is laid in new
# light as well, the scene has become twice as bright at least, which no lamp or cloud does.
LEAST_FLOOD_DN = 2.0
JUMP_NOISE_SIGMA = 4.0  # standard deviations of a pixel that the level may move by itself
JUMP_GLARE = 0.15  # of the strongest rise, which a wide blob may add to the level about it
# rms over the rows, standard deviations of a pixel: of less the scene is not laid in new light.
RELIGHTING_SIGMA = 0.75
IN_DN = [
    Candidate._fields.index(name)
    for name in (
        'background', 'height', 'amplitude', 'fall', 'unlit_amplitude', 'texture', 'noise',
        'surround_noise',
    )
]


class SearchResult(NamedTuple):
    """
    What `search` returns.

    Parameters
    ----------
    candidates : sequence of Candidate
        What lit up, the highest first.
    background, noise : float
        Median and standard deviation of lit less unlit, DN.
    strongest : float
        Greatest rise of a pixel above the background, DN.
    reason : str
        Why the two frames cannot be compared; empty if they can.

    """

    candidates: Sequence[Candidate]
    background: float
    noise: float
    strongest: float
    reason: str


def search(
    contrast: Contrast,
    region: Box,
    *,
    min_snr: float,
    followed: bool = False,
    mask: NDArray[np.uint8] = NO_MASK,
) -> SearchResult:
    """
    Find all that lit up in a part of the frame.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    region : Box
        The part of the frame, px.
    min_snr : float
        Least SNR in the matched filter.
    followed : bool
        Whether the region is that about a target that was seen before.
    mask : (h, w) uint8 array
        0 where the target cannot be; empty if it may be anywhere.

    Returns
    -------
    Found
        The candidates, rejected or not, and the noise.

    """
    left, top, right, bottom = region
    if right - left < SMALLEST_REGION_PX or bottom - top < SMALLEST_REGION_PX:
        return SearchResult((), 0.0, contrast.floor * contrast.unit, 0.0, '')
    lit, unlit, saturation = contrast.lit, contrast.unlit, contrast.saturation
    paired = bool(contrast.unlit_frames)
    where, threshold = (left, top, right, bottom), peak_threshold((right - left) * (bottom - top))
    table, gains, change, level, noise, brightness, strongest = measure_peaks(
        lit, unlit, where, mask, contrast.floor, threshold, min_snr, LARGEST_SIGMA_PX, saturation,
        not paired, followed,
    )
    reason, step = '', level
    if paired:
        if change > RELIGHTING_SIGMA * noise:
            table, _, _, level, noise, _, strongest = measure_peaks(
                lit, relit(unlit, gains, saturation), where, mask, contrast.floor, threshold,
                min_snr, LARGEST_SIGMA_PX, saturation, not paired, followed,
            )
        # In the new light: before, what the scene's texture gained or lost passes for noise.
        jump = EXPOSURE_JUMP * brightness + JUMP_NOISE_SIGMA * noise + JUMP_GLARE * strongest
        if abs(step) > jump:
            reason = (
                f'the whole scene changed by {step:+.0f} DN from {brightness:.0f} DN between the '
                'two frames: '
                + ('switch auto-exposure off' if _is_gain(gains) else _NO_GAIN)
                + (', or the flood light that flashes in step' if step > 0.0 else '')
            )
    unit = contrast.unit
    if unit != 1.0:
        table[:, IN_DN] *= unit
        level, noise, strongest = unit * level, unit * noise, unit * strongest
    lights: Sequence[Candidate] = ()
    if len(table) > 0:
        mark_glows(table)
        lights = Candidates(table, clipped_pixels(contrast, table))
    # Near a target that is followed its own glow may be all over.
    if paired and not followed and (
        level > LEAST_FLOOD_DN or unit * step > max(LEAST_FLOOD_DN, brightness)
    ):
        rise = unit * flood_rise(contrast, region)
        if rise > 0.0:
            lights = without_flooded(lights, rise)
            if all(each.rejected for each in lights):
                reason = reason or whole_scene(rise)
    return SearchResult(lights, level, noise, strongest, reason)


def _is_gain(gains: Array) -> bool:
    """Tell whether all rows changed by one factor, (n, 2) array of rows and their gains."""
    # Not the extremes: rows that are black or clipped do not follow the exposure.
    low, middle, high = np.percentile(gains[:, 1], (25, 50, 75))
    return bool(high - low <= 2.0 * SAME_GAIN * middle)


@exact_kernel
def peak_threshold(pixels: int) -> float:
    """
    Return the height of a peak, in standard deviations, that noise alone reaches once a search.

    Of n Gaussian deviates about one is above sqrt(2 ln(n / 12)) from n = 1000 to 3 million.
    """
    return math.sqrt(2.0 * math.log(max(pixels, 500) / 12.0))

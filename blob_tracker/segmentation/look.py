"""What a segmenter saw in one frame: for pictures and diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from blob_tracker.segmentation.box import Box
from blob_tracker.types import Pixels


class Candidate(NamedTuple):
    """
    Something that lit up.

    Parameters
    ----------
    x, y : float
        Centre, px of the frame as it is (crop and binning left aside).
    sigma_x, sigma_y : float
        Standard deviations along the rows and the columns, px.
    sigma_major, sigma_minor : float
        Those along the longest and the shortest axis, px.
    snr : float
        Response of the matched filter in standard deviations of its noise.
    height : float
        Rise of its brightest pixel above the background, DN.
    refused : str
        Why it is no target; empty where it may be one.

    """

    x: float
    y: float
    sigma_x: float
    sigma_y: float
    sigma_major: float
    sigma_minor: float
    snr: float
    height: float
    refused: str


class Look(NamedTuple):
    """
    One update of a segmenter.

    Parameters
    ----------
    lit : (h, w) array
        DN of the frame.
    unlit : (h, w) array or None
        DN of what was subtracted from it; None where nothing was.
    background, noise : float
        Median and standard deviation of lit less unlit where there is no target, DN.
    region : Box
        The part of the frame that was searched.
    candidates : tuple of Candidate
        What lit up there, the highest first.
    windows : mapping of str to Box
        The window of each light, by its name; the name is empty where there is only one.
    state : str
        'locked' where the target is followed, 'lost' where the whole frame is searched.
    reason : str
        Why there is no window; empty where there is one.

    """

    lit: Pixels
    unlit: Pixels | None
    background: float
    noise: float
    region: Box
    candidates: tuple[Candidate, ...]
    windows: Mapping[str, Box]
    state: str
    reason: str

"""What a segmenter saw in one frame: for pictures and diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.types import Pixels


class Detections(NamedTuple):
    """
    One update of a segmenter.

    Parameters
    ----------
    lit : (h, w) array
        DN of the frame.
    unlit : (h, w) array or None
        DN of what was subtracted from it; None if nothing was.
    background, noise : float
        Median and standard deviation of lit less unlit if there is no target, DN.
    region : Box
        The part of the frame that was searched.
    candidates : tuple of Candidate
        What lit up there, the highest first.
    windows : mapping of str to Box
        The window of each light, by its name; the name is empty if there is only one.
    state : str
        'locked' where the target is followed, 'lost' where the whole frame is searched.
    reason : str
        Why there is no window; empty if there is one.
    warnings : tuple of str
        What is wrong though there may be one.

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
    warnings: tuple[str, ...] = ()

"""What a segmenter saw in one frame: for pictures and diagnostics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    candidates : sequence of Candidate
        What lit up there, the highest first.
    windows : mapping of str to Box
        The window of each light, by its name; the name is empty if there is only one.
    state : str
        'locked' where the target is followed, 'lost' where the whole frame is searched.
    reason : str
        Why there is no window; empty if there is one.
    warnings : tuple of str
        What is wrong though there may be one.

    Examples
    --------
    What was seen in frames in which nothing lit up:

    >>> import numpy as np
    >>> from blob_tracker.segmentation import Segmenter
    >>> from blob_tracker.types import Frame
    >>> segmenter = Segmenter()
    >>> for index in range(3):
    ...     wall = np.random.default_rng(index).normal(40.0, 2.0, (48, 64)).astype(np.uint8)
    ...     _ = segmenter.update(Frame(wall, stamp_ns=16_666_667 * index, saturation=255))
    >>> seen = segmenter.detections
    >>> len(seen.candidates), seen.windows, seen.state
    (0, {}, 'lost')
    >>> round(seen.noise)  # DN
    3
    >>> seen.reason.split(';')[0]
    'nothing lit up: the strongest rise is 11 DN, 3.7 times the noise'

    """

    lit: Pixels
    unlit: Pixels | None
    background: float
    noise: float
    region: Box
    candidates: Sequence[Candidate]
    windows: Mapping[str, Box]
    state: str
    reason: str
    warnings: tuple[str, ...] = ()

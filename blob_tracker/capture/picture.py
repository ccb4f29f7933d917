"""A picture of a camera's frame and of how it is exposed, for people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from blob_tracker.colour import in_channel
from blob_tracker.drawing import (
    blank, CLIPPED, Colour, GAP_PX, in_grey, PAPER, paragraphs, Picture, stack, TEXT,
)
from blob_tracker.types import BAYER, Frame
import cv2
import numpy as np
from numpy.typing import NDArray

BAR: Colour = (170, 170, 170)

NARROWEST_PX, WIDEST_PX, HIGHEST_PX = 480, 960, 720  # px: small frames grow, large ones shrink
BINS = 256  # of the histogram
STRIP_PX = 72  # px of the histogram's height


def draw(frame: Frame, words: Sequence[str] = ()) -> Picture:
    """
    Draw a frame, black at 0 DN and white where it clips, with its histogram below.

    Clipped pixels are red, each of them also where the frame is drawn smaller than it is. The
    histogram goes from 0 to the level of a clipped pixel, with a logarithmic height, so that a
    small target is seen beside its large background.

    Parameters
    ----------
    frame : Frame
        Of any size and depth; the samples of a mosaic as they are, other colours as luma.
    words : sequence of str
        Lines of text to put below, such as rate and exposure.

    Returns
    -------
    (h, w, 3) uint8 array
        Blue, green and red; 496 to 976 px wide.

    """
    if frame.layout in BAYER:  # every sample as it is: a clipped one must be seen
        frame = replace(frame, layout='grey')
    frame = in_channel(frame, 'luma')
    height, width = frame.image.shape
    image = np.minimum(frame.image, frame.saturation)
    scale = min(WIDEST_PX / width, HIGHEST_PX / height)
    if scale >= 1.0:
        scale = float(min(-(-NARROWEST_PX // width), int(scale)))
    picture = in_grey(image, 0.0, frame.saturation, scale)
    clipped = frame.image >= frame.saturation
    count = int(np.count_nonzero(clipped))
    if count:
        # The mean over what becomes one pixel is above 0 where any of it is clipped.
        where = in_grey(clipped.astype(np.float32), 0.0, 1e-4, scale)
        picture[where[..., 0] > 0] = CLIPPED
    shown = blank(picture.shape[0], max(picture.shape[1], NARROWEST_PX))
    shown[:, :picture.shape[1]] = picture
    levels = np.asarray(
        cv2.calcHist([image], [0], None, [BINS], [0.0, frame.saturation + 1.0]).ravel(), np.float32
    )
    strip = _histogram(levels, shown.shape[1], bool(count))
    median, bright = (
        int(np.searchsorted(np.cumsum(levels), part * levels.sum()))
        * (frame.saturation + 1.0) / BINS
        for part in (0.5, 0.999)
    )
    lines = [
        (f'{count} of {frame.image.size} pixels are clipped at {frame.saturation} DN',
         CLIPPED if count else TEXT),
        (f'median {median:.0f} DN; one in a thousand lies above {bright:.0f} DN', TEXT),
        *((line, TEXT) for line in words),
    ]
    parts = [shown, strip, paragraphs(lines, shown.shape[1])]
    return np.pad(
        stack(parts), [(GAP_PX, 0), (GAP_PX, GAP_PX), (0, 0)], constant_values=PAPER[0]
    )


def _histogram(levels: NDArray[np.float32], width: int, clips: bool) -> Picture:
    """Return the bars of a histogram, the last one red where pixels are clipped."""
    strip = blank(STRIP_PX, width)
    heights = np.log1p(levels) / max(float(np.log1p(levels.max())), 1e-9) * STRIP_PX
    edges = np.linspace(0, width, BINS + 1).round().astype(int)
    for index, height in enumerate(heights.round().astype(int)):
        colour = CLIPPED if clips and index == BINS - 1 else BAR
        strip[STRIP_PX - height:, edges[index]:edges[index + 1]] = colour
    return strip

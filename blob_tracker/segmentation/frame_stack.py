"""The frames of several looks at a still target, summed into one window."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.compression import compression_noise
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.dead_pixels import cut_out
from blob_tracker.segmentation.history import FrameError
from blob_tracker.types import Frame, Glimpse, Pixels, Window
import numpy as np

FULL_SCALE_DN = 65535  # DN: clipped, in a sum of looks
MAX_PAUSE_S = 1.0  # s without a look, beyond two flashes of the light: it was out of view
# Sigma, and as many px: what moved further since the first look does not stand still
STILL_SIGMA = 0.5


class _Pair(NamedTuple):
    """One look: where the target was, and the frames with and without it."""

    x: float
    y: float
    frame: Frame
    lit: tuple[Pixels, ...]
    unlit: tuple[Pixels, ...]
    noise: float
    tau_ns: int


class FrameStack:
    """
    Sum k windows of a still target into one (thesis, section 5.4: five).

    The looks follow each other without overlap; a target that moves begins them anew, and so does
    one that was out of view for more than 1 s (beyond the time of two codes or blocks, where the
    flash has such). The window is that of the last look, for all of them. Its stamp is their mean.

    Parameters
    ----------
    count : int
        k; 1 gives each window as it comes.

    Attributes
    ----------
    reason : str
        What is waited for.

    Raises
    ------
    ValueError
        If k is not 1 or more.

    """

    def __init__(self, count: int) -> None:
        if count < 1:
            raise ValueError(f'{count} looks; there must be 1 or more')
        self.count = count
        self.reason = ''
        self._pairs: dict[str, list[_Pair]] = {}

    def add(
        self, name: str, contrast: Contrast, candidate: Candidate, box: Box
    ) -> Window | None:
        """
        Take the next look at a light; return the window that is complete with it, or None.

        Parameters
        ----------
        name : str
            Which light it is.
        contrast : Contrast
            The raw frames of the look.
        candidate : Candidate
            The light.
        box : Box
            Its window in them.

        Raises
        ------
        FrameError
            If the sum does not fit into 16 bits.

        """
        frame, lit = contrast.frame, contrast.lit_frames
        saturation = frame.sample_saturation
        frames = self.count * len(lit)
        if frames > 1 and frames > most_frames(saturation):
            raise FrameError(
                f'{frames} frames of up to {saturation} DN do not fit into the 16 bits of a '
                f"window, {most_frames(saturation)} would; sum fewer looks, or set the camera's "
                'true full scale (saturation)'
            )
        look = _Pair(
            candidate.x, candidate.y, frame, lit,
            contrast.unlit_frames if candidate.unlit is None else (candidate.unlit,),
            candidate.noise, round(1e9 * candidate.tau),
        )
        if self.count == 1:
            return _cut([look], box, candidate)
        pairs = self._pairs.pop(name, [])
        if pairs and not _goes_on(pairs, look, candidate.sigma_minor, contrast.duration):
            pairs = []
        pairs.append(look)
        if len(pairs) < self.count:
            self._pairs[name] = pairs
            self.reason = f'look {len(pairs)} of the {self.count} that are summed'
            return None
        return _cut(pairs, box, candidate)


def _goes_on(pairs: Sequence[_Pair], look: _Pair, sigma: float, duration: float) -> bool:
    """Tell whether a look is at a target that has stood still since the first of the others."""
    first, last = pairs[0], pairs[-1]
    longest_ns = 1e9 * (MAX_PAUSE_S + 2.0 * duration)
    return (
        0 <= look.frame.stamp_ns - last.frame.stamp_ns <= longest_ns
        and math.hypot(look.x - first.x, look.y - first.y) <= STILL_SIGMA * (1.0 + sigma)
        and look.lit[0].shape == first.lit[0].shape
        and look.lit[0].dtype == first.lit[0].dtype
    )


def _cut(pairs: Sequence[_Pair], box: Box, candidate: Candidate) -> Window:
    """Return the raw pixels of a box, summed over all frames of the looks."""
    frame = pairs[-1].frame
    (across, down), line_ns, mosaic = frame.binning, frame.line_time_ns, frame.mosaic
    first_ns = begun_ns = pairs[0].frame.stamp_ns
    left, top, right, bottom = box
    x0, y0 = frame.x0 + across * left, frame.y0 + down * top
    added_noise = 0.0 if frame.quantisation is None else compression_noise(
        frame.quantisation, candidate, frame.raw_steps
    )
    sites = None
    if mosaic is not None:
        across, down = across // 2, down // 2
        sites = np.tile(mosaic.sites, (bottom - top, right - left))
        left, top, right, bottom = 2 * left, 2 * top, 2 * right, 2 * bottom
        line_ns /= 2
        first_ns -= round(line_ns / 2)  # from the middle of a cell to its first line
    lit: list[Pixels] = []
    unlit: list[Pixels] = []
    seen_ns = 0
    for pair in pairs:
        for image, dark in zip(pair.lit, pair.unlit):
            above, below = cut_out(
                image, dark, left, top, right, bottom, frame.saturation, pair.noise
            )
            lit.append(above)
            unlit.append(below)
        for image in pair.lit[len(pair.unlit):]:
            lit.append(image[top:bottom, left:right].copy())
        seen_ns += pair.frame.stamp_ns - begun_ns + pair.tau_ns
    stamp_ns = first_ns + seen_ns // len(pairs)
    if line_ns:
        stamp_ns += round(line_ns * (0.5 * (top + bottom - 1)))  # of the middle line
    looks, saturation, has_unlit = len(lit), frame.sample_saturation, len(unlit) == len(lit)
    # No message says where linear pixels clip, and a locator without the response would not know.
    if looks > 1 or frame.raw_steps is not None:
        whole_lit = sum_frames(lit, saturation)
        whole_unlit = sum_frames(unlit, saturation) if has_unlit else None
        saturation = FULL_SCALE_DN
    else:
        whole_lit, whole_unlit = lit[0], unlit[0] if has_unlit else None
    glimpse = candidate.glimpse
    if glimpse is not None:
        glimpse = _on_sensor(glimpse, frame) if len(pairs) == 1 else None
    # By their places: names take a microsecond.
    return Window(
        whole_lit, whole_unlit, x0, y0, stamp_ns, saturation, (across, down), looks, sites,
        added_noise, glimpse, line_ns,
    )


def cut_at_once(
    frame: Frame, box: tuple[int, int, int, int], lit: Pixels, unlit: Pixels,
    glimpse: Glimpse | None,
) -> Window:
    """
    Return the window of a frame that is neither a mosaic nor compressed, nor was made linear.

    Parameters
    ----------
    frame : Frame
        That shows the light.
    box : (int, int, int, int)
        Its window in it, see `Box`.
    lit, unlit : (h, w) arrays
        The pixels of that, see `cut_out`.
    glimpse : Glimpse or None
        How the light was seen, px of the frame as it is.

    """
    (across, down), line_ns, stamp_ns = frame.binning, frame.line_time_ns, frame.stamp_ns
    left, top, _, bottom = box
    if line_ns:
        stamp_ns += round(line_ns * (0.5 * (top + bottom - 1)))  # of the middle line
    return Window(
        lit, unlit, frame.x0 + across * left, frame.y0 + down * top, stamp_ns, frame.saturation,
        (across, down), 1, None, 0.0, None if glimpse is None else _on_sensor(glimpse, frame),
        line_ns,
    )


def _on_sensor(glimpse: Glimpse, frame: Frame) -> Glimpse:
    """Return how a light was seen in px of the full, unbinned sensor."""
    if frame.binning != (1, 1):
        scale = np.array(frame.binning, dtype=float)
        glimpse = Glimpse(
            glimpse.share, glimpse.way * scale, glimpse.way_sigma * float(scale.max()),
            glimpse.doubt * np.outer(scale, scale), glimpse.lag * scale,
            glimpse.drawn * frame.binning[1],
        )
    # As a message has it, so that one process and several place it alike.
    return Glimpse.of_numbers(glimpse.numbers)


def most_frames(saturation: int) -> int:
    """Return how many frames of this full scale (DN) can be summed in 16 bits; 1 or more."""
    return max((FULL_SCALE_DN - 1) // max(saturation - 1, 1), 1)


def sum_frames(images: Sequence[Pixels], saturation: int) -> Pixels:
    """
    Return the sum of n frames, pixel by pixel.

    A sum, not a mean: it keeps the electrons per DN, so that the shot noise m / gain of a pixel
    stays true, and rounds nothing away. The read noise grows by sqrt(n). The thesis averages 5
    looks (section 5.4).

    Parameters
    ----------
    images : sequence of (h, w) arrays
        DN, of one type.
    saturation : int
        The DN at which a pixel of one frame is clipped.

    Returns
    -------
    (h, w) uint16 array
        DN; 65535 where a pixel is clipped in any of them.

    """
    total = np.zeros(images[0].shape, dtype=np.uint16)
    clipped = np.zeros(images[0].shape, dtype=bool)
    for image in images:
        total += image
        clipped |= image >= saturation
    total[clipped] = FULL_SCALE_DN
    return total

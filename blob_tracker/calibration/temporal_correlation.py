"""Whether the noise of frames that follow each other is new in each of them."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from math import inf, pi, sqrt

from blob_tracker.calibration.frame_pair import LEAST_VARIANCE_DN2
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

TILE = 16  # px, height and width: 256 triples tell a correlation to 0.1
LARGEST = 768  # px of the sides of what is looked at, in the middle: 2,304 tiles
FEWEST_TILES = 12  # fewer have no median to trust
MOST_TRIPLES = 48  # of frames: their tiles tell 0.001, and more take time
CLIPPED = 0.5  # of the pixels at the highest value: such frames are alike without a fault
SAME_LIGHT = 0.02  # of the mean, and 1 DN, that frames of one light may differ by
CORRELATED = 0.04  # takes 4 % off the variance of a difference, and 8 % off the noise itself
SIGNIFICANT_SIGMA = 5.0

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TemporalCorrelation:
    """
    Correlation of a pixel's noise with that in the next frame.

    Parameters
    ----------
    value, sigma : float
        The correlation, exact for a recursion, and its standard deviation.
    repeated : int
        Frames that are the one before them, bit for bit, where others differ.
    triples : int
        Of frames in a row that it was told from.

    """

    value: float
    sigma: float
    repeated: int
    triples: int

    @property
    def fault(self) -> str:
        """Return what is wrong and what to do; empty if each frame has noise of its own."""
        if self.repeated:
            return (
                f'{self.repeated} frames are the one before them bit for bit: the driver or the '
                'recording repeats frames, and the difference of two shows no noise. Set the '
                "camera's own frame rate, or record without a change of rate"
            )
        if abs(self.value) > max(CORRELATED, SIGNIFICANT_SIGMA * self.sigma):
            return (
                f'the frames hang together in time (correlation {self.value:.2f} +- '
                f'{self.sigma:.2g} from one to the next): their differences show too little '
                "noise, and a moving light is drawn towards where it was. Switch the camera's "
                'temporal noise reduction (3D noise reduction, DNR) off and record again'
            )
        return ''


class Succession:
    """
    Look at frames in the order in which they were taken.

    A recursion out_k = a out_(k-1) + (1 - a) in_k, as temporal noise reduction is, leaves a
    pixel's noise with the correlation a from one frame to the next. Of three frames the two
    differences d1 and d2 have the correlation

        r = -(1 - a) / 2,    so that a = 1 + 2 r;

    -1/2 is that of noise that is new in each frame. In tiles of 16 x 16 px the differences are
    freed from what the light (a constant, and a part of the picture) and a motion of less than a
    pixel (its derivatives) changed, so that neither a lamp that drifts nor what the pixels differ
    by is taken for noise. The correlation is the median of all tiles, which a few in which things
    move do not shift; its standard deviation is from their scatter.
    """

    def __init__(self) -> None:
        self._light: Hashable = None
        self._held: list[Pixels] = []
        self._tiles: list[Array] = []
        self._triples = 0
        self._repeats: list[float] = []  # means of frames that are alike bit for bit, DN
        self._darkest = inf  # mean of frames that differ, DN

    def add(self, image: Pixels, light: Hashable = None) -> None:
        """
        Take the next frame.

        Parameters
        ----------
        image : (h, w) uint8 or uint16 array
            DN.
        light : hashable
            What tells its light from others'; where it or the mean changes a succession ends.

        """
        held = self._held
        if held and (light != self._light or not _alike(held[0], image)):
            held.clear()
        self._light = light
        if held and np.array_equal(held[-1], image):
            if float((image == image.max()).mean()) < CLIPPED:
                self._repeats.append(float(image.mean()))
            held.clear()
        elif held:
            self._darkest = min(self._darkest, float(image.mean()))
        held.append(image)
        if len(held) < 3:
            return
        if self._triples < MOST_TRIPLES:
            self._triples += 1
            self._tiles.append(_correlations(*held))
        held.clear()

    def found(self) -> TemporalCorrelation | None:
        """Return what the frames tell; None if too few follow each other at one light."""
        # In less light than others need to differ, rounding may hide the noise.
        repeated = sum(mean >= self._darkest - 1.0 for mean in self._repeats)
        values = np.concatenate(self._tiles) if self._tiles else np.empty(0)
        if values.size < FEWEST_TILES:
            return TemporalCorrelation(0.0, 1.0, repeated, 0) if repeated else None
        middle = float(np.median(values))
        spread = 1.4826 * float(np.median(np.abs(values - middle)))
        return TemporalCorrelation(
            middle, spread * sqrt(0.5 * pi / values.size), repeated, self._triples
        )


def _alike(first: Pixels, second: Pixels) -> bool:
    """Tell whether two frames may be of one light and camera."""
    if first.shape != second.shape or first.dtype != second.dtype:
        return False
    mean = float(first.mean())
    return abs(float(second.mean()) - mean) <= SAME_LIGHT * mean + 1.0


def _middle(image: Pixels) -> Pixels:
    """Return the middle of a frame; the whole of a large one takes a second and tells no more."""
    top, left = (max(side - LARGEST, 0) // 2 for side in image.shape)
    return image[top:top + LARGEST, left:left + LARGEST]


def _tiled(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the (n, 256) pixels of the n whole tiles of a picture."""
    down, across = (side // TILE for side in picture.shape)
    whole = picture[:down * TILE, :across * TILE].reshape(down, TILE, across, TILE)
    return whole.swapaxes(1, 2).reshape(down * across, TILE * TILE)


def _correlations(first: Pixels, second: Pixels, third: Pixels) -> Array:
    """Return a = 1 + 2 r for each tile of three frames in which the noise shows."""
    a, b, c = (_middle(each).astype(np.float32) for each in (first, second, third))
    mean = (a + b + c) / 3.0
    if min(mean.shape) < TILE:
        return np.empty(0)
    picture = _tiled(mean)
    picture -= picture.mean(axis=1, keepdims=True)
    along_y, along_x = np.gradient(mean)
    design = np.stack([np.ones_like(picture), picture, _tiled(along_x), _tiled(along_y)], axis=2)
    differences = np.stack([_tiled(b - a), _tiled(c - b)], axis=2)
    gram = (design.swapaxes(1, 2) @ design).astype(np.float64)
    # Solvable where a tile is all of one value.
    gram[:, range(4), range(4)] += 1e-6 + 1e-7 * gram[:, range(4), range(4)]
    found = np.linalg.solve(gram, (design.swapaxes(1, 2) @ differences).astype(np.float64))
    rest = differences - design @ found.astype(np.float32)
    squares = (rest**2).sum(axis=1, dtype=np.float64)
    both = (rest[:, :, 0] * rest[:, :, 1]).sum(axis=1, dtype=np.float64)
    # Half the square of a difference is the variance of a frame.
    shows = squares.min(axis=1) > 2.0 * LEAST_VARIANCE_DN2 * TILE**2
    return np.asarray(1.0 + 2.0 * both[shows] / np.sqrt(squares[shows].prod(axis=1)))

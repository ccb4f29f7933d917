"""Noise level function: variance over level from pairs of frames of an ordinary scene."""

from __future__ import annotations

from math import exp, sqrt
from typing import NamedTuple

from blob_tracker.calibration.frame_pair import LEAST_SPREAD_DN2, LEAST_VARIANCE_DN2
from blob_tracker.calibration.noise_line import fit_noise_line, NoiseLine, QUANTISATION
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

HEIGHT, WIDTH = 16, 32  # px of a tile: 512 differences tell its variance to 6 %
REACH = 2  # px beyond the tile that the derivative needs
BINS = 64  # of level, evenly in its square root: the variance changes little within one
UNKNOWNS = 4  # that the light and the motion take out of a tile
WHITE = 4.0  # standard deviations that a neighbour correlation may have by chance
TAILS = 5.0  # and a kurtosis
VARIANCE_SIGMA = 5.0  # and a tile's variance, from the line of its pair
POOLED = 3.5  # and the neighbour correlation of all tiles together
FARTHEST = 0.25  # px that a tile may move: first order is enough, and flat tiles seem to by chance
TAPS = 65.0 / 72.0  # sum of the squared weights of the derivative
UNSEEN = 0.002  # of the variance, that motion may add to a tile without being seen
MISSED = 0.3  # of what two orders more change in a derivative, at the finest that a lens shows
CLEAR = 2.5  # standard deviations that the extremes of a tile keep from 0 DN and saturation
GROUPS = 6  # of level, whose medians show which tiles of a pair stand out
FEWEST = 2 * GROUPS  # tiles of a pair: fewer are no majority to trust
FEWEST_LEVELS = 5  # bins, of which a curve is told
WIDE = 0.15  # of saturation, over which they must reach
FALLS = 0.1  # of the variance, by which it may fall towards the bright end
BENT = 0.5  # of the mean slope, by which it may change from the dark end to the bright one
CERTAIN = 5.0  # standard deviations of either
LEAST_DOF = 10_000  # differences in all: 20 tiles, before a word is said

Array = NDArray[np.float64]


class Tiles(NamedTuple):
    """
    The n tiles of a pair, (n,) arrays.

    Parameters
    ----------
    level : array
        DN.
    variance : array
        Temporal, DN^2, without what light and motion changed.
    kurtosis : array
        Of the difference.
    spread : array
        Variance of the mean of the pair over the tile, DN^2.

    """

    level: Array
    variance: Array
    kurtosis: Array
    spread: Array


class NoiseLevelFunction:
    """
    Gather pairs of frames of one scene, and fit the noise line to them.

    Each difference d of two frames is seen in tiles. In each tile

        d = c0 + c1 s + cx ds/dx + cy ds/dy + noise,    s the mean of the two frames,

    is fitted: c0 and c1 are what the light changed (mains flicker, a cloud), cx and cy the motion
    in px between the two. For noise of one variance in both frames s and d are independent, so
    that the fit takes four degrees of freedom off and nothing else. About s, the middle of the
    motion, what is left is of the third order in it.

    A tile is left out where what remains is not white (neighbours correlated), has heavy tails,
    or stands beside the line that the medians of all tiles make; where the motion times the
    detail leaves more than 0.2 % to the third order; and where pixels come near 0 DN or
    saturation. A pair is left out where the neighbours of all tiles together are correlated.
    What is left is summed by level with the weight exp(-age / memory).

    The idea to read the noise off the frames of a scene is that of the noise level function (Liu
    et al., CVPR 2006); from differences in time it needs no model of the scene.

    Parameters
    ----------
    memory : float
        Time after which a pair weighs 1/e, s by the stamps; infinite forgets nothing.
    tiles : int or None
        How many tiles of a pair are looked at, spread over the levels; None for all.

    Attributes
    ----------
    reason : str
        Why there is no line; empty if there is one.
    curved : str
        How the variance bends over the level as that of no linear sensor does, and what to do;
        empty if it does not, or nobody knows.

    """

    def __init__(self, *, memory: float = 60.0, tiles: int | None = 96) -> None:
        self.memory = memory
        self.tiles = tiles
        self.reason = 'no pair of unlit frames yet'
        self.curved = ''
        self._last_ns: int | None = None
        self._dtype: object = None
        self._saturation = 0
        self._turn = 0
        self._forget()

    def _forget(self) -> None:
        # Columns: dof, dof of squared weights, and dof times level, its square, variance,
        # kurtosis and spread.
        self._sums = np.zeros((BINS, 7))

    def add(self, first: Pixels, second: Pixels, saturation: int, stamp_ns: int) -> int:
        """
        Take a pair of frames with the same light.

        Parameters
        ----------
        first, second : (h, w) uint8 or uint16 arrays
            DN. Neither may be in another pair.
        saturation : int
            DN of a clipped pixel. Another than the last pair's sorts what there is anew.
        stamp_ns : int
            Of the second, ns. One before the last pair's begins afresh.

        Returns
        -------
        int
            Tiles that were taken.

        Raises
        ------
        ValueError
            If the two differ in size or type, or are smaller than a tile.

        """
        if first.shape != second.shape or first.dtype != second.dtype:
            raise ValueError(
                f'a pair is {first.shape} {first.dtype} and {second.shape} {second.dtype}; both '
                'must be alike'
            )
        if self._last_ns is not None:
            if stamp_ns < self._last_ns or first.dtype != self._dtype:
                self._forget()
            else:
                if saturation != self._saturation:
                    self._sort(saturation)
                fade = exp(-(stamp_ns - self._last_ns) / 1e9 / self.memory)
                self._sums *= fade
                self._sums[:, 1] *= fade
        self._last_ns, self._dtype, self._saturation = stamp_ns, first.dtype, saturation
        self._turn += 1
        found = tiles_of(*_sampled(first, second, self.tiles, self._turn), saturation)
        if found.level.size < FEWEST:
            return 0
        dof = HEIGHT * WIDTH - UNKNOWNS
        one = np.ones_like(found.level)
        rows = dof * np.stack([
            one, one, found.level, found.level**2, found.variance, found.kurtosis, found.spread
        ], axis=1)
        np.add.at(self._sums, _bins(found.level, saturation), rows)
        return int(found.level.size)

    def _sort(self, saturation: int) -> None:
        """Put the sums into the bins of another saturation."""
        sums = self._sums[self._sums[:, 0] > 0.0]
        self._forget()
        np.add.at(self._sums, _bins(sums[:, 2] / sums[:, 0], saturation), sums)

    def points(self) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
        """
        Return level, variance, its scatter, and whether the noise shows, of each bin with any.

        Level in DN, variance in DN^2, the scatter as in `fit_noise_line`. Where rounding hides the
        noise, as in `photon_transfer`, the bin has no part in the line.
        """
        sums = self._sums[self._sums[:, 0] > 0.0]
        weight = sums[:, 0]
        level, square, variance, kurtosis, spread = (sums[:, 2:] / weight[:, None]).T
        spread = spread + square - level**2
        shows = (variance > LEAST_VARIANCE_DN2) & (
            variance - QUANTISATION + spread > LEAST_SPREAD_DN2
        )
        return level, variance, (kurtosis - 1.0) * sums[:, 1] / weight**2, shows

    def line(self) -> NoiseLine | None:
        """Return the noise line, or None if the scene does not tell it; `reason` says why."""
        weights = self._sums[:, 0]
        if not weights.any() or weights.sum() ** 2 / self._sums[:, 1].sum() < LEAST_DOF:
            self.reason = 'no pair of unlit frames yet' if self._last_ns is None else (
                'too little plain noise between the unlit frames: the scene moves, is too dark or '
                'clipped, or the frames were compressed or cleared of noise'
            )
            return None
        level, variance, scatter, shows = self.points()
        if not shows.any():
            self.reason = (
                f'the noise, {variance.min():.2f} DN^2 and more, hides in the rounding; a higher '
                'gain of the camera shows it'
            )
            return None
        level, variance, scatter = level[shows], variance[shows], scatter[shows]
        self.curved = _curved(level, variance, scatter, self._saturation)
        if self.curved:
            self.reason = self.curved
            return None
        if np.ptp(level) > 0.0:
            found = fit_noise_line(level, variance, scatter)
            if found.separates:
                self.reason = ''
                return found
        precision = 1.0 / (scatter * variance**2)
        at = np.average(level, weights=precision)
        height = np.average(variance, weights=precision)
        self.reason = (
            'not enough contrast in the scene to separate gain and read noise; the variance at '
            f'{at:.0f} DN is {height:.2f} +- {1.0 / sqrt(precision.sum()):.2f} DN^2'
        )
        return None


def _curved(level: Array, variance: Array, scatter: Array, saturation: int) -> str:
    """Say how a variance bends over the level; '' where that of a linear sensor may be so."""
    if level.size < FEWEST_LEVELS or np.ptp(level) < WIDE * saturation:
        return ''
    x = (level - level[0]) / np.ptp(level)
    design = np.stack([np.ones_like(x), x, x**2], axis=1)
    # A point that is low by chance must not weigh more: the weights are those of the mean.
    weights = 1.0 / (scatter * np.average(variance, weights=1.0 / scatter) ** 2)
    covariance = np.linalg.pinv(design.T @ (weights[:, None] * design))
    foot, slope, bend = covariance @ design.T @ (weights * variance)
    change, change_row = slope + bend, np.array([0.0, 1.0, 1.0])
    falls = -change > max(FALLS * foot, CERTAIN * sqrt(change_row @ covariance @ change_row))
    bends = abs(bend) > max(BENT * abs(change), CERTAIN * sqrt(covariance[2, 2]))
    if not (falls or bends):
        return ''
    return (
        f'the variance of the pixels {"falls" if falls else "bends"} over the level, '
        f'{foot:.2f} DN^2 at {level[0]:.0f} DN, {foot + 0.5 * slope + 0.25 * bend:.2f} at '
        f'{0.5 * (level[0] + level[-1]):.0f} and {foot + change:.2f} at {level[-1]:.0f}, as that '
        'of no linear sensor does: the camera applies a gamma curve, or takes out noise. Set its '
        'gamma control to linear (100 of most webcams: v4l2-ctl --list-ctrls), or measure the '
        'curve (python3 -m blob_tracker calibrate response) and set response_url'
    )


def _bins(levels: Array, saturation: int) -> NDArray[np.int64]:
    """Return the bin of each level."""
    bins = np.sqrt(np.clip(levels / saturation, 0.0, 1.0)) * BINS
    return np.minimum(bins.astype(np.int64), BINS - 1)


def _sampled(
    first: Pixels, second: Pixels, count: int | None, turn: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return (n, h, w) tiles of both frames with their margin, of all levels there are."""
    height, width = HEIGHT + 2 * REACH, WIDTH + 2 * REACH
    # Another grid each time: what lies on the border of two tiles is seen as well.
    top = (7 * turn) % max(min(height, first.shape[0] - height + 1), 1)
    left = (11 * turn) % max(min(width, first.shape[1] - width + 1), 1)
    down, across = (first.shape[0] - top) // height, (first.shape[1] - left) // width
    if down < 1 or across < 1:
        raise ValueError(
            f'the frames are {first.shape[1]} x {first.shape[0]} px; {width} x {height} px is '
            'the least'
        )
    a, b = (
        each[top:top + down * height, left:left + across * width]
        .reshape(down, height, across, width).swapaxes(1, 2)
        for each in (first, second)
    )
    if count is None or count >= down * across:
        rows, columns = np.divmod(np.arange(down * across), across)
    else:
        coarse = a[:, :, 2::8, 2::8].mean(axis=(2, 3)).ravel()
        order = np.argsort(coarse, kind='stable')
        # One half evenly over the tiles, the other evenly over the levels: a lamp on few tiles
        # tells more of the gain than all of a wall.
        even = order[np.linspace(0, order.size - 1, count // 2).astype(int)]
        steps = np.linspace(coarse[order[0]], coarse[order[-1]], count - even.size)
        apart = order[np.minimum(np.searchsorted(coarse[order], steps), order.size - 1)]
        rows, columns = np.divmod(np.unique(np.concatenate([even, apart])), across)
    return a[rows, columns].astype(np.float32), b[rows, columns].astype(np.float32)


def tiles_of(
    first: NDArray[np.float32], second: NDArray[np.float32], saturation: int
) -> Tiles:
    """
    Return level and temporal variance of those tiles of a pair that show noise alone.

    Parameters
    ----------
    first, second : (n, 20, 36) arrays
        The tiles in both frames, with 2 px around them, DN.
    saturation : int
        DN of a clipped pixel.

    """
    inner = slice(REACH, -REACH)
    shape = (first.shape[0], HEIGHT * WIDTH)
    whole = 0.5 * (first + second)
    mean = whole[:, inner, inner].reshape(shape)
    level = mean.mean(axis=1, dtype=np.float64)
    centred = mean - level[:, None].astype(np.float32)
    difference = (first - second)[:, inner, inner].reshape(shape)
    along_x, along_y = (each.reshape(shape) for each in _gradient(whole))
    design = np.stack([np.ones_like(mean), centred, along_x, along_y], axis=1)
    gram = (design @ design.swapaxes(1, 2)).astype(np.float64)
    # Solvable where a tile is all of one value.
    gram[:, range(UNKNOWNS), range(UNKNOWNS)] *= 1.0 + 1e-7
    gram[:, range(UNKNOWNS), range(UNKNOWNS)] += 1e-6
    inverse = np.linalg.inv(gram)
    right = (design @ difference[:, :, None]).astype(np.float64)
    found = (inverse @ right)[:, :, 0]
    rest = difference - (found[:, None, :].astype(np.float32) @ design)[:, 0]
    rest_squared = rest * rest
    squares = np.maximum(rest_squared.sum(axis=1, dtype=np.float64), 1e-12)
    dof = shape[1] - UNKNOWNS
    variance = 0.5 * squares / dof
    kurtosis = np.einsum('ij,ij->i', rest_squared, rest_squared) * shape[1] / squares**2

    picture = rest.reshape(-1, HEIGHT, WIDTH)
    right_of = np.einsum('ijk,ijk->i', picture[:, :, 1:], picture[:, :, :-1]) / squares
    below = np.einsum('ijk,ijk->i', picture[:, 1:], picture[:, :-1]) / squares
    chance = 1.0 / sqrt(dof)
    good = (np.abs(right_of) < WHITE * chance) & (np.abs(below) < WHITE * chance)
    good &= np.abs(kurtosis - 3.0) < TAILS * sqrt(24.0 / dof)
    margin = CLEAR * np.sqrt(variance)
    good &= (mean.min(axis=1) > margin) & (mean.max(axis=1) < saturation - margin)
    motions = found[:, 2:]
    good &= _beyond_first_order(motions, whole, along_x, along_y) < UNSEEN * 2.0 * variance
    good &= (motions**2).sum(axis=1) < FARTHEST**2
    # The derivatives have noise of their own, which the motion brings into the difference.
    by_chance = 2.0 * variance[:, None] * inverse[:, (2, 3), (2, 3)]
    variance *= 1.0 - 0.25 * TAPS * (motions**2 - by_chance).sum(axis=1)
    good[good] = _on_one_line(level[good], variance[good], dof)
    for each in (right_of, below):
        # Together the tiles show what none of them does: this pair is not of one scene.
        if good.any() and abs(each[good].mean()) > POOLED * chance / sqrt(good.sum()):
            good[:] = False
    spread = gram[:, 1, 1] / shape[1]
    return Tiles(level[good], variance[good], kurtosis[good], spread[good])


def _gradient(
    tiles: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the derivatives along x and y inside the margin, right to the fourth order."""
    inner = slice(REACH, -REACH)
    x, y = tiles[:, inner], tiles[:, :, inner]
    along_x = (8.0 * (x[:, :, 3:-1] - x[:, :, 1:-3]) - (x[:, :, 4:] - x[:, :, :-4])) / 12.0
    along_y = (8.0 * (y[:, 3:-1] - y[:, 1:-3]) - (y[:, 4:] - y[:, :-4])) / 12.0
    return np.asarray(along_x, np.float32), np.asarray(along_y, np.float32)


def _beyond_first_order(
    motions: Array,
    tiles: NDArray[np.float32],
    along_x: NDArray[np.float32],
    along_y: NDArray[np.float32],
) -> Array:
    """
    Return the variance that a motion (cx, cy) leaves in the difference, DN^2.

    About the middle of a motion c of detail s it is c^3 s_xxx / 12, and c s_xxx / 6 times what the
    derivative misses of the finest detail; s_xxx / 6 is what a derivative of the second order
    differs by from ours.
    """
    inner = slice(REACH, -REACH)
    rough_x = 0.5 * (tiles[:, inner, 3:-1] - tiles[:, inner, 1:-3])
    rough_y = 0.5 * (tiles[:, 3:-1, inner] - tiles[:, 1:-3, inner])
    left = np.zeros(tiles.shape[0])
    for motion, ours, rough in zip(motions.T, (along_x, along_y), (rough_x, rough_y)):
        apart = ours - rough.reshape(ours.shape)
        detail = np.einsum('ij,ij->i', apart, apart) / apart.shape[1]
        left += motion**2 * (0.25 * motion**4 + MISSED**2) * detail
    return left


def _on_one_line(levels: Array, variances: Array, dof: int) -> NDArray[np.bool_]:
    """Tell which tiles lie on the line through the medians of their groups."""
    if levels.size < FEWEST:
        return np.ones(levels.size, dtype=bool)
    groups = np.array_split(np.argsort(levels, kind='stable'), GROUPS)
    x = np.array([np.median(levels[each]) for each in groups])
    y = np.array([np.median(variances[each]) for each in groups])
    expected = np.full_like(levels, np.median(variances))
    if np.ptp(x) > 0.0:
        slope, foot = np.polyfit(x, y, 1, w=1.0 / np.maximum(y, 1e-6))
        expected = np.maximum(foot + slope * levels, 1e-6)
    # The medians have a scatter of their own.
    loose = sqrt(2.0) + sqrt(np.pi / min(each.size for each in groups))
    return np.asarray(np.abs(variances / expected - 1.0) < VARIANCE_SIGMA * loose / sqrt(dof))

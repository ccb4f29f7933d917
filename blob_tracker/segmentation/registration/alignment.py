"""The motion that lays the pixels of one frame on those of another, far below a pixel."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import kernel
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POINTS = 12_000  # at most; at a texture of 8 times the noise they place the frame to 0.005 px
LEAST_POINTS = 100  # sixteen for each number of an affine map
PYRAMID_RATIO = 4  # from one level to the next
# px of the smaller side, at most: 8 px are then a fraction of a pixel, or two
COARSEST_SIDE_PX = 160
NEIGHBOURHOOD_PX = 15  # px of the coarsest level, over which contrast is made equal
MAX_STEPS = 12  # a level takes 3 to 5 of them
CONVERGED_PX = 0.01  # px of a level: each step is at most a third of the one before
START_ERROR_PX = 0.5  # px of a level, by which its start is off
MAX_STEP_GAIN = 3.0  # times, by which a step brings it nearer at most
NEAR_PX = 0.25  # px of a level: after a shorter step the slopes of the two frames are alike
# px of a level, by which a slope is off for other reasons than the motion
LEAST_MOTION_ERROR_PX = 0.02
TUKEY_SIGMA = 4.685  # standard deviations: 95 % efficient for Gaussian residuals
SIGMA_PER_MAD = 1.4826  # standard deviations to a median absolute deviation
MAD_SAMPLES = 800  # residuals that tell their median absolute deviation to 4 %
LEAST_SIGMA_DN = 1e-2  # DN: least standard deviation, for pictures without noise

LEAST_CORRELATION = 0.5  # of what the two frames show in the same place
LARGEST_ERROR_PX = 0.1  # px, standard deviation of the map at the frame's corners
LARGEST_SHIFT = 0.25  # of the frame's smaller side: what is found beyond it is a false match
STILL_WITHIN_PX = 0.02  # px at the corners: such a motion is none, and nothing is interpolated
DOUBT_SIGMA = 3.0  # standard deviations of the map, within which a motion is none either


class _Points(NamedTuple):
    """
    Places in the unlit frame, and what they show.

    Parameters
    ----------
    places : (2, n) array
        x and y, px of the full frame.
    values : (n,) array
        The smoothed unlit frame there, DN.
    slopes : (k, n) array
        How the value at a place changes with each number of the motion.

    """

    places: Array
    values: Array
    slopes: Array


def align(lit: Pixels, unlit: Pixels, *, affine: bool) -> Array | None:
    """
    Return the (2, 3) map from places in the unlit frame to places in the lit one.

    A place x of the unlit frame is at x + u(x) in the lit one, where u is a constant or a linear
    function of x. Its k numbers p are those that make the robust sum

        sum_i rho((L(x_i + u(x_i; p)) - U(x_i) - b) / s)

    the least, in Gauss-Newton steps with the slopes J_U of the unlit frame (Lucas and Kanade,
    1981; Baker and Matthews, 2004). rho is Tukey's biweight and s the residuals' median absolute
    deviation, widened by slope times what the motion may still be off, so that the target and
    what moves by itself do not count, and edges do. U and L are the frames
    smoothed by the cubic B-spline: at any place between pixels the smoothing is the same (its
    images are below (w / (2 pi - w))^4, 1 % at half the Nyquist frequency), so that the result
    leans neither to whole pixels nor to half ones.

    Noise has slopes of its own, which sum J_U J_U^T takes for information. The last steps are
    therefore those of instrumental variables (Reiersol, 1945): with G = sum J_U J_L^T, in which
    the noise of the two frames has no part, the step is G^-1 times the score and its covariance
    G^-1 (sum J_U J_U^T) G^-T.

    It goes from coarse, where the start is the peak of the phase correlation (Kuglin and Hines,
    1975), to fine, and each level is weighted by its information with those before it: fine
    texture is placed by the last level, and coarse texture in noise by the first ones.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.
    affine : bool
        Whether u is linear in x, with six numbers, or constant, with two.

    Returns
    -------
    (2, 3) array or None
        px. It is the identity where no corner moved by more than 0.02 px, or than three of its
        standard deviations. None if the frames share fewer than 100 cells of 2 px, have too
        few slopes to place the corners to 0.1 px, correlate by less than 0.5 or are further
        apart than a quarter of their smaller side.

    """
    height, width = lit.shape
    middle = np.array([0.5 * (width - 1), 0.5 * (height - 1)])
    count = 6 if affine else 2
    motion, information = np.zeros(count), np.zeros((count, count))
    correlation = 0.0
    for factor in _levels(min(height, width)):
        before, after = _reduced(unlit, factor), _reduced(lit, factor)
        points = _points(before, factor, middle, count)
        if len(points.values) < LEAST_POINTS:
            return None
        if not information.any():
            motion[:2] = _start(before, after, factor, points)
        fitted = _fit(after, factor, points, middle, motion, information)
        if fitted is None:
            return None
        motion, information, correlation = fitted
    corners = _corners(affine)
    far = np.abs(corners @ motion).max()
    variance = np.einsum('ij,ij->i', corners, np.linalg.solve(information, corners.T).T)
    error = math.sqrt(max(variance.max(), 0.0))
    if not (
        correlation >= LEAST_CORRELATION
        and error <= LARGEST_ERROR_PX
        and far <= LARGEST_SHIFT * min(height, width)
    ):
        return None
    still = far < max(STILL_WITHIN_PX, DOUBT_SIGMA * error)
    return np.eye(2, 3) if still else _map(motion, middle)


def _levels(side: int) -> list[int]:
    """Return by what the frame is reduced, from coarse to fine."""
    factors = [1]
    while side > COARSEST_SIDE_PX * factors[0]:
        factors.insert(0, PYRAMID_RATIO * factors[0])
    return factors


def _reduced(image: Pixels, factor: int) -> NDArray[np.float32]:
    """
    Return the frame at every so many pixels, smoothed by a binomial of five before each halving.

    Its pixel (i, j) is the one at factor (i, j) of the frame (Burt and Adelson, 1983). Means of
    squares would be cheaper, and alias so much that small lights are found 0.3 px off.
    """
    import cv2  # no part of a start

    reduced = image.astype(np.float32)
    while factor > 1:
        reduced = np.asarray(cv2.pyrDown(reduced))
        factor //= 2
    return reduced


def _start(
    before: NDArray[np.float32], after: NDArray[np.float32], factor: int, points: _Points
) -> Array:
    """Return the shift that the coarsest level starts from, px of the full frame."""
    import cv2

    window = cv2.createHanningWindow(before.shape[::-1], cv2.CV_32F)
    shift, _ = cv2.phaseCorrelate(_equalised(before), _equalised(after), window)
    found, *unused = np.empty((3, len(points.values)))
    best, least = np.zeros(2), math.inf
    # Of smooth pictures the noise decides the phases; there no shift is the better start.
    for trial in (np.zeros(2), np.array(shift) * factor):
        there = np.column_stack([np.eye(2), trial]) / factor
        _sample(after, points.places, there, found, *unused)
        apart = np.abs(found - points.values)
        apart = apart[np.isfinite(apart)]
        if len(apart) >= LEAST_POINTS and _median(apart) < least:
            best, least = trial, _median(apart)
    return best


def _equalised(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """
    Return the frame less its local mean, with its local contrast made that of the others.

    What covers most of the picture then decides the phase correlation, and not what is brightest.
    """
    import cv2

    size = (NEIGHBOURHOOD_PX, NEIGHBOURHOOD_PX)
    rise = image - cv2.blur(image, size)
    contrast = np.sqrt(cv2.blur(rise * rise, size))
    return np.asarray(rise / np.maximum(contrast, np.median(contrast) + LEAST_SIGMA_DN))


def _points(
    image: NDArray[np.float32], factor: int, middle: Array, count: int
) -> _Points:
    """Return the steepest pixel of each cell of the unlit frame of a level."""
    height, width = image.shape
    cell = max(math.ceil(math.sqrt(height * width / POINTS)), 2)
    table = np.empty((5, (height // cell) * (width // cell)))
    table = table[:, : _steepest(image, cell, max(cell // 3, 1), table)]
    places = factor * table[:2]
    slopes = _slopes(places, table[3] / factor, table[4] / factor, middle, count)
    return _Points(places, table[2], slopes)


def _fit(
    image: NDArray[np.float32],
    factor: int,
    points: _Points,
    middle: Array,
    start: Array,
    known: Array,
) -> tuple[Array, Array, float] | None:
    """
    Return the motion on a level, the Fisher information on it and the frames' correlation.

    `start` is the motion that the levels before give, with the information `known`.
    """
    values, slopes = points.values, points.slopes
    steep = points.slopes[0] ** 2 + points.slopes[1] ** 2
    found, across, down = np.empty((3, len(values)))
    motion, off, moved = start, START_ERROR_PX * factor, math.inf
    for _ in range(MAX_STEPS):
        _sample(image, points.places, _map(motion, middle) / factor, found, across, down)
        seen = np.isfinite(found)
        shown = np.where(seen, found, values)
        residual = shown - values
        if np.count_nonzero(seen) < LEAST_POINTS:
            return None
        every = max(len(values) // MAD_SAMPLES, 1)
        some = residual[::every][seen[::every]]
        level = _median(some)
        deviation = SIGMA_PER_MAD * _median(np.abs(some - level)) + LEAST_SIGMA_DN
        variance = deviation**2 + off**2 * steep
        weight = np.square(residual - level) / (TUKEY_SIGMA**2 * variance)
        weight = np.square(np.maximum(1.0 - weight, 0.0)) * seen / variance
        total = weight.sum()
        # About their weighted means: the level of the frames is one more unknown.
        mean = slopes @ weight / total
        weighted = (slopes - mean[:, None]) * weight
        fisher = weighted @ slopes.T
        score = weighted @ residual
        try:
            if moved > NEAR_PX * factor:
                information = fisher + known
                move = np.linalg.solve(information, score + known @ (motion - start))
            else:
                across, down = across / factor, down / factor
                others = _slopes(points.places, across, down, middle, len(motion))
                shared = weighted @ others.T
                # Of the level alone, and weighed against the levels before.
                move = np.linalg.solve(shared, score)
                own = shared.T @ np.linalg.solve(fisher, shared)
                information = own + known
                move = np.linalg.solve(information, own @ move + known @ (motion - start))
        except np.linalg.LinAlgError:
            return None
        motion = motion - move
        near, moved = moved <= NEAR_PX * factor, float(np.abs(move).sum())
        if not moved < LARGEST_SHIFT * max(image.shape) * factor:
            return None
        off = max(moved, off / MAX_STEP_GAIN, LEAST_MOTION_ERROR_PX * factor)
        if near and moved < CONVERGED_PX * factor:
            break
    values = values - weight @ values / total
    shown = shown - weight @ shown / total
    power = (weight @ values**2) * (weight @ shown**2)
    return motion, information, float(weight @ (values * shown) / math.sqrt(power or 1.0))


def _slopes(places: Array, across: Array, down: Array, middle: Array, count: int) -> Array:
    """Return the (k, n) change of the values by the numbers of the motion, of those by x and y."""
    slopes = np.vstack([across, down])
    if count == 2:
        return slopes
    x, y = places / middle[:, None] - 1.0
    return np.vstack([slopes, slopes * x, slopes * y])


def _median(values: Array) -> float:
    """Return the upper median, in a tenth of the time of NumPy's; NaN of nothing."""
    half = len(values) // 2
    return float(np.partition(values, half)[half]) if len(values) else math.nan


def _map(motion: Array, middle: Array) -> Array:
    """Return the (2, 3) map of a motion: x + p01 + p23 X + p45 Y, X and Y 1 at the borders."""
    linear = motion[2:].reshape(-1, 2).T / middle if len(motion) > 2 else np.zeros((2, 2))
    return np.column_stack([np.eye(2) + linear, motion[:2] - linear @ middle])


def _corners(affine: bool) -> Array:
    """Return the (2 n, k) matrix from a motion's numbers to the shifts of the n corners."""
    if not affine:
        return np.eye(2)
    return np.vstack([
        np.hstack([np.eye(2), x * np.eye(2), y * np.eye(2)]) for x in (-1, 1) for y in (-1, 1)
    ])


@kernel
def _steepest(image: NDArray[np.float32], cell: int, every: int, out: Array) -> int:
    """
    Fill columns of x, y, value and slopes along x and y, one a cell; return their number.

    Value and slopes are those of the frame smoothed by the cubic B-spline. Of a cell every so
    many pixels are looked at. A cell without any slope gives none.
    """
    height, width = image.shape
    count = 0
    for top in range(1, height - cell, cell):
        for left in range(1, width - cell, cell):
            best, x, y = 0.0, 0, 0
            for j in range(top, top + cell, every):
                for i in range(left, left + cell, every):
                    right = image[j, i + 1] - image[j, i - 1]
                    down = image[j + 1, i] - image[j - 1, i]
                    steep = right * right + down * down
                    if steep > best:
                        best, x, y = steep, i, j
            if best == 0.0:
                continue
            row = image[y - 1, x - 1] + 4.0 * image[y - 1, x] + image[y - 1, x + 1]
            mid = image[y, x - 1] + 4.0 * image[y, x] + image[y, x + 1]
            end = image[y + 1, x - 1] + 4.0 * image[y + 1, x] + image[y + 1, x + 1]
            first = image[y - 1, x - 1] + 4.0 * image[y, x - 1] + image[y + 1, x - 1]
            last = image[y - 1, x + 1] + 4.0 * image[y, x + 1] + image[y + 1, x + 1]
            out[0, count] = x
            out[1, count] = y
            out[2, count] = (row + 4.0 * mid + end) / 36.0
            out[3, count] = (last - first) / 12.0
            out[4, count] = (end - row) / 12.0
            count += 1
    return count


@kernel
def _sample(
    image: NDArray[np.float32], places: Array, there: Array, out: Array, across: Array, down: Array
) -> None:
    """
    Fill value and slopes of the frame smoothed by the cubic B-spline.

    Beyond the borders the value is NaN and the slopes are 0.
    """
    height, width = image.shape
    for n in range(places.shape[1]):
        x = there[0, 0] * places[0, n] + there[0, 1] * places[1, n] + there[0, 2]
        y = there[1, 0] * places[0, n] + there[1, 1] * places[1, n] + there[1, 2]
        across[n], down[n] = 0.0, 0.0
        # Put so that NaN is outside too.
        if not (1.0 <= x < width - 2.0 and 1.0 <= y < height - 2.0):
            out[n] = math.nan
            continue
        i, j = int(x), int(y)
        t, u = x - i, y - j
        s, v = 1.0 - t, 1.0 - u
        a0, a3 = s * s * s / 6.0, t * t * t / 6.0
        a1 = 2.0 / 3.0 - 0.5 * t * t * (1.0 + s)
        a2 = 1.0 - a0 - a1 - a3
        d0, d1, d2, d3 = -0.5 * s * s, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t * t
        b0, b3 = v * v * v / 6.0, u * u * u / 6.0
        b1 = 2.0 / 3.0 - 0.5 * u * u * (1.0 + v)
        b2 = 1.0 - b0 - b1 - b3
        e0, e1, e2, e3 = -0.5 * v * v, u * (1.5 * u - 2.0), v * (2.0 - 1.5 * v), 0.5 * u * u
        value, along, below = 0.0, 0.0, 0.0
        for k, b, e in ((-1, b0, e0), (0, b1, e1), (1, b2, e2), (2, b3, e3)):
            p0, p1 = image[j + k, i - 1], image[j + k, i]
            p2, p3 = image[j + k, i + 1], image[j + k, i + 2]
            row = a0 * p0 + a1 * p1 + a2 * p2 + a3 * p3
            value += b * row
            along += b * (d0 * p0 + d1 * p1 + d2 * p2 + d3 * p3)
            below += e * row
        across[n], down[n] = along, below
        out[n] = value

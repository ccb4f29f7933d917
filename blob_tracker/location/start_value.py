"""Where the fit starts: near enough to the peak of the likelihood to climb it."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.sites import ABSENT_DN
import numpy as np


@kernel
def start_value(
    pixels: Array, lit: Array, saturation: float, paired: bool, mean: float, theta: Array
) -> None:
    """
    Fill theta with a first guess: the half-height box about the brightest 3 x 3 pixels.

    A Gaussian is above half its height, and clipped above the level c of its peak, over the areas
    2 pi sigma^2 ln 2 and 2 pi sigma^2 ln(peak / c). With the half taken of the highest level
    that is left, the difference of the two areas gives sigma and their ratio the peak. The level
    is the mean of the unlit window where the window is one of a pair.
    """
    height, width = pixels.shape
    level = mean
    if not paired:
        # The darkest side: a pulse at the window's edge lights one or two of them.
        level = math.inf
        for j in (0, height - 1):
            total = 0.0
            for i in range(width):
                total += pixels[j, i]
            level = min(level, total / width)
        for i in (0, width - 1):
            total = 0.0
            for j in range(height):
                total += pixels[j, i]
            level = min(level, total / height)
    brightest = -math.inf
    row, column = 0, 0
    squares = np.empty(width)
    for j in range(height):
        squares[:] = 0.0
        for jj in range(max(j - 1, 0), min(j + 2, height)):
            # One neighbour after the other: the compiler widens these loops.
            for i in range(1, width):
                squares[i] += pixels[jj, i - 1] - level
            for i in range(width):
                squares[i] += pixels[jj, i] - level
            for i in range(width - 1):
                squares[i] += pixels[jj, i + 1] - level
        for i in range(width):
            # Twice the pixel itself decides between the equals of an undersampled pulse.
            total = squares[i] + 2.0 * (pixels[j, i] - level)
            if total > brightest:
                brightest, row, column = total, j, i
    top = -math.inf
    for j in range(max(row - 1, 0), min(row + 2, height)):
        for i in range(max(column - 1, 0), min(column + 2, width)):
            top = max(top, pixels[j, i])
    half = level + 0.5 * (top - level)
    left, right, upper, lower = column, column, row, row
    while left > 0 and pixels[row, left - 1] > half:
        left -= 1
    while right < width - 1 and pixels[row, right + 1] > half:
        right += 1
    while upper > 0 and pixels[upper - 1, column] > half:
        upper -= 1
    while lower < height - 1 and pixels[lower + 1, column] > half:
        lower += 1
    total, x, y = 0.0, 0.0, 0.0
    above, clipped = 0, 0
    for j in range(upper, lower + 1):
        for i in range(left, right + 1):
            excess = pixels[j, i] - half
            if excess > 0.0:
                above += 1
                total += excess
                x += excess * i
                y += excess * j
                if saturation <= lit[j, i] < ABSENT_DN:
                    clipped += 1
    if total > 0.0:
        x /= total
        y /= total
    else:
        x, y = float(column), float(row)
    ring = max(above - clipped, 1)
    theta[0] = x
    theta[1] = y
    theta[2] = max((top - level) * 2.0 ** min(clipped / ring, 8.0), 1e-3)
    theta[3] = level
    theta[4] = min(max(math.sqrt(ring / (2.0 * math.pi * math.log(2.0))), 0.5), width)
    theta[5] = theta[4]

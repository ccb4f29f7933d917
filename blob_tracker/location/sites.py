"""Windows of which some pixels do not see the light: those behind filters of other colours."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel, written_into_kernels
from blob_tracker.location.hypotheses import History, Pair, UNKNOWN, Way
from blob_tracker.location.likelihood import Observation
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

# DN: of a pixel that is no sample. It is above all levels, so that it is left out wherever a
# clipped pixel is, and no clipped pixel is as high.
ABSENT_DN = 2e9
BY_SITES = ('maximum_likelihood',)  # the methods that can do without a pixel


def blanked(lit: NDArray[np.float64], sites: NDArray[np.bool_]) -> NDArray[np.float64]:
    """
    Return windows in which the pixels that are no samples are marked.

    Parameters
    ----------
    lit : (N, h, w) array
        DN.
    sites : (h, w) bool array
        Which pixels are samples.

    """
    return np.where(sites, lit, ABSENT_DN)


def pair_of(
    lit: NDArray[np.float64], unlit: NDArray[np.float64] | None, noise: SensorNoise,
    saturation: float, *, history: History = UNKNOWN, way: Way | None = None,
    haunted: bool = False,
) -> Pair:
    """
    Return the pair of one (h, w) window in which the pixels that are no samples are marked.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN; the lit ones `blanked`, unlit may be None.
    noise, saturation, history, way, haunted
        As of `Pair`.

    """
    if not lacks_samples(lit):
        return Pair(lit, unlit, noise, saturation, history, way, haunted=haunted)
    sites = lit != ABSENT_DN
    pictures = []
    for each in (lit, unlit):
        if each is not None:
            pictures.append(each.copy())
            fill_absent(pictures[-1], lit)
    return Pair(
        pictures[0], None if unlit is None else pictures[1], noise, saturation, history, way,
        sites=sites, haunted=haunted,
    )


@kernel
def lacks_samples(lit: Array) -> bool:
    """Tell whether a window has pixels that are no samples."""
    found = False
    for j in range(lit.shape[0]):
        for i in range(lit.shape[1]):
            found = found or lit[j, i] == ABSENT_DN
    return found


@kernel
def fill_absent(pixels: Array, lit: Array) -> None:
    """
    Make each pixel that is no sample the mean of the samples among its eight neighbours.

    The picture is then one that has a brightest pixel and a half height: good enough to start
    from. What is filled in weighs nothing in the fit.
    """
    height, width = pixels.shape
    for j in range(height):
        for i in range(width):
            if lit[j, i] < ABSENT_DN:
                continue
            total, count = 0.0, 0
            for jj in range(max(j - 1, 0), min(j + 2, height)):
                for ii in range(max(i - 1, 0), min(i + 2, width)):
                    if lit[jj, ii] < ABSENT_DN:
                        total += pixels[jj, ii]
                        count += 1
            pixels[j, i] = total / count if count > 0 else 0.0


@written_into_kernels
def observe(
    n: int, lit: Array, unlit: Array, paired: bool, saturation: float, seen: Observation,
    texture: Array, clipped: NDArray[np.int64],
) -> tuple[int, float]:
    """
    Fill the observation and the texture of window n with its pixels.

    Clipped pixels and those that are no samples get an infinite variance; `clipped[n]` counts
    the former. Returns how many are left, and the sum of the texture over them.
    """
    height, width = texture.shape
    usable = 0
    mean = 0.0
    for j in range(height):
        for i in range(width):
            seen.pixels[j, i] = lit[j, i]
            seen.extra[j, i] = seen.floor
            lost = lit[j, i] >= saturation
            if lost and lit[j, i] < ABSENT_DN:
                clipped[n] += 1
            if paired:
                texture[j, i] = unlit[j, i]
                lost = lost or unlit[j, i] >= saturation
            if lost:
                seen.extra[j, i] = math.inf
            else:
                usable += 1
                mean += texture[j, i]
    return usable, mean

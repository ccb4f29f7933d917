"""Interpolate the unlit frame at the places that the lit one's pixels see."""

from __future__ import annotations

import math
from typing import Any

from blob_tracker.kernel import kernel
from blob_tracker.segmentation.box import Box
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

LOBES = 3.0  # of the Lanczos kernel: two place a blob up to 8 % worse, four no better
TAPS = 6  # pixels under it
TAPS_BEFORE = 2  # of them are before the pixel to the left of the place
PHASES = 128  # between two pixels: a place is off by 1/256 px at most
SHORT_RUN_PX = 8  # px: a shorter run costs more to set up than to go through


def warped(
    lit: Pixels, unlit: Pixels, found: NDArray[np.float64], box: Box | None = None
) -> Pixels:
    """
    Return the unlit frame as the camera would have seen it from where the lit one was taken.

    Between pixels it is interpolated by the kernel of Lanczos (1979), with three lobes,

        L(t) = sinc(t) sinc(t / 3), |t| < 3

    first along the rows and then along the columns (Catmull and Smith, 1980), which keeps the
    texture that a pixel can hold: by a cubic a blob before strong texture is placed a third
    worse. Where the kernel leaves the unlit frame it is the lit one: nothing rises there.

    Parameters
    ----------
    lit, unlit : (H, W) arrays
        DN, the whole frames.
    found : (2, 3) array
        From places in the unlit frame to places in the lit one, px; a turn is far below 90
        degrees.
    box : Box, optional
        The part of the lit frame that is wanted; all of it where it is left out.

    Returns
    -------
    (h, w) array
        DN, of the type and size of `lit`, or of the box. It may be a view of `unlit` where
        nothing moved.

    """
    box = box or Box(0, 0, lit.shape[1], lit.shape[0])
    if np.array_equal(found, np.eye(2, 3)):
        return unlit[box.slices]
    import cv2  # no part of a start

    back = np.asarray(cv2.invertAffineTransform(found), dtype=np.float64)
    top, bottom = _rows(back, box, unlit.shape[0])
    rows = np.empty((bottom - top, box.x1 - box.x0), np.float32)
    columns = np.empty((box.x1 - box.x0, box.y1 - box.y0), np.float32)
    out = lit[box.slices].copy()
    if rows.size:
        # A row of the unlit frame meets the columns of the lit one where b_0 (x, y, 1) has the
        # y that gives this row; between them lies a shear.
        shear = back[0, 1] / back[1, 1]
        slope = back[0, 0] - shear * back[1, 0]
        start = back[0, 2] + slope * box.x0 + shear * (top - back[1, 2])
        _along_rows(
            unlit[top:bottom].astype(np.float32), (start, slope, shear), _WEIGHTS, rows
        )
        start = back[1] @ (box.x0, box.y0, 1.0) - top
        turned = np.asarray(cv2.transpose(rows), np.float32)
        _along_rows(turned, (start, back[1, 1], back[1, 0]), _WEIGHTS, columns)
        _round(np.asarray(cv2.transpose(columns), np.float32), np.iinfo(out.dtype).max, out)
    return out


def _rows(back: NDArray[np.float64], box: Box, height: int) -> tuple[int, int]:
    """Return the first row of the unlit frame that the box needs, and one past the last."""
    places = [back[1] @ (x, y, 1.0) for x in (box.x0, box.x1 - 1) for y in (box.y0, box.y1 - 1)]
    top = max(math.floor(min(places)) - TAPS_BEFORE, 0)
    return top, max(min(math.floor(max(places)) + TAPS - TAPS_BEFORE, height), top)


def _weights() -> NDArray[np.float32]:
    """Return the (PHASES + 1, TAPS) weights of the pixels about a place; each row sums to 1."""
    away = np.arange(TAPS) - TAPS_BEFORE - np.linspace(0.0, 1.0, PHASES + 1)[:, None]
    lobes = np.sinc(away) * np.sinc(away / LOBES) * (np.abs(away) < LOBES)
    return np.asarray(lobes / lobes.sum(axis=1, keepdims=True), dtype=np.float32)


_WEIGHTS = _weights()


@kernel
def _along_rows(
    image: NDArray[np.float32],
    places: tuple[float, float, float],
    weights: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """
    Interpolate each row of the image at start + slope i + shear j; NaN where it ends.

    Over `run` pixels the phase is the same, as the slope is nearly 1: there the inner loop is
    one that the compiler can widen.
    """
    start, slope, shear = places
    height, width = out.shape
    last = image.shape[1] - TAPS
    drift = abs(slope - 1.0)
    slow = drift * PHASES * SHORT_RUN_PX < 1.0
    for j in range(height):
        i = 0
        while i < width:
            place = start + slope * i + shear * j
            left = math.floor(place)
            phase = int((place - left) * PHASES + 0.5)
            first = left - TAPS_BEFORE
            if first < 0 or first > last:
                out[j, i] = math.nan
                i += 1
                continue
            w0, w1, w2 = weights[phase, 0], weights[phase, 1], weights[phase, 2]
            w3, w4, w5 = weights[phase, 3], weights[phase, 4], weights[phase, 5]
            if not slow:
                out[j, i] = (
                    w0 * image[j, first] + w1 * image[j, first + 1] + w2 * image[j, first + 2]
                    + w3 * image[j, first + 3] + w4 * image[j, first + 4]
                    + w5 * image[j, first + 5]
                )
                i += 1
                continue
            off = place - left - phase / PHASES
            room = 0.5 / PHASES + (off if slope < 1.0 else -off)
            run = min(width - i, last - first + 1)
            if drift * run > room:
                run = int(room / drift) + 1
            row, line = image[j, first:first + run + TAPS - 1], out[j, i:i + run]
            for k in range(run):
                line[k] = (
                    w0 * row[k] + w1 * row[k + 1] + w2 * row[k + 2]
                    + w3 * row[k + 3] + w4 * row[k + 4] + w5 * row[k + 5]
                )
            i += run


@kernel
def _round(values: NDArray[np.float32], full: int, out: NDArray[Any]) -> None:
    """Round to the integers of `out`, which stays as it is where a value is NaN."""
    lowest, half, highest = np.float32(0.0), np.float32(0.5), np.float32(full)
    for j in range(out.shape[0]):
        for i in range(out.shape[1]):
            value = values[j, i]
            if value == value:
                out[j, i] = int(min(max(value + half, lowest), highest))


def overlap(found: NDArray[np.float64], shape: tuple[int, int]) -> Box:
    """
    Return the largest box of the lit frame that the unlit one covers, the kernel's reach included.

    Parameters
    ----------
    found : (2, 3) array
        From places in the unlit frame to places in the lit one, px.
    shape : (int, int)
        Height and width of both, px.

    Returns
    -------
    Box
        px of the lit frame; without pixels where they have none in common.

    """
    height, width = shape
    if np.array_equal(found, np.eye(2, 3)):
        return Box(0, 0, width, height)
    ends = np.array([[0, 0, 1], [width - 1, 0, 1], [0, height - 1, 1], [width - 1, height - 1, 1]])
    x, y = found @ ends.T
    x0 = max(math.ceil(max(x[0], x[2])) + TAPS // 2, 0)
    y0 = max(math.ceil(max(y[0], y[1])) + TAPS // 2, 0)
    x1 = min(math.floor(min(x[1], x[3])) + 1 - TAPS // 2, width)
    y1 = min(math.floor(min(y[2], y[3])) + 1 - TAPS // 2, height)
    return Box(x0, y0, max(x1, x0), max(y1, y0))

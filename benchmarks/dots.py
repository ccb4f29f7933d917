"""Dark dots on a regular grid: well sampled, sigma about 3 px."""

from __future__ import annotations

from collections import deque
from pathlib import Path

from benchmarks.field import cut, Field
from benchmarks.windows import Windows
from blob_tracker.types import SensorNoise
import cv2
from cv2.typing import MatLike
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

SIDE = 15  # px: the pitch of the dots; narrower, a Gaussian fits their flat tops worse
CLOSING = 31  # px: wider than a dot, so that a closing leaves the bright target alone
REACH = 0.25  # of the spacing: how far a neighbour may be from where the grid has it
# A JPEG's noise hardly follows the light: 5 DN everywhere, and little shot noise.
NOISE = SensorNoise(gain=100.0, read_noise=5.0)
SIGMA = 2.6


def fields(data: Path) -> list[Field]:
    """Return a field for each dot pattern of the folder."""
    return [_field(path) for path in sorted((data / 'dots').glob('*.jpg'))]


def _field(path: Path) -> Field:
    frame = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if frame is None:
        raise FileNotFoundError(f'{path} is no picture that OpenCV reads')
    target = cv2.morphologyEx(frame, cv2.MORPH_CLOSE, np.ones((CLOSING, CLOSING), np.uint8))
    dots = cv2.subtract(target, frame)
    coarse = _coarse(dots)
    indices = _grid(coarse)
    x0, y0 = (np.rint(coarse) - SIDE // 2).astype(int).T
    height, width = frame.shape
    kept = np.isfinite(indices).all(axis=1) & (x0 >= 0) & (y0 >= 0)
    kept &= (x0 <= width - SIDE) & (y0 <= height - SIDE)
    u, v = indices[kept].T
    return Field(
        path.stem,
        Windows(cut(255 - frame, x0[kept], y0[kept], SIDE), None, NOISE, 256, SIGMA),
        x0[kept].astype(float),
        y0[kept].astype(float),
        u,
        v,
        np.full(len(u), np.inf),
        order=7,
    )


def _coarse(dots: MatLike) -> NDArray[np.float64]:
    """Return (N, 2) px: the middles of the whole dots, by Otsu's threshold."""
    _, binary = cv2.threshold(dots, 0, 255, cv2.THRESH_OTSU)
    _, _, table, middles = cv2.connectedComponentsWithStats(binary)
    areas = table[1:, cv2.CC_STAT_AREA]
    return middles[1:][(areas > 0.7 * np.median(areas)) & (areas < 1.5 * np.median(areas))]


def _grid(middles: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    Return (N, 2) grid indices, walked from the middle of the picture; NaN where not reached.

    Each step starts where the last one led, so the grid may bend as it likes.
    """
    tree = KDTree(middles)
    seed = int(tree.query(middles.mean(axis=0))[1])
    near = middles[tree.query(middles[seed], k=5)[1][1:]] - middles[seed]
    right = near[np.argmax(near[:, 0])]
    down = near[np.argmax(near[:, 1])]
    indices = np.full((len(middles), 2), np.nan)
    indices[seed] = 0.0
    queue = deque([(seed, right, down)])
    while queue:
        dot, right, down = queue.popleft()
        for step, axis, sign in ((right, 0, 1), (right, 0, -1), (down, 1, 1), (down, 1, -1)):
            distance, other = tree.query(middles[dot] + sign * step)
            if distance > REACH * np.hypot(*step) or np.isfinite(indices[other, 0]):
                continue
            indices[other] = indices[dot]
            indices[other, axis] += sign
            moved = sign * (middles[other] - middles[dot])
            queue.append((other, moved, down) if axis == 0 else (other, right, moved))
    return indices

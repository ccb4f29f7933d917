"""The lens model plumb_bob: the polynomial that ends at k3 (Brown, 1966), of most lenses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from blob_tracker.camera.lens.definition import Lens, Start
from blob_tracker.camera.lens.polynomial import COUNTS, image, project, ray, slopes
import numpy as np
from numpy.typing import NDArray

NAMES = ('k1', 'k2', 'p1', 'p2', 'k3')
FIT_STEPS = 200
FIT_CLOSE = 1e-12  # relative change of what OpenCV fits, at which it ends


def start(
    points: Sequence[NDArray[np.float64]],
    places: Sequence[NDArray[np.float64]],
    size: tuple[int, int],
) -> Start:
    """Return the least sum of squares, which OpenCV finds."""
    import cv2  # 30 MB, which a node that only asks for bearings never needs

    # Without a start OpenCV makes one: its typed interface asks for one nevertheless.
    calibrate: Any = cv2.calibrateCamera
    _, matrix, coefficients, rotations, translations = calibrate(
        [each.astype(np.float32) for each in points],
        [each.astype(np.float32) for each in places],
        size,
        None,
        None,
        criteria=(cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, FIT_STEPS, FIT_CLOSE),
    )
    return Start(
        np.asarray(matrix, dtype=float),
        np.ravel(coefficients)[: len(NAMES)].astype(float),
        np.array(rotations, dtype=float).reshape(-1, 3),
        np.array(translations, dtype=float).reshape(-1, 3),
    )


LENS = Lens(
    counts=COUNTS, image=image, ray=ray, names=NAMES, start=start, project=project,
    slopes=slopes,
)

"""What is wrong with a calibration by itself, before a light is seen with it."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.camera.lens import LensError
from blob_tracker.camera.yaml_file import CalibrationError
import numpy as np
from numpy.typing import NDArray

NORMALISED = 10.0  # px: no camera has so short a focal length; one in widths of the picture has
MIDDLE_OF_WIDTHS = 2.0  # px: in widths of the picture it is 0.5
# Times the size that K may be of: that of the sensor, beside binned pictures. The other way round
# it may be a crop that begins in the sensor's corner.
SCALES = (1 / 8, 1 / 4, 1 / 3, 1 / 2)
ALIKE = 0.06  # relative, that a principal point may be off the middle of the other size
MIDDLE = 0.25  # of the size, from the border to where a principal point may be
SQUARE = 1.25  # fx / fy: pixels of analogue grabbers have up to 1.2
GRID = 12  # rays along each side


def doubts(
    matrix: NDArray[np.float64], width: int, height: int,
    unproject: Callable[[float, float], object],
) -> list[str]:
    """
    Return what is unusual about a camera, a sentence each, with what it means.

    Parameters
    ----------
    matrix : (3, 3) array
        K, px.
    width, height : int
        Size of its pictures, px.
    unproject : callable
        See `CameraModel.unproject`; only whether there is a ray is asked for.

    Returns
    -------
    list of str
        Empty where nothing is.

    Raises
    ------
    CalibrationError
        K is surely of pictures of another size, or in other units: bearings would be wrong by a
        multiple.

    """
    (fx, _, cx), (_, fy, cy), _ = matrix
    size = np.array([width, height])
    if max(fx, fy) < NORMALISED and max(abs(cx), abs(cy)) < MIDDLE_OF_WIDTHS:
        raise CalibrationError(
            f'K has focal lengths of {fx:.3g} and {fy:.3g} px: it is in units of the width; '
            f'multiply it by {width}'
        )
    centre = np.array([cx, cy])
    for scale in SCALES:
        if (abs((2.0 * centre + 1.0) / size - scale) < ALIKE * scale).all():
            raise CalibrationError(
                f'the principal point, ({cx:.0f}, {cy:.0f}), is the middle of '
                f'{scale * width:.0f} x {scale * height:.0f} px, and the calibration is said to '
                f'be for {width} x {height} px: K and size are of different binnings; give the '
                'size at which it was calibrated'
            )
    found = []
    if ((centre < MIDDLE * size) | (centre > (1.0 - MIDDLE) * size)).any():
        found.append(
            f'the principal point, ({cx:.0f}, {cy:.0f}), is far from the middle of {width} x '
            f'{height} px: is K of a crop, or of pictures of another binning?'
        )
    if not 1.0 / SQUARE <= fx / fy <= SQUARE:
        found.append(
            f'the focal lengths, {fx:.0f} and {fy:.0f} px, are those of pixels that are '
            f'{fx / fy:.2f} times as high as wide: is the picture squeezed, or K of another size?'
        )
    blind = _without_rays(width, height, unproject)
    if blind > 0.0:
        found.append(
            f'no ray leads to {100.0 * blind:.0f} % of the picture: the lens model folds outside '
            'of where it was calibrated, and a light there has no bearing; calibrate with the '
            'board in the corners, or with fewer coefficients'
        )
    return found


def _without_rays(
    width: int, height: int, unproject: Callable[[float, float], object]
) -> float:
    """Return the part of the picture to which no ray leads."""
    blind = 0
    for y in np.linspace(0.0, height - 1.0, GRID):
        for x in np.linspace(0.0, width - 1.0, GRID):
            try:
                unproject(x, y)
            except LensError:
                blind += 1
    return blind / GRID**2

"""What the views of a board leave open, and which picture to take next."""

from __future__ import annotations

from blob_tracker.calibration.board import BoardCalibration
import numpy as np
from numpy.typing import NDArray

ENOUGH_VIEWS = 10
TILT = np.radians(15.0)  # of a view that tells the focal length from the distance
TILTED_VIEWS = 2  # each way at least: one alone may be a bad one
BORDERS = (0.25, 0.75)  # of the fields, as parts of width and height
COLUMNS, ROWS = ('left', 'middle', 'right'), ('top', 'middle', 'bottom')
UNKNOWN_FOCAL_LENGTH = 0.01  # of itself


def advice(found: BoardCalibration) -> list[str]:
    """
    Say what the views leave open.

    Parameters
    ----------
    found : BoardCalibration
        The calibration.

    Returns
    -------
    list of str
        A sentence for each fault, with the picture to take next; empty if there is none.

    """
    words = []
    count = len(found.views)
    if count < ENOUGH_VIEWS:
        words.append(f'{count} views are few: take {ENOUGH_VIEWS} or more')
    words += _tilts(found)
    words += _coverage(found)
    relative = found.sigmas[:2] / found.values[:2]
    if relative.max() > UNKNOWN_FOCAL_LENGTH:
        words.append(
            f'the focal length is known to {100.0 * relative.max():.1f} % only: take views tilted '
            'by 30 to 45 degrees, the board filling the image'
        )
    return words


def tilts(found: BoardCalibration) -> NDArray[np.float64]:
    """Return how each view is turned about the upright and the level axis, (M, 2), rad."""
    normals = found.normals
    return np.arctan2(normals[:, :2], normals[:, 2:])


def _tilts(found: BoardCalibration) -> list[str]:
    turned = np.abs(tilts(found)) >= TILT
    if not turned.any():
        return [
            'all views face the camera squarely, which leaves focal length and distance open: '
            'tilt the board by 30 degrees to the left, to the right, up and down'
        ]
    words = []
    for axis, (way, name) in enumerate(
        (('left or right', 'its left or right edge'), ('up or down', 'its upper or lower edge'))
    ):
        if turned[:, axis].sum() < TILTED_VIEWS:
            words.append(
                f'fewer than {TILTED_VIEWS} views are tilted {way} by 15 degrees or more: take '
                f'one with {name} 30 degrees nearer to the camera, and one the other way'
            )
    return words


def _coverage(found: BoardCalibration) -> list[str]:
    """Name the fields of the image in which there was no point."""
    places = np.vstack([view.places for view in found.views])
    size = np.array([found.model.width, found.model.height])
    cells = np.searchsorted(BORDERS, ((places + 0.5) / size).ravel()).reshape(-1, 2)
    seen = {(int(x), int(y)) for x, y in cells}
    missing = [
        f'{ROWS[y]} {COLUMNS[x]}' if (x, y) != (1, 1) else 'middle'
        for y in range(3)
        for x in range(3)
        if (x, y) not in seen
    ]
    if not missing:
        return []
    return [
        f'no point of the board lies in the {_list(missing)} of the image: take a picture with '
        'the board there'
    ]


def _list(words: list[str]) -> str:
    return ' and '.join([', '.join(words[:-1]), words[-1]] if len(words) > 1 else words)

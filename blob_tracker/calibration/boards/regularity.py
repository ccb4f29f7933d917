"""
How evenly points that were found lie, judged from themselves: no camera is needed.

A lens changes the distance of neighbours slowly along a row of a board, a perspective as a
homography does. Errors of the corners do not, nor does a grid whose rows were counted wrong.
"""

from __future__ import annotations

from blob_tracker.calibration.boards.board import View
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

# Of the distance of neighbours, without the perspective: 0.08 of boards tilted by 45 degrees, 0.41
# near the rim of fish-eyes; a row of six that was passed over makes it 0.57, wrong counts 2 to 7.
UNEVEN = 0.5
DIFFERENCES = 20.0  # variance of a third difference of independent errors: 1 + 9 + 9 + 1

Array = NDArray[np.float64]


def roughness(places: Array) -> float:
    """
    Return the error of the points of a grid, px, as the third differences along its lines have it.

    Parameters
    ----------
    places : (rows, columns, 2) array
        px; one side must be 4 or longer.

    Returns
    -------
    float
        sqrt(mean(d^2) / 20) with d = p[i+3] - 3 p[i+2] + 3 p[i+1] - p[i].

    """
    differences = np.concatenate([np.diff(places, 3, axis=axis).ravel() for axis in (0, 1)])
    return float(np.sqrt(np.mean(differences**2) / DIFFERENCES))


def is_even(view: View) -> bool:
    """
    Tell whether the points of a view lie as those of a board do.

    Parameters
    ----------
    view : View
        Points and places.

    Returns
    -------
    bool
        Whether each point lies within 0.5 of the spacing of the middle between its neighbours on
        either side, once the homography that takes the places nearest to the board is applied;
        True if no point has such neighbours.

    """
    tree = cKDTree(view.points)
    spacing = float(np.median(tree.query(view.points, 2)[0][:, 1]))
    first, second = tree.query_pairs(1.05 * spacing, output_type='ndarray').T
    # Both ways: the third point lies as far beyond the middle one as the first lies before it.
    start, middle = np.concatenate([first, second]), np.concatenate([second, first])
    distance, end = tree.query(2.0 * view.points[middle] - view.points[start])
    there = distance < 0.05 * spacing
    if not there.any():
        return True
    turned, _ = cv2.findHomography(view.places, view.points)
    if turned is None:
        return False  # places on one line are those of no board
    flat = cv2.perspectiveTransform(view.places[:, None], turned)[:, 0]
    before, at, after = (flat[each[there]] for each in (start, middle, end))
    bend = np.linalg.norm(before - 2.0 * at + after, axis=1)
    return bool((bend <= UNEVEN * 0.5 * np.linalg.norm(after - before, axis=1)).all())

"""Where the target may be: an image file, white for yes."""

from __future__ import annotations

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters.url import to_path
import numpy as np
from numpy.typing import NDArray

WHITE = 128  # and brighter; a drawing program softens edges


def read_mask(url: str) -> NDArray[np.bool_] | None:
    """
    Return the mask that a URL names.

    Parameters
    ----------
    url : str
        Of an image of 8 bits: a path, file:// or package://; empty if there is none.

    Returns
    -------
    (h, w) bool array or None
        True where the target may be.

    Raises
    ------
    ParameterError
        If there is no such image, it cannot be read, has other than 8 bits, or is black all
        over.

    """
    if not url:
        return None
    path = to_path(url)
    try:
        there = path.is_file()
    except OSError as error:  # a name that is too long
        raise ParameterError(f'there is no file {str(path)[:80]}: {error.strerror}') from None
    if not there:
        raise ParameterError(f'there is no file {path}')
    import cv2  # no part of a start

    try:
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH)
    except cv2.error:  # more pixels than OpenCV reads
        image = None
    if image is None:
        raise ParameterError(f'{path} is not an image; draw a PNG, white where the target may be')
    if image.dtype != np.uint8:
        raise ParameterError(f'{path} has {8 * image.itemsize} bits a channel; it must have 8')
    mask = np.asarray(image >= WHITE)
    if not mask.any():
        raise ParameterError(f'{path} is black all over; draw white where the target may be')
    return mask

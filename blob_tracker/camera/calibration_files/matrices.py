"""
K and the distortion by their names: ROS' YAML, an echoed camera_info, OpenCV's files.

Each writes the same matrices under names of its own, and OpenCV lets every program choose them.
"""

from __future__ import annotations

import re
from typing import Any

from blob_tracker.camera.calibration_files.values import matrix, numbers, whole
from blob_tracker.camera.lens import todays_name
from blob_tracker.camera.lens.polynomial import COUNTS
from blob_tracker.camera.yaml_file import CalibrationError
import numpy as np

# Small letters, without what separates words.
MATRIX = ('cameramatrix', 'k', 'mtx', 'cammtx', 'intrinsicmatrix', 'intrinsics', 'intrinsic')
DISTORTION = (
    'distortioncoefficients', 'd', 'dist', 'distcoeffs', 'distcoeff', 'distcoefs', 'distortion',
    'distortioncoeffs',
)
WIDTH, HEIGHT = ('imagewidth', 'width', 'framewidth'), ('imageheight', 'height', 'frameheight')
SIZE = ('imagesize', 'size', 'resolution', 'calibimagesize', 'imageresolution')
POLYNOMIALS = ('plumb_bob', 'rational_polynomial')


def read_matrices(
    content: dict[str, Any], size: tuple[int, int] | None, remarks: list[str]
) -> dict[str, Any] | None:
    """
    Return the arguments of `CameraModel`, or None if the file names no such matrices.

    Parameters
    ----------
    content : dict
        Names and values of the file.
    size : (int, int), optional
        Width and height that count where the file has none, px.
    remarks : list of str
        Takes what has to be said of the file.

    """
    found = {re.sub(r'[^a-z0-9]', '', name.lower()): name for name in content}

    def entry(*names: str) -> tuple[Any, str] | None:
        name = next((found[each] for each in names if each in found), None)
        return None if name is None else (content[name], name)

    stereo = [found[each] for each in ('m1', 'k1', 'cameramatrix1', 'cameramatrixleft',
                                       'leftcameramatrix') if each in found]
    k, d = entry(*MATRIX), entry(*DISTORTION)
    if k is None:
        if stereo:
            raise CalibrationError(
                f'is of two cameras ({stereo[0]} ...): write one of them as camera_matrix, '
                'distortion_coefficients, image_width and image_height'
            )
        if not found.keys() & {*WIDTH, *HEIGHT, *DISTORTION[:1]}:
            return None
    width, height = _size(entry(*WIDTH), entry(*HEIGHT), entry(*SIZE), size)
    if k is None:
        raise CalibrationError('has no camera_matrix')
    if d is None:
        raise CalibrationError(
            'has no distortion_coefficients; four times 0 is a lens without distortion')
    distortion = numbers(*d)
    model = _model(content, found, k[1], len(distortion), remarks)
    r, p = entry('rectificationmatrix', 'r'), entry('projectionmatrix', 'p')
    name = entry('cameraname')
    return {
        'width': width,
        'height': height,
        'matrix': matrix(*k, 3, 3),
        'distortion': distortion,
        'distortion_model': model,
        'name': str(name[0]) if name is not None else 'camera',
        'rectification': _optional(r, 3, 3),
        'projection': _optional(p, 3, 4),
    }


def _size(
    width: tuple[Any, str] | None, height: tuple[Any, str] | None,
    both: tuple[Any, str] | None, given: tuple[int, int] | None,
) -> tuple[int, int]:
    """Return the size of the images, px."""
    if both is not None and width is None and height is None:
        entry, name = both
        if isinstance(entry, dict) and 'data' not in entry:  # {width: ..., height: ...}
            entry = list(entry.values())
        found = numbers(entry, name, 2)
        return whole(found[0], name), whole(found[1], name)
    if width is not None and height is not None:
        return whole(*width), whole(*height)
    if given is not None:
        return given
    if width is not None or height is not None:
        raise CalibrationError(f'has no {"image_height" if height is None else "image_width"}')
    raise CalibrationError(
        'has no image_width and image_height: write them into it, or take '
        '`python3 -m blob_tracker calibrate convert FILE --size 640x480`'
    )


def _model(
    content: dict[str, Any], found: dict[str, str], matrix_name: str, count: int,
    remarks: list[str],
) -> str:
    """Return the lens model, by its name or, where it has none, by the coefficients."""
    fisheye = content[found['fisheyemodel']] if 'fisheyemodel' in found else 0
    if str(fisheye).lower() in ('1', 'true'):
        return 'equidistant'
    named = str(content.get(found.get('distortionmodel', ''), '') or '')
    if not named and count:
        if count == 4 and matrix_name not in ('camera_matrix', 'k', 'K'):
            remarks.append(
                'its four coefficients are taken for k1 k2 p1 p2; those of a fish-eye need the '
                'line distortion_model: equidistant'
            )
        return POLYNOMIALS[count > 5]
    name = todays_name(named)
    if name in POLYNOMIALS and count in COUNTS and count:
        usual = POLYNOMIALS[count > 5]
        if name != usual:
            remarks.append(f'{name} with {count} coefficients is {usual}, and is taken so')
        return usual
    return name


def _optional(entry: tuple[Any, str] | None, rows: int, columns: int) -> Any:
    """Return a matrix that may be missing; in a camera_info all zero says that it is not known."""
    if entry is None:
        return None
    found = matrix(*entry, rows, columns)
    return found if np.any(found) or len(entry[1]) > 1 else None


def read_region(
    content: dict[str, Any]
) -> tuple[tuple[int, int], tuple[int, int, int, int]] | None:
    """
    Return binning and region of the images that a file speaks of, as camera_info has them.

    Returns
    -------
    (int, int), (int, int, int, int), or None
        Binning along x and y; x_offset, y_offset, width and height of the region, px of the
        whole sensor without binning, a width of 0 for all of it. None for all of the sensor.

    """
    binning = (
        max(whole(content.get('binning_x', 0), 'binning_x'), 1),
        max(whole(content.get('binning_y', 0), 'binning_y'), 1),
    )
    roi = content.get('roi')
    roi = roi if isinstance(roi, dict) else {}
    x, y, width, height = (
        whole(roi.get(each, 0), f'{each} of roi')
        for each in ('x_offset', 'y_offset', 'width', 'height')
    )
    if binning == (1, 1) and not (x or y or width or height):
        return None
    return binning, (x, y, width, height)

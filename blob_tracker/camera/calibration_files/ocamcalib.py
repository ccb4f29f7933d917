"""OCamCalib's calib_results.txt, for the lens model of that name."""

from __future__ import annotations

from typing import Any

from blob_tracker.camera.calibration_files.values import pinhole, whole, words_of
from blob_tracker.camera.lens.ocamcalib import MOST_POWERS
from blob_tracker.camera.yaml_file import CalibrationError
import numpy as np

# Its lines of numbers, in this order, each after a comment.
_LINES = ('DIRECT mapping', 'inverse mapping', 'center', 'affine', 'image size')


def is_ocamcalib(text: str) -> bool:
    """Tell whether a text is one of OCamCalib."""
    return 'DIRECT mapping function' in text or 'ocam_model' in text


def read_ocamcalib(text: str) -> dict[str, Any]:
    """
    Return the arguments of `CameraModel`.

    Its rows are our y and its columns our x, both from the centre of the first pixel; its third
    axis looks back into the camera, and its first coefficient is minus the focal length. The
    inverse polynomial, a fit to the direct one, is not needed.
    """
    lines = [
        words_of(line.split(), name)
        for line, name in zip(
            (line for line in text.splitlines() if line.strip() and line.strip()[0] != '#'),
            _LINES,
        )
    ]
    if len(lines) < len(_LINES):
        raise CalibrationError(f'has no {_LINES[len(lines)]}')
    direct, _, centre, affine, size = lines
    powers = direct[1:]
    if len(powers) < 2 or len(powers) != direct[0] or powers[0] == 0.0:
        raise CalibrationError(
            f'announces {direct[0]:g} coefficients of the direct mapping and has {len(powers)}; '
            'there must be two or more, the first other than 0'
        )
    if len(powers) - 1 > MOST_POWERS:
        raise CalibrationError(f'has a direct mapping of more than {MOST_POWERS} powers')
    for values, count, name in ((centre, 2, 'center'), (affine, 3, 'affine'), (size, 2, 'size')):
        if len(values) != count:
            raise CalibrationError(f'has {len(values)} numbers of {name}; it must be {count}')
    focal = abs(powers[0])
    # With distances in focal lengths, and a first coefficient of 1.
    scaled = powers[1:] * focal ** np.arange(1, len(powers)) / powers[0]
    return {
        'width': whole(size[1], 'width'),
        'height': whole(size[0], 'height'),
        'matrix': pinhole(focal, focal, centre[1], centre[0]),
        'distortion': np.concatenate([affine, scaled]),
        'distortion_model': 'ocamcalib',
        'name': 'camera',
    }

"""Calibration files in the YAML form of ROS' camera_calibration_parsers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import yaml


class CalibrationError(ValueError):
    """A calibration that no ray can be computed with; the message says what is wrong."""


def read_calibration(path: str | Path) -> dict[str, Any]:
    """
    Read a calibration file.

    Parameters
    ----------
    path : str or Path
        The YAML file.

    Returns
    -------
    dict
        The arguments of `CameraModel`.

    Raises
    ------
    CalibrationError
        Where the file is missing, is not such YAML, or lacks a value.

    """
    try:
        content = yaml.safe_load(Path(path).read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(f'cannot read the calibration {path}: {error}') from None
    except yaml.YAMLError as error:
        raise CalibrationError(f'{path} is not YAML: {error}') from None
    if not isinstance(content, dict):
        raise CalibrationError(f'{path} is not a camera calibration: it holds no named values')
    try:
        return {
            'width': int(content['image_width']),
            'height': int(content['image_height']),
            'matrix': _matrix(content['camera_matrix']).reshape(3, 3),
            'distortion': _matrix(content['distortion_coefficients']).ravel(),
            'distortion_model': str(content['distortion_model']),
            'name': str(content.get('camera_name', 'camera')),
        }
    except KeyError as error:
        raise CalibrationError(f'{path} has no {error.args[0]}') from None
    except (TypeError, ValueError) as error:
        raise CalibrationError(f'{path} holds a value of the wrong form: {error}') from None


def _matrix(entry: Any) -> NDArray[np.float64]:
    """Return the numbers of a {rows, cols, data} entry."""
    return np.array(entry['data'], dtype=float).reshape(int(entry['rows']), int(entry['cols']))

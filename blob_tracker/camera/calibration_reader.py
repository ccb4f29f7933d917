"""Read a calibration in the YAML form of ROS' camera_calibration_parsers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.camera.lens import todays_name
from blob_tracker.camera.yaml_file import content_of
import numpy as np
from numpy.typing import NDArray


def read_calibration(path: str | Path) -> dict[str, Any]:
    """
    Read a calibration file.

    Parameters
    ----------
    path : str or Path
        The YAML file. What ROS' parser fills in may be missing: camera_name (camera),
        distortion_model (plumb_bob), rectification_matrix and projection_matrix (None).

    Returns
    -------
    dict
        The arguments of `CameraModel`.

    Raises
    ------
    CalibrationError
        Where the file is missing, is not such YAML, or lacks a value.

    """
    with content_of(path, 'calibration') as content:
        distortion_model = str(content.get('distortion_model', 'plumb_bob'))
        return {
            'width': _whole(content['image_width']),
            'height': _whole(content['image_height']),
            'matrix': _matrix(content['camera_matrix']).reshape(3, 3),
            'distortion': _matrix(content['distortion_coefficients']).ravel(),
            'distortion_model': todays_name(distortion_model),
            'name': str(content.get('camera_name', 'camera')),
            'rectification': _optional_matrix(content, 'rectification_matrix', (3, 3)),
            'projection': _optional_matrix(content, 'projection_matrix', (3, 4)),
        }


def _whole(entry: Any) -> int:
    """Return a size in pixels."""
    if int(entry) != float(entry):
        raise ValueError(f'a size of {entry} px')
    return int(entry)


def _matrix(entry: Any) -> NDArray[np.float64]:
    """Return the numbers of a {rows, cols, data} entry."""
    return np.array(entry['data'], dtype=float).reshape(int(entry['rows']), int(entry['cols']))


def _optional_matrix(
    content: dict[str, Any], name: str, shape: tuple[int, int]
) -> NDArray[np.float64] | None:
    """Return the numbers of an entry that may be missing."""
    return _matrix(content[name]).reshape(shape) if name in content else None

"""Calibration files in the YAML form of ROS' camera_calibration_parsers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TYPE_CHECKING

from blob_tracker.camera.lens import FORMER_NAMES
from blob_tracker.camera.yaml_file import content_of, write_content
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from blob_tracker.camera.model import CameraModel


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
            'distortion_model': FORMER_NAMES.get(distortion_model, distortion_model),
            'name': str(content.get('camera_name', 'camera')),
            'rectification': _optional_matrix(content, 'rectification_matrix', (3, 3)),
            'projection': _optional_matrix(content, 'projection_matrix', (3, 4)),
        }


def write_calibration(
    path: str | Path, model: CameraModel, comments: Sequence[str] = ()
) -> None:
    """
    Write a calibration file that `read_calibration` and ROS read back; see `write_content`.

    Parameters
    ----------
    path : str or Path
        The YAML file.
    model : CameraModel
        The calibration.
    comments : sequence of str
        Lines put on top, each after a `# `: the standard deviations, say, and the command.

    Raises
    ------
    CalibrationError
        Where it cannot be written there.

    """
    content = {
        'image_width': model.width,
        'image_height': model.height,
        'camera_name': model.name,
        'camera_matrix': _entry(model.matrix),
        'distortion_model': model.distortion_model,
        'distortion_coefficients': _entry(np.atleast_2d(model.distortion)),
        'rectification_matrix': _entry(model.rectification_matrix),
        'projection_matrix': _entry(model.projection_matrix),
    }
    write_content(path, 'calibration', content, comments)


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


def _entry(matrix: NDArray[np.float64]) -> dict[str, Any]:
    """Return the {rows, cols, data} entry of a matrix."""
    rows, columns = matrix.shape
    return {'rows': rows, 'cols': columns, 'data': [float(value) for value in matrix.ravel()]}

"""Write a calibration in the YAML form of ROS' camera_calibration_parsers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from blob_tracker.camera.calibration_reader import Region
from blob_tracker.camera.model import CameraModel
from blob_tracker.camera.yaml_file import write_content
import numpy as np
from numpy.typing import NDArray


def write_calibration(
    path: str | Path, model: CameraModel, comments: Sequence[str] = (),
    region: Region | None = None,
) -> None:
    """
    Write a calibration file that `CameraModel.from_file` and ROS read back; see `write_content`.

    Parameters
    ----------
    path : str or Path
        The YAML file.
    model : CameraModel
        The calibration.
    comments : sequence of str
        Lines put on top, each after ``#``: the standard deviations, say, and the command.
    region : Region, optional
        Of the images, where they are not the whole sensor.

    Raises
    ------
    CalibrationError
        If writing there fails.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from blob_tracker.camera import pinhole_matrix
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, 'camera.yaml')
    ...     model = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480), name='left')
    ...     write_calibration(path, model, ['sigma of the focal length: 0.3 px'])
    ...     print(path.read_text().splitlines()[0])
    ...     print(CameraModel.from_file(path).name)
    # sigma of the focal length: 0.3 px
    left

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
    if region is not None:
        content |= {
            'binning_x': region.binning[0],
            'binning_y': region.binning[1],
            'roi': {
                'x_offset': region.x0, 'y_offset': region.y0, 'height': region.height,
                'width': region.width, 'do_rectify': False,
            },
        }
    write_content(path, 'calibration', content, comments)


def _entry(matrix: NDArray[np.float64]) -> dict[str, Any]:
    """Return the {rows, cols, data} entry of a matrix."""
    rows, columns = matrix.shape
    return {'rows': rows, 'cols': columns, 'data': [float(value) for value in matrix.ravel()]}

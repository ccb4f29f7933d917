"""Calibration files in the YAML form of ROS' camera_calibration_parsers."""

from __future__ import annotations

from collections.abc import Sequence
import os
from pathlib import Path
from typing import Any, TYPE_CHECKING

from blob_tracker.camera.lens import FORMER_NAMES
import numpy as np
from numpy.typing import NDArray
import yaml

if TYPE_CHECKING:
    from blob_tracker.camera.model import CameraModel


class CalibrationError(ValueError):
    """A calibration that no ray can be computed with; the message says what is wrong."""


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
    try:
        content = yaml.safe_load(Path(path).read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(f'cannot read the calibration {path}: {error}') from None
    except yaml.YAMLError as error:
        raise CalibrationError(f'{path} is not YAML: {error}') from None
    if not isinstance(content, dict):
        raise CalibrationError(f'{path} is not a camera calibration: it holds no named values')
    try:
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
    except KeyError as error:
        raise CalibrationError(f'{path} has no {error.args[0]}') from None
    except (TypeError, ValueError) as error:
        raise CalibrationError(f'{path} holds a value of the wrong form: {error}') from None


def write_calibration(
    path: str | Path, model: CameraModel, comments: Sequence[str] = ()
) -> None:
    """
    Write a calibration file that `read_calibration` and ROS read back, to the last digit.

    The file is whole or not there: it is written beside its place and then moved. Folders that
    are missing are made; a file of that name is replaced.

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
    lines = [f'# {line}'.rstrip() for text in comments for line in text.splitlines() or ['']]
    # Lists in one line each, as ROS writes them; PyYAML writes the repr of a double.
    lines.append(yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=10**6))
    place = Path(os.path.realpath(path))  # a link stays one, and what it leads to is replaced
    beside = place.with_name(f'.{place.name}.{os.getpid()}')
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            with beside.open('w', encoding='utf-8') as file:
                file.write('\n'.join(lines))
                file.flush()
                os.fsync(file.fileno())  # else a power cut may leave the new name on no content
            beside.replace(place)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise CalibrationError(
            f'cannot write the calibration {path}: {error.strerror or error}'
        ) from None


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

"""Kalibr's camchain.yaml, which OpenVINS takes as well."""

from __future__ import annotations

from typing import Any

from blob_tracker.camera.calibration_files.ros_ini import chosen
from blob_tracker.camera.calibration_files.values import numbers, pinhole, whole
from blob_tracker.camera.yaml_file import CalibrationError
import numpy as np

# camera_model: numbers before the focal lengths, and the lens model.
_MODELS = {'pinhole': 0, 'ds': 2, 'eucm': 2, 'omni': 1}
_DISTORTIONS = {'radtan': 'plumb_bob', 'equidistant': 'equidistant', 'equi': 'equidistant'}


def cameras_of(content: dict[str, Any]) -> list[str]:
    """Return the cameras of a camchain; none where it is no such file."""
    return [
        name for name, value in content.items()
        if name.startswith('cam') and isinstance(value, dict) and 'camera_model' in value
    ]


def read_kalibr(content: dict[str, Any], camera: str) -> dict[str, Any]:
    """Return the arguments of `CameraModel` for the camera of this name, or the only one."""
    name = chosen(cameras_of(content), camera)
    entry = content[name]
    for key in ('intrinsics', 'resolution'):
        if key not in entry:
            raise CalibrationError(f'has no {key} of {name}')
    kind = str(entry['camera_model'] or 'nameless')
    bent = str(entry.get('distortion_model') or 'none')
    if kind not in _MODELS:
        raise CalibrationError(
            f'has the camera model {kind}, which is not known; calibrate again with --models '
            'pinhole-radtan, pinhole-equi, ds-none or eucm-none of Kalibr'
        )
    own = _MODELS[kind]
    values = numbers(entry['intrinsics'], f'intrinsics of {name}', own + 4)
    width, height = numbers(entry['resolution'], f'resolution of {name}', 2)
    coefficients = numbers(entry.get('distortion_coeffs', []), f'distortion_coeffs of {name}')
    focal = values[own:].copy()
    if kind == 'pinhole' and bent in _DISTORTIONS:
        lens, distortion = _DISTORTIONS[bent], coefficients
    elif bent != 'none' or coefficients.any():
        raise CalibrationError(
            f'has the camera model {kind} with the distortion {bent}, which no lens model here '
            'is; calibrate again with --models pinhole-radtan, pinhole-equi, ds-none or eucm-none '
            'of Kalibr'
        )
    elif kind == 'pinhole':
        lens, distortion = 'plumb_bob', np.zeros(4)
    elif kind == 'omni':  # Mei's is the enhanced one with a beta of 1
        xi = values[0]
        lens, distortion = 'eucm', np.array([xi / (1.0 + xi), 1.0])
        focal[:2] /= 1.0 + xi
    else:
        lens = 'double_sphere' if kind == 'ds' else 'eucm'
        distortion = values[:2]
    return {
        'width': whole(width, f'resolution of {name}'),
        'height': whole(height, f'resolution of {name}'),
        'matrix': pinhole(*focal.tolist()),
        'distortion': distortion,
        'distortion_model': lens,
        'name': name,
    }

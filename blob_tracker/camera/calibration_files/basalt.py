"""basalt's calibration.json."""

from __future__ import annotations

from typing import Any

from blob_tracker.camera.calibration_files.ros_ini import chosen
from blob_tracker.camera.calibration_files.values import number, numbers, pinhole, whole
from blob_tracker.camera.yaml_file import CalibrationError
import numpy as np

_FOCAL = ('fx', 'fy', 'cx', 'cy')
# camera_type: the lens model, and its coefficients.
_MODELS = {
    'pinhole': ('plumb_bob', ()),
    'pinhole-radtan8': ('rational_polynomial', ('k1', 'k2', 'p1', 'p2', 'k3', 'k4', 'k5', 'k6')),
    'kb4': ('equidistant', ('k1', 'k2', 'k3', 'k4')),
    'ds': ('double_sphere', ('xi', 'alpha')),
    'eucm': ('eucm', ('alpha', 'beta')),
    'ucm': ('eucm', ('alpha',)),  # with a beta of 1
}


def is_basalt(content: dict[str, Any]) -> bool:
    """Tell whether a file is one of basalt."""
    value = content.get('value0')
    return isinstance(value, dict) and isinstance(value.get('intrinsics'), list)


def read_basalt(content: dict[str, Any], camera: str) -> dict[str, Any]:
    """Return the arguments of `CameraModel` for the camera of this name, or the only one."""
    value = content['value0']
    cameras = {f'cam{index}': each for index, each in enumerate(value['intrinsics'])}
    name = chosen(list(cameras), camera)
    index = list(cameras).index(name)
    entry, sizes = cameras[name], value.get('resolution')
    if not isinstance(sizes, list) or len(sizes) <= index:
        raise CalibrationError(f'has no resolution of {name}')
    width, height = numbers(sizes[index], f'resolution of {name}', 2)
    kind = str(entry.get('camera_type') or 'nameless') if isinstance(entry, dict) else 'nameless'
    if kind not in _MODELS:
        raise CalibrationError(
            f'has the camera type {kind}, which is not known; calibrate again with one of '
            f'{", ".join(_MODELS)}'
        )
    lens, names = _MODELS[kind]
    said = entry.get('intrinsics')
    said = said if isinstance(said, dict) else {}
    values = {
        each: number(said.get(each), f'{each} of {name}') for each in (*_FOCAL, *names)
    }
    distortion = [values[each] for each in names] + ([1.0] if kind == 'ucm' else [])
    return {
        'width': whole(width, f'resolution of {name}'),
        'height': whole(height, f'resolution of {name}'),
        'matrix': pinhole(*(values[each] for each in _FOCAL)),
        'distortion': np.array(distortion) if distortion else np.zeros(4),
        'distortion_model': lens,
        'name': name,
    }

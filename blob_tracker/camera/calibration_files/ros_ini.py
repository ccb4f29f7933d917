"""ROS' .ini, and the text that cameracalibrator prints: values under their names."""

from __future__ import annotations

import re
from typing import Any

from blob_tracker.camera.calibration_files.values import matrix, whole, words_of
from blob_tracker.camera.yaml_file import CalibrationError

# What names follow each other in it, each on a line of its own.
_PARTS = ('camera matrix', 'distortion', 'rectification', 'projection')
SECTION = re.compile(r'^\[([^\]\n]+)\]\s*$', re.M)


def is_ros_ini(text: str) -> bool:
    """Tell whether a text has the section of the images and the matrix of a camera."""
    return bool(re.search(r'^\[image\]\s*$', text, re.M) and 'camera matrix' in text)


def read_ros_ini(text: str, camera: str) -> dict[str, Any]:
    """Return the arguments of `CameraModel` for the camera of this name, or the only one."""
    sections = dict(zip(SECTION.findall(text), re.split(SECTION.pattern, text, flags=re.M)[2::2]))
    image = _values(sections['image'], ('width', 'height'))
    cameras = {name: body for name, body in sections.items() if 'camera matrix' in body}
    name = chosen(list(cameras), camera)
    values = _values(cameras[name], _PARTS)
    for part in ('width', 'height'):
        if len(image.get(part, [])) != 1:
            raise CalibrationError(f'has no {part} in its section [image]')
    for part in _PARTS[:2]:
        if part not in values:
            raise CalibrationError(f'has no {part} in its section [{name}]')
    read = {part: words_of(words, part) for part, words in values.items()}
    return {
        'width': whole(image['width'][0], 'width'),
        'height': whole(image['height'][0], 'height'),
        'matrix': matrix(read['camera matrix'].tolist(), 'camera matrix', 3, 3),
        'distortion': read['distortion'],
        'distortion_model': 'plumb_bob' if len(read['distortion']) <= 5 else 'rational_polynomial',
        'name': name,
        'rectification': (
            matrix(read['rectification'].tolist(), 'rectification', 3, 3)
            if 'rectification' in read else None),
        'projection': (
            matrix(read['projection'].tolist(), 'projection', 3, 4)
            if 'projection' in read else None),
    }


def _values(body: str, names: tuple[str, ...]) -> dict[str, list[str]]:
    """Return the words after each name."""
    parts = re.split(rf'^({"|".join(names)})\s*$', body, flags=re.M)
    return {
        name: re.sub(r'[#;].*', '', words).split()
        for name, words in zip(parts[1::2], parts[2::2])
    }


def chosen(names: list[str], camera: str) -> str:
    """Return the camera that is meant among those of a file."""
    if camera:
        if camera not in names:
            raise CalibrationError(f'has no camera {camera}: it has {", ".join(names)}')
        return camera
    if len(names) != 1:
        raise CalibrationError(
            f'is of several cameras, {", ".join(names)}: take one of them, `python3 -m '
            f'blob_tracker calibrate convert FILE --camera {names[0]}`'
        )
    return names[0]

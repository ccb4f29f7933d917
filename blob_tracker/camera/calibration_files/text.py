"""A calibration file's text, and the names and values in it: YAML, JSON, XML of OpenCV."""

from __future__ import annotations

from pathlib import Path
import re
from typing import Any, TYPE_CHECKING

from blob_tracker.camera.yaml_file import CalibrationError, yaml_fault
import yaml

if TYPE_CHECKING:
    from xml.etree import ElementTree

MOST_BYTES = 10_000_000  # of a calibration
# What files begin with that are no text, and what to do about each.
_BINARY = {
    b'PK\x03\x04': 'an archive or a file of NumPy (.npz): write its matrices as ROS YAML',
    b'\x93NUMPY': 'a file of NumPy (.npy): write its matrix as ROS YAML',
    b'\x1f\x8b': 'an archive: unpack it, ROS puts ost.yaml into calibrationdata.tar.gz',
    b'MATLAB 5': 'a file of MATLAB: write K and the distortion of cameraParameters as ROS YAML',
    b'\x89HDF': 'a file of MATLAB or HDF5: write K and the distortion as ROS YAML',
    b'\x80': 'a pickle of Python, which may run anything: write its matrices as ROS YAML',
}


class _Loader(yaml.SafeLoader):
    """Of YAML in which unknown tags (!!opencv-matrix, !!python/tuple) mean nothing."""


def _untagged(loader: yaml.SafeLoader, _: str, node: yaml.Node) -> Any:
    if isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if isinstance(node, yaml.SequenceNode):
        return loader.construct_sequence(node, deep=True)
    return loader.construct_scalar(node)


_Loader.add_multi_constructor('', _untagged)


def read_text(path: str | Path) -> str:
    """Return the text of a file; raises CalibrationError where it is none."""
    file = Path(path)
    try:
        if file.exists() and not file.is_file():  # a device may be read for ever
            raise CalibrationError(f'cannot read the calibration {path}: it is not a regular file')
        with file.open('rb') as stream:
            content = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise CalibrationError(
            f'cannot read the calibration {path}: {error.strerror or error}') from None
    for start, what in _BINARY.items():
        if content.startswith(start):
            raise CalibrationError(f'{path} is {what}')
    if len(content) > MOST_BYTES:
        raise CalibrationError(f'{path} is not a calibration: it is larger than 10 MB')
    try:
        return content.decode('utf-8-sig').replace('\r\n', '\n')
    except UnicodeDecodeError:
        raise CalibrationError(f'{path} is not a calibration: it is not text in UTF-8') from None


def named_values(path: str | Path, text: str) -> dict[str, Any]:
    """Return the names and values of YAML, JSON or OpenCV's XML."""
    if text.lstrip().startswith('<'):
        return _of_xml(path, text)
    # OpenCV writes %YAML:1.0, which no other reader of YAML takes; ROS ends an echo with ---.
    body = re.sub(r'\A\s*%YAML[^\n]*\n', '', text)
    try:
        found = next((each for each in yaml.load_all(body, _Loader) if each), None)
    except yaml.YAMLError as error:
        raise CalibrationError(f'{path} is not YAML: {yaml_fault(error)}') from None
    except ValueError:
        raise CalibrationError(f'{path} is not YAML: a number or a date in it is none') from None
    if not isinstance(found, dict):
        raise CalibrationError(f'{path} is not a calibration: it holds no named values')
    return {str(name): value for name, value in found.items()}


def _of_xml(path: str | Path, text: str) -> dict[str, Any]:
    """Return what OpenCV's XML names; of any other, its root alone."""
    from xml.etree import ElementTree  # no part of a start

    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise CalibrationError(f'{path} is not XML: line {error.position[0]}') from None
    if root.tag != 'opencv_storage':
        return {root.tag: {each.tag: each.text for each in root}}
    return {each.tag: _of_element(each) for each in root}


def _of_element(element: ElementTree.Element) -> Any:
    kind = element.get('type_id', '')
    if kind in ('opencv-matrix', 'opencv-nd-matrix'):
        found: dict[str, Any] = {each.tag: (each.text or '').strip() for each in element}
        for name in ('data', 'sizes'):
            if name in found:
                found[name] = found[name].split()
        return found
    if len(element):
        return {each.tag: _of_element(each) for each in element}
    words = (element.text or '').strip().strip('"').split()
    return words[0] if len(words) == 1 else words

"""Numbers of calibration files; what is none is said by its name, in no words of Python."""

from __future__ import annotations

from typing import Any

from blob_tracker.camera.yaml_file import CalibrationError
import numpy as np
from numpy.typing import NDArray


def number(entry: Any, name: str) -> float:
    """Return a number; YAML takes 1e-5 for a text."""
    try:
        if isinstance(entry, bool):
            raise ValueError
        return float(entry)
    except (TypeError, ValueError):
        raise CalibrationError(f'{name} is not a number: {_shown(entry)}') from None


def whole(entry: Any, name: str) -> int:
    """Return a size in pixels."""
    value = number(entry, name)
    if not abs(value) < 1e9 or int(value) != value:
        raise CalibrationError(f'{name}: a size of {_shown(entry)} px')
    return int(value)


def numbers(entry: Any, name: str, *counts: int) -> NDArray[np.float64]:
    """
    Return the numbers of a list, of nested lists, or of a matrix with its `data`.

    Parameters
    ----------
    entry : list or dict
        As the file has it.
    name : str
        For the sentence.
    counts : int
        How many there may be; any number where none is named.

    """
    if isinstance(entry, dict):
        if 'data' not in entry:
            raise CalibrationError(f'{name} has no data')
        shape = entry.get('sizes', [entry.get('rows'), entry.get('cols')])
        entry = entry['data']
        if isinstance(entry, list) and None not in shape:
            named = [whole(each, f'rows or cols of {name}') for each in shape]
            if int(np.prod(named)) != len(entry):
                raise CalibrationError(
                    f'{name} holds a value of the wrong form: {" x ".join(map(str, named))} '
                    f'numbers are announced and {len(entry)} are there'
                )
    if not isinstance(entry, list):
        raise CalibrationError(f'{name} is not a list of numbers: {_shown(entry)}')
    found = np.array([number(each, name) for each in _flat(entry)])
    if counts and len(found) not in counts:
        raise CalibrationError(
            f'{name} must be {" or ".join(map(str, counts))} numbers, not {len(found)}')
    return found


def matrix(entry: Any, name: str, rows: int, columns: int) -> NDArray[np.float64]:
    """Return a matrix of this shape."""
    return numbers(entry, name, rows * columns).reshape(rows, columns)


def pinhole(fx: float, fy: float, cx: float, cy: float) -> NDArray[np.float64]:
    """Return K."""
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def words_of(words: list[str], name: str) -> NDArray[np.float64]:
    """Return the numbers of a text's words."""
    return np.array([number(each, name) for each in words])


def _flat(entry: Any) -> list[Any]:
    if not isinstance(entry, list):
        return [entry]
    return [each for inner in entry for each in _flat(inner)]


def _shown(entry: Any) -> str:
    if isinstance(entry, dict):
        return 'named values'
    if isinstance(entry, list):
        return 'a list'
    return 'nothing' if entry is None else f'{entry!s:.40}'

"""The YAML files of calibrations: read with a reason, written whole or not at all."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import os
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import yaml


class CalibrationError(ValueError):
    """
    A calibration that no ray can be computed with; the message says what is wrong.

    Examples
    --------
    A camera that was never calibrated:

    >>> import numpy as np
    >>> from blob_tracker.camera import CameraModel
    >>> CameraModel(640, 480, np.zeros((3, 3)))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.camera.yaml_file.CalibrationError: the focal lengths are 0 and 0 px; ...

    """


@contextmanager
def content_of(path: str | Path, what: str) -> Iterator[dict[str, Any]]:
    """
    Give the named values of a file; what goes wrong with them in the block names the file.

    Parameters
    ----------
    path : str or Path
        The YAML file.
    what : str
        What it should hold, for the sentence.

    Raises
    ------
    CalibrationError
        If the file is missing, is not such YAML, or the block misses a value (KeyError) or
        cannot use one (TypeError, ValueError).

    """
    try:
        if Path(path).exists() and not Path(path).is_file():  # a device may be read for ever
            raise CalibrationError(f'cannot read the {what} {path}: it is not a regular file')
        content = yaml.safe_load(Path(path).read_text(encoding='utf-8'))
    except OSError as error:
        raise CalibrationError(
            f'cannot read the {what} {path}: {error.strerror or error}') from None
    except UnicodeDecodeError:
        raise CalibrationError(f'{path} is not a {what}: it is not text in UTF-8') from None
    except yaml.YAMLError as error:
        raise CalibrationError(f'{path} is not YAML: {yaml_fault(error)}') from None
    if not isinstance(content, dict):
        raise CalibrationError(f'{path} is not a {what}: it holds no named values')
    try:
        yield content
    except CalibrationError as error:
        raise CalibrationError(f'{path}: {error}') from None
    except KeyError as error:
        raise CalibrationError(f'{path} has no {error.args[0]}') from None
    except (TypeError, ValueError) as error:
        raise CalibrationError(f'{path} holds a value of the wrong form: {error}') from None


def yaml_fault(error: yaml.YAMLError) -> str:
    """Return what is wrong with YAML in one line."""
    mark = getattr(error, 'problem_mark', None)
    problem = getattr(error, 'problem', None) or 'it has characters that YAML does not allow'
    return problem if mark is None else f'line {mark.line + 1}, {problem}'


def write_content(
    path: str | Path, what: str, content: dict[str, Any], comments: Sequence[str] = ()
) -> None:
    """
    Write a file that `content_of` reads, to the last digit.

    The file is whole or not there: it is written beside its place and then moved. Folders that
    are missing are made; a file of that name is replaced.

    Parameters
    ----------
    path : str or Path
        The YAML file.
    what : str
        What it holds, for the sentence.
    content : dict
        Named values.
    comments : sequence of str
        Lines put on top, each after a `# `: the standard deviations, say, and the command.

    Raises
    ------
    CalibrationError
        If writing there fails.

    """
    lines = [f'# {line}'.rstrip() for text in comments for line in text.splitlines() or ['']]
    # Lists in one line each, as ROS writes them; PyYAML writes the repr of a double.
    lines.append(yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=10**6))
    place = Path(os.path.realpath(path))  # a link stays one, and what it leads to is replaced
    temporary = place.with_name(f'.{place.name}.{os.getpid()}')
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            with temporary.open('w', encoding='utf-8') as file:
                file.write('\n'.join(lines))
                file.flush()
                os.fsync(file.fileno())  # else a power cut may leave the new name on no content
            temporary.replace(place)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise CalibrationError(
            f'cannot write the {what} {path}: {error.strerror or error}'
        ) from None


_Kept = TypeVar('_Kept', bound='YamlFile')


class YamlFile(ABC):
    """
    What is kept in a YAML file of its own; a class of it says what the file holds.

    Examples
    --------
    What is written is read back:

    >>> from tempfile import TemporaryDirectory
    >>> from blob_tracker.camera.trailing_edge import TrailingEdge
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, 'edge.yaml')
    ...     TrailingEdge(peaking=0.2, memory=1.5).to_yaml(path, ['of the grabber'])
    ...     print(path.read_text().splitlines()[0])
    ...     print(TrailingEdge.from_yaml(path).memory)  # px
    # of the grabber
    1.5

    """

    KIND: ClassVar[str]  # for sentences

    @classmethod
    def from_yaml(cls: type[_Kept], path: str | Path) -> _Kept:
        """
        Read what `to_yaml` has written.

        Parameters
        ----------
        path : str or Path
            The YAML file.

        Raises
        ------
        CalibrationError
            If the file is missing, is not such YAML, or holds an invalid value.

        """
        with content_of(path, cls.KIND) as content:
            return cls._of_content(content)

    def to_yaml(self, path: str | Path, comments: Sequence[str] = ()) -> None:
        """
        Write the file that `from_yaml` reads; see `write_content`.

        Parameters
        ----------
        path : str or Path
            The YAML file.
        comments : sequence of str
            Lines on top of it.

        Raises
        ------
        CalibrationError
            If writing there fails.

        """
        write_content(path, self.KIND, self._content(), comments)

    @classmethod
    @abstractmethod
    def _of_content(cls: type[_Kept], content: dict[str, Any]) -> _Kept:
        """Return what the named values of a file are."""

    @abstractmethod
    def _content(self) -> dict[str, Any]:
        """Return the named values of the file."""


def check_size(what: str, known: tuple[int, int], sensor: tuple[int, int]) -> None:
    """Raise CalibrationError unless what was measured is of a sensor of this size, px."""
    if known != sensor:
        raise CalibrationError(
            f'the {what} is of a camera with {known[0]} x {known[1]} px and the picture has '
            f'{sensor[0]} x {sensor[1]}; measure it with this camera: python3 -m blob_tracker '
            f'calibrate {what}'
        )

"""
Which frames of a folder show what light: an index.csv, or a descriptor of EMVA 1288.

The descriptor is that in which cameras are exchanged for comparison, of releases 3 and 4 of the
standard: `b EXPOSURE_NS PHOTONS` or `d EXPOSURE_NS`, and under it lines of `i FILE`; `v` has the
release, `n` bits, width and height, and `#` begins a comment.
"""

from __future__ import annotations

from collections.abc import Sequence
import csv
from io import StringIO
from pathlib import Path, PureWindowsPath
from typing import NamedTuple

from blob_tracker.calibration.frame_pair import PhotonTransferError
from blob_tracker.commands.sources import SourceError

INDEX = 'index.csv'
KINDS = ('bright', 'dark')
SERIES = {'b': 'bright', 'd': 'dark'}


class Light(NamedTuple):
    """
    What a frame was exposed to.

    Parameters
    ----------
    kind : str
        bright or dark.
    exposure_ns, photons : float or None
        Of a pixel; None if the index does not say.

    """

    kind: str
    exposure_ns: float | None = None
    photons: float | None = None

    @property
    def words(self) -> str:
        """Return it for a sentence."""
        if self.exposure_ns is not None:
            return f'{self.kind} frames at {self.exposure_ns:g} ns'
        if self.photons is not None:
            return f'{self.kind} frames at {self.photons:g} photons'
        return f'{self.kind} frames'


def find_index(folder: Path) -> Path | None:
    """Return index.csv, or else the one descriptor of EMVA 1288 in a folder; None without."""
    if (folder / INDEX).is_file():
        return folder / INDEX
    found = [file for file in sorted(folder.glob('*.txt')) if _is_descriptor(file)]
    if len(found) > 1:
        names = ' and '.join(file.name for file in found)
        raise PhotonTransferError(f'{folder} has several descriptors, {names}: leave one')
    return found[0] if found else None


def read_index(index: Path) -> dict[Path, Light]:
    """
    Read an index.

    Parameters
    ----------
    index : Path
        As `find_index` returns it.

    Returns
    -------
    dict
        Light of each file, in their order; paths count from the index.

    Raises
    ------
    SourceError
        It cannot be read.
    PhotonTransferError
        A line that cannot be understood, by its number.

    """
    lights = _rows(index) if index.name == INDEX else _series(index)
    missing = [file for file in lights if not file.is_file()]
    if missing:
        raise PhotonTransferError(f'{index} names {missing[0].name}, which is not in the folder')
    return lights


def index_rows(index: Path) -> tuple[list[dict[str, str]], Sequence[str]]:
    """Return the rows of an index.csv by its columns, and the columns; raises SourceError."""
    try:
        reader = csv.DictReader(StringIO(_text(index), newline=''))
        return list(reader), reader.fieldnames or []
    except csv.Error as error:
        raise SourceError(f'{index} cannot be read: {error}; save it as CSV in UTF-8') from None


def _text(index: Path) -> str:
    try:
        return index.read_text(encoding='utf-8-sig')  # spreadsheets begin with a byte order mark
    except UnicodeDecodeError as error:
        raise SourceError(f'{index} cannot be read: {error}; save it in UTF-8') from None


def _rows(index: Path) -> dict[Path, Light]:
    """Read an index.csv."""
    rows, columns = index_rows(index)
    if not {'file', 'kind'} <= set(columns):
        raise PhotonTransferError(
            f'{index} has the columns {", ".join(columns) or "(none)"}; it must have file and '
            'kind, and may have exposure_ns and photons_per_pixel'
        )
    lights = {}
    for row in rows:
        if row['kind'] not in KINDS:
            raise PhotonTransferError(
                f"{index}: the kind of {row['file']} is '{row['kind']}'; it must be bright or dark"
            )
        lights[_file(index, row['file'])] = Light(row['kind'], *(
            _number(row[name], f'{index}: {name} of {row["file"]},') if row.get(name) else None
            for name in ('exposure_ns', 'photons_per_pixel')
        ))
    return lights


def _series(index: Path) -> dict[Path, Light]:
    """Read a descriptor of EMVA 1288."""
    lights: dict[Path, Light] = {}
    light: Light | None = None
    for number, line in enumerate(_text(index).splitlines(), start=1):
        where = f'{index}, line {number}'
        command, _, rest = line.strip().partition(' ')
        if command in SERIES:
            values = [_number(word, f"{where}: in '{line}'") for word in rest.split()]
            if not 1 <= len(values) <= 2:
                raise PhotonTransferError(
                    f"{where}: '{line}' must have the exposure in ns, and of bright frames the "
                    'photons a pixel'
                )
            light = Light(SERIES[command], *values)
        elif command == 'i':
            if light is None:
                raise PhotonTransferError(f'{where}: an image before the first b or d')
            lights[_file(index, rest.strip())] = light
    return lights


def _is_descriptor(file: Path) -> bool:
    """Tell whether a text has series of EMVA 1288: b or d, and then i."""
    with file.open(encoding='utf-8', errors='replace') as text:
        commands = {line.strip().partition(' ')[0] for line in text}
    return 'i' in commands and bool(SERIES.keys() & commands)


def _file(index: Path, name: str) -> Path:
    """Return the path of a file, which may have been named on Windows."""
    return index.parent / PureWindowsPath(name).as_posix()


def _number(word: str, where: str) -> float:
    try:
        return float(word.replace(',', '.'))  # as programs in German or French write it
    except ValueError:
        raise PhotonTransferError(f"{where} '{word}' must be a number") from None

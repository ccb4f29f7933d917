"""What was measured already, on disk: a run that was interrupted goes on from there."""

from __future__ import annotations

from functools import lru_cache
from hashlib import sha256
import json
import os
from pathlib import Path

import blob_tracker
from blob_tracker.studies.study import Case, Measured

SOURCES = ('*.py', '*.yaml')  # of the package: what another version of them measured is not used


class Kept:
    """
    One file for each case that was measured.

    Parameters
    ----------
    folder : Path
        Where they are; made where it is not there.

    Raises
    ------
    OSError
        If it cannot be made.

    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder

    def get(self, study: str, case: Case) -> Measured | None:
        """Return what this version of the package measured; None if it has not yet."""
        try:
            text = self._path(study, case).read_text(encoding='utf-8')
        except FileNotFoundError:
            return None
        measured: Measured = json.loads(text)['measured']
        return measured

    def put(self, study: str, case: Case, measured: Measured) -> None:
        """Keep what was measured."""
        path = self._path(study, case)
        whole = path.with_suffix('.part')
        whole.write_text(json.dumps({'case': case, 'measured': measured}), encoding='utf-8')
        os.replace(whole, path)  # a file is there whole, or not at all

    def _path(self, study: str, case: Case) -> Path:
        key = json.dumps([version(), case], sort_keys=True)
        return self._folder / f'{study}-{sha256(key.encode()).hexdigest()[:24]}.json'


@lru_cache(maxsize=1)
def version() -> str:
    """Return a digest of the package's files."""
    root = Path(blob_tracker.__file__).parent
    digest = sha256()
    for path in sorted(path for pattern in SOURCES for path in root.rglob(pattern)):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()

"""Files that the package brings along."""

from __future__ import annotations

from pathlib import Path


def config_path(name: str) -> Path:
    """
    Return the path of a file in config/, from a checkout, a wheel or a colcon install alike.

    Parameters
    ----------
    name : str
        Name of the file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.

    """
    path = Path(__file__).parent / 'config' / name
    if not path.is_file():
        raise FileNotFoundError(f'{name} is not in {path.parent}')
    return path

"""Places of files as ROS writes them."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory, PackageNotFoundError
from blob_tracker.ros.errors import ParameterError


def to_path(url: str) -> Path:
    """
    Return the path that a URL names.

    Parameters
    ----------
    url : str
        A path, file:///path, or package://name/path in that package's share folder.

    Returns
    -------
    Path
        Of the file, whether it exists or not.

    Raises
    ------
    ParameterError
        Where the scheme is another or the package is not installed.

    """
    scheme, separator, rest = url.partition('://')
    if not separator:
        return Path(url)
    if scheme == 'file':
        return Path(rest)
    if scheme == 'package':
        name, _, inside = rest.partition('/')
        try:
            return Path(get_package_share_directory(name)) / inside
        except (PackageNotFoundError, ValueError):
            raise ParameterError(f"{url}: no package '{name}' is installed") from None
    raise ParameterError(f'{url}: write a path, file:// or package://, not {scheme}://')

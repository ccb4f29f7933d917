"""Places of files as ROS writes them."""

from __future__ import annotations

import os
from pathlib import Path
import re

from blob_tracker.ros.errors import ParameterError

# Where camera_info_manager keeps a calibration that was given no other place.
DEFAULT_CALIBRATION_URL = 'file://${ROS_HOME}/camera_info/${NAME}.yaml'


def to_path(url: str, camera_name: str = 'camera') -> Path:
    """
    Return the path that a URL names, as camera_info_manager reads it.

    Parameters
    ----------
    url : str
        A path, file:///path, or package://name/path in that package's share folder. ${NAME} in it
        is the camera's name, ${ROS_HOME} the folder of that environment variable, else ~/.ros.
    camera_name : str
        Name of the camera.

    Returns
    -------
    Path
        Of the file, whether it exists or not.

    Raises
    ------
    ParameterError
        If the scheme or a ${...} is another, the path after file:// is not absolute, or the
        package is not installed.

    """
    values = {
        'NAME': camera_name,
        'ROS_HOME': os.environ.get('ROS_HOME') or str(Path.home() / '.ros'),
    }

    def value(found: re.Match[str]) -> str:
        if found[1] not in values:
            names = ', '.join(f'${{{name}}}' for name in values)
            raise ParameterError(f'{url}: {found[0]} is not known; there is {names}')
        return values[found[1]]

    scheme, separator, rest = re.sub(r'\$\{([^}]*)\}', value, url).partition('://')
    if not separator:
        return Path(scheme)
    if scheme == 'file':
        if not rest.startswith('/'):
            raise ParameterError(f'{url}: after file:// comes an absolute path: file:///...')
        return Path(rest)
    if scheme == 'package':
        name, _, inside = rest.partition('/')
        try:
            from ament_index_python.packages import get_package_share_directory

            return Path(get_package_share_directory(name)) / inside
        # ImportError: there is no ROS. KeyError: no package of that name. OSError: none at all.
        except (ImportError, KeyError, ValueError, OSError):
            raise ParameterError(f"{url}: no package '{name}' is installed") from None
    raise ParameterError(f'{url}: write a path, file:// or package://, not {scheme}://')

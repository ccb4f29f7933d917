"""The response of a camera, as a parameter names its file."""

from __future__ import annotations

from blob_tracker.camera.response import Response
from blob_tracker.ros.parameters.declaration import about
from blob_tracker.ros.parameters.url import to_path


def read_response(url: str) -> Response | None:
    """
    Return the response of a parameter.

    Parameters
    ----------
    url : str
        See `to_path`; empty for a linear camera.

    Returns
    -------
    Response or None
        None where the URL is empty.

    Raises
    ------
    ParameterError
        Where there is no such file, or it is no response.

    """
    if not url:
        return None
    with about('response_url'):
        return Response.from_yaml(to_path(url))

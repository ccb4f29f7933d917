"""The body of the parameter `body_url`, for the nodes that have one: its room loads many loops."""

from __future__ import annotations

from blob_tracker.constellation import Body, read_body
from blob_tracker.ros.endpoints.names import check_light
from blob_tracker.ros.parameters.url import to_path
from blob_tracker.ros.parameters.values import about


def body_of(url: str) -> Body:
    """Return the body of the parameter `body_url`; its lights have names that topics can have."""
    with about('body_url'):
        body = read_body(to_path(url))
        for name in body.names:
            check_light(name)
    return body

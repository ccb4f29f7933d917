"""What the room refuses, and says why."""

from __future__ import annotations


class ConstellationError(ValueError):
    """
    A body, or bearings of its lights, that give no pose; the message says why.

    Examples
    --------
    >>> import numpy as np
    >>> from blob_tracker.constellation import Body, poses
    >>> from blob_tracker.types import Bearing
    >>> body = Body(('a', 'b', 'c'), 0.1 * np.eye(3), np.zeros(3))
    >>> poses(body, [('d', Bearing(0.0, 0.0, np.eye(2)))])
    Traceback (most recent call last):
        ...
    blob_tracker.constellation.errors.ConstellationError: the body has no light d: a, b, c

    """


class BodyError(ConstellationError):
    """
    A body whose lights cannot be what its file says.

    Examples
    --------
    >>> import numpy as np
    >>> from blob_tracker.constellation import Body
    >>> places = np.outer([0.0, 0.1, 0.2], [1.0, 0.0, 0.0])  # m
    >>> Body(('a', 'b', 'c'), places, np.zeros(3))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.constellation.errors.BodyError: the lights of the body are in one line: ...

    """


class TooFewLights(ConstellationError):
    """
    Fewer lights than a pose needs, or in one line.

    Examples
    --------
    >>> import numpy as np
    >>> from blob_tracker.constellation import Body, poses
    >>> from blob_tracker.types import Bearing
    >>> body = Body(('a', 'b', 'c'), 0.1 * np.eye(3), np.zeros(3))
    >>> poses(body, [('a', Bearing(0.0, 0.0, np.eye(2)))])
    Traceback (most recent call last):
        ...
    blob_tracker.constellation.errors.TooFewLights: 1 lights are seen; a pose needs three or more

    """


class Inconsistent(ConstellationError):
    """
    Bearings that no pose of the body explains.

    Examples
    --------
    Four lights that are seen where those of no such body are:

    >>> import numpy as np
    >>> from blob_tracker.constellation import Body, poses
    >>> from blob_tracker.types import Bearing
    >>> places = np.array([[0.1, 0.1, 0], [-0.1, 0.1, 0], [-0.1, -0.1, 0], [0.1, -0.1, 0]])
    >>> body = Body(('a', 'b', 'c', 'd'), places, np.zeros(4))
    >>> seen = [
    ...     (name, Bearing(azimuth, elevation, 0.01 * np.eye(2)))
    ...     for name, azimuth, elevation in zip('abcd', (0, 100, 30, 0), (0, 0, 7, 100))
    ... ]
    >>> poses(body, seen)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.constellation.errors.Inconsistent: no pose of the body explains the bearings: ...

    """

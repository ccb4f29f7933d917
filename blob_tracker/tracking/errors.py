"""What the room refuses, and says why."""

from __future__ import annotations


class TrackingError(ValueError):
    """
    A bearing, rate or joint angle that cannot be used; the message says why.

    Examples
    --------
    >>> from blob_tracker.tracking import Tracker
    >>> Tracker(coast=-1.0)
    Traceback (most recent call last):
        ...
    blob_tracker.tracking.errors.TrackingError: coast is -1.0; it must be above 0

    """


class StampJump(TrackingError):
    """
    A stamp from before all that is remembered: the clock was set back, `reset` is due.

    Examples
    --------
    A bearing from a clock that was set back by a minute:

    >>> import numpy as np
    >>> from blob_tracker.tracking import Tracker
    >>> from blob_tracker.types import Bearing
    >>> tracker = Tracker()
    >>> _ = tracker.update(Bearing(0.0, 0.0, np.eye(2), stamp_ns=60_000_000_000))
    >>> tracker.update(Bearing(0.0, 0.0, np.eye(2), stamp_ns=0))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.tracking.errors.StampJump: the stamp is 60.000 s before the newest one; ...

    """


class PlatformGap(LookupError):
    """
    An instant at which the platform's motion, or the pan/tilt's place, is not known.

    Examples
    --------
    A second after the only sample of a gyro:

    >>> from blob_tracker.tracking import PlatformRates
    >>> platform = PlatformRates(hold=0.2)
    >>> platform.push(0, [0.0, 0.1, 0.0])
    >>> platform.rate_at(1_000_000_000)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.tracking.errors.PlatformGap: the newest angular velocity is 1.000 s old; ...

    """


class TriangulationError(TrackingError):
    """
    Rays that give no position; the message says why.

    Examples
    --------
    >>> import numpy as np
    >>> from blob_tracker.tracking import CameraPose, triangulate
    >>> from blob_tracker.types import Bearing
    >>> poses = [CameraPose(np.zeros(3))]
    >>> triangulate([Bearing(0.0, 0.0, np.eye(2))], poses)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.tracking.errors.TriangulationError: bearings: 1, cameras: 1; ...

    """


class ParallelRays(TriangulationError):
    """
    Rays that are parallel as far as their covariances can tell.

    Examples
    --------
    Two cameras, 1 m apart, that see a star:

    >>> import numpy as np
    >>> from blob_tracker.tracking import CameraPose, triangulate
    >>> from blob_tracker.types import Bearing
    >>> poses = [CameraPose(np.zeros(3)), CameraPose(np.array([1.0, 0.0, 0.0]))]
    >>> triangulate([Bearing(50.0, 0.0, 0.01 * np.eye(2))] * 2, poses)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.tracking.errors.ParallelRays: the rays are parallel: ...

    """


class RaysApart(TriangulationError):
    """
    Rays that meet nowhere, or behind a camera: they are not of one light.

    Examples
    --------
    Two cameras, 1 m apart, of which one looks above what the other sees:

    >>> import numpy as np
    >>> from blob_tracker.tracking import CameraPose, triangulate
    >>> from blob_tracker.types import Bearing
    >>> poses = [CameraPose(np.zeros(3)), CameraPose(np.array([1.0, 0.0, 0.0]))]
    >>> bearings = [Bearing(50.0, 0.0, 0.01 * np.eye(2)), Bearing(-50.0, 9.0, 0.01 * np.eye(2))]
    >>> triangulate(bearings, poses)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.tracking.errors.RaysApart: the rays of camera 1, camera 2 do not meet: ...

    """

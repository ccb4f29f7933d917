"""What to do with a measurement whose stamp is from before all that is remembered."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.tracking.errors import StampJump


def update_or_restart(
    update: Callable[[], object], restart: Callable[[StampJump], object]
) -> None:
    """
    Take a measurement; where the stamps jumped back, restart and take it as the first one.

    Parameters
    ----------
    update : callable
        Takes the measurement: `Tracker.update`, `PlatformRates.push` or `PanTiltAngles.push`
        with its arguments.
    restart : callable
        Resets what takes it, and tells whom it concerns; it is given the jump.

    Raises
    ------
    TrackingError
        If the measurement is refused, before or after the restart.

    Examples
    --------
    The clock was set back: the tracker begins anew with the first bearing after that:

    >>> import numpy as np
    >>> from blob_tracker.tracking import Tracker
    >>> from blob_tracker.types import Bearing
    >>> tracker, log = Tracker(), []
    >>> def restart(jump):
    ...     tracker.reset()
    ...     log.append(jump)
    >>> for stamp_ns in (60_000_000_000, 0):
    ...     bearing = Bearing(0.0, 0.0, np.eye(2), stamp_ns)
    ...     update_or_restart(lambda: tracker.update(bearing), restart)
    >>> len(log), tracker.begun, tracker.stamp_ns
    (1, 2, 0)

    """
    try:
        update()
    except StampJump as jump:
        restart(jump)
        update()

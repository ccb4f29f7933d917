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

    """
    try:
        update()
    except StampJump as jump:
        restart(jump)
        update()

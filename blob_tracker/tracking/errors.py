"""What the room refuses, and says why."""

from __future__ import annotations

# ns, 146 years: ROS time ends before, and differences of stamps fit 64 bits.
FARTHEST = 2**62


class TrackingError(ValueError):
    """A bearing, rate or joint angle that cannot be used; the message says why."""


class StampJump(TrackingError):
    """A stamp from before all that is remembered: the clock was set back, `reset` is due."""


class PlatformGap(LookupError):
    """An instant at which the platform's motion, or the pan/tilt's place, is not known."""


def check_stamp(stamp_ns: int) -> None:
    """Raise TrackingError where a stamp is none of ROS time."""
    if not -FARTHEST <= stamp_ns <= FARTHEST:
        raise TrackingError(
            f'the stamp is {stamp_ns} ns; it must be within 146 years of 0 (is it in ns?)'
        )

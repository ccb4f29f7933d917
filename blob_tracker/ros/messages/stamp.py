"""ROS time stamps as integers of nanoseconds, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # those of a bag are read where no ROS is installed, too
    from builtin_interfaces.msg import Time

SECOND_NS = 1_000_000_000  # ns


def to_ns(stamp: Time) -> int:
    """Return the stamp in ns."""
    return int(stamp.sec) * SECOND_NS + int(stamp.nanosec)


def from_ns(stamp_ns: int) -> Time:
    """Return the message of a stamp in ns."""
    from builtin_interfaces.msg import Time

    sec, nanosec = divmod(stamp_ns, SECOND_NS)
    return Time(sec=sec, nanosec=nanosec)

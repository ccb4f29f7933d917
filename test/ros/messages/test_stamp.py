"""Stamps to nanoseconds and back, without a rounding."""

from blob_tracker.ros.messages.stamp import from_ns, to_ns


def test_round_trip() -> None:
    """A time of today keeps its last nanosecond; one before 1970 counts its part upwards."""
    for stamp_ns in (0, 999_999_999, 1_700_000_000_123_456_789, -1):
        assert to_ns(from_ns(stamp_ns)) == stamp_ns

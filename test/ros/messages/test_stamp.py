"""Stamps to nanoseconds and back, without a rounding."""

from blob_tracker.ros.messages.stamp import fill_ns, from_ns, to_ns


def test_round_trip() -> None:
    """A time of today keeps its last nanosecond."""
    for stamp_ns in (0, 999_999_999, 1_700_000_000_123_456_789):
        assert to_ns(from_ns(stamp_ns)) == stamp_ns


def test_a_stamp_that_is_filled_again_is_the_new_one() -> None:
    """Also one before 1970, whose part of a second counts upwards."""
    stamp = from_ns(5_999_999_999)
    for ns in (1_700_000_000_123_456_789, -1):
        fill_ns(stamp, ns)
        assert stamp == from_ns(ns)

"""The pixels that two windows of a light share, and where it is in them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from blob_tracker.location.unlit_window import (
    ComparedWindows, LONGEST_NS, shared, UnlitWindow,
)
from blob_tracker.types import Location, Window
import numpy as np
import pytest

NUMBERS = np.arange(60.0).reshape(6, 10)
WINDOW = Window(NUMBERS, NUMBERS, 20, 30, 10**9)
LOCATION = Location(24.0, 33.5, np.eye(2), 100.0, 10.0, 1.5, 50.0, 1.0, 0, stamp_ns=10**9)


def seen(x0: int, y0: int, x: float, y: float) -> UnlitWindow:
    """Return a window that begins there, with its light."""
    return UnlitWindow.of(replace(WINDOW, x0=x0, y0=y0), replace(LOCATION, x=x, y=y))


def test_pixels_of_the_same_place_are_shared() -> None:
    """Pixel (j, i) of the one is that of the other, and the circles are counted from the first."""
    first, second, one, other = shared(
        seen(20, 30, 24.0, 33.5), seen(22, 31, 26.0, 34.0), reach=2.0, least=2) or ()
    np.testing.assert_array_equal(first, NUMBERS[1:, 2:])
    np.testing.assert_array_equal(second, NUMBERS[:5, :8])
    assert one == (2.0, 2.5, 3.0)
    assert other == (4.0, 3.0, 3.0)


def test_no_more_is_taken_than_is_asked_for() -> None:
    """From the upper left; nothing if the sides are too short."""
    both = seen(20, 30, 24.0, 33.5), seen(20, 30, 24.0, 33.5)
    first, *_ = shared(*both, reach=2.0, least=4, most=4) or ()
    np.testing.assert_array_equal(first, NUMBERS[:4, :4])
    assert shared(*both, reach=2.0, least=7) is None
    assert shared(both[0], seen(31, 30, 34.0, 33.5), reach=2.0, least=2) is None


@pytest.mark.parametrize('change, follows', [
    ({'stamp_ns': 1}, True), ({'stamp_ns': LONGEST_NS + 1}, False), ({'looks': 2}, False),
    ({'binning': (2, 2)}, False), ({'stamp_ns': 0}, False),
])
def test_what_may_be_compared(change: dict[str, Any], follows: bool) -> None:
    """A second apart at most, later, and seen alike."""
    before = seen(20, 30, 24.0, 33.5)._replace(stamp_ns=0)
    assert before._replace(**{'stamp_ns': 1, **change}).follows(before) is follows


@pytest.mark.parametrize('rests, handed_out', [(False, range(1, 13)), (True, (4, 8, 12))])
def test_each_is_compared_or_one_in_four(rests: bool, handed_out: range | tuple[int, ...]) -> None:
    """With the one right before it in either case; the first has none."""
    windows = ComparedWindows(4)
    found = {
        number: windows.take(
            replace(WINDOW, stamp_ns=number * 10**7), LOCATION, number, rests=rests)
        for number in range(1, 13)
    }
    assert [number for number, each in found.items() if each is not None] == [*handed_out]
    for number in handed_out:
        before, now = found[number] or ()
        assert now.stamp_ns == number * 10**7
        assert before is None if number == 1 else before.stamp_ns == (number - 1) * 10**7

"""The fields of a picture wait in their order, with their times, until they are too old."""

from __future__ import annotations

import time

from blob_tracker.capture.field_dealer import FieldDealer
from blob_tracker.capture.fields import FieldStream
from blob_tracker.types import Frame
import numpy as np
import pytest

PICTURE = Frame(np.zeros((8, 4), np.uint8), 1000, 255)


@pytest.mark.parametrize(('stamps_end', 'later_ns'), [(False, 0), (True, 20_000_000)])
def test_fields_are_half_a_picture_apart(stamps_end: bool, later_ns: int) -> None:
    """The end of a transfer is that of the second one."""
    dealer = FieldDealer(FieldStream('interlaced_tb', 8), stamps_end=stamps_end)
    assert dealer.first_field_ns(10**9, 50.0) == 10**9 - later_ns
    # A stamp that comes too early keeps the order.
    assert dealer.first_field_ns(10**9, 50.0) == 10**9 - later_ns + 20_000_001
    dealer.deal(PICTURE, 0, 50.0)
    assert [(each.y0, each.stamp_ns) for each in dealer.waiting] == [(0, 1000), (1, 20_001_000)]


def test_whole_pictures_pass_as_they_are() -> None:
    """Whatever the rate is."""
    dealer = FieldDealer(FieldStream('none', 8), stamps_end=True)
    assert dealer.first_field_ns(10**9, 0.0) == 10**9
    dealer.deal(PICTURE, 0, 0.0)
    assert list(dealer.waiting) == [PICTURE]


def test_fields_that_nobody_read_are_passed_over() -> None:
    """Once they are older than the ring is long, where that is known."""
    dealer = FieldDealer(FieldStream('interlaced_bt', 8), stamps_end=False)
    dealer.first_field_ns(time.monotonic_ns() - 500_000_000, 50.0)
    dealer.deal(PICTURE, 0, 50.0)
    dealer.drop_old(0.0)
    dealer.drop_old(10.0)
    assert len(dealer.waiting) == 2 and dealer.passed_over == 0
    dealer.drop_old(0.1)
    assert not dealer.waiting and dealer.passed_over == 2

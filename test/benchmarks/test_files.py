"""The part files: what it reads is what it wrote, by both ways."""

from __future__ import annotations

from pathlib import Path

from benchmarks import files
from benchmarks.files import Row
from benchmarks.report import Report
from benchmarks.targets import judge
import numpy as np
import pytest


@pytest.mark.parametrize('name', files.BAGS)
def test_both_ways_give_the_same_pixels(name: str, tmp_path: Path) -> None:
    """Of each kind of bag."""
    bag = files.write(tmp_path, name, 3)
    ours, by_hand = list(files._ours(bag)), list(files._by_hand(bag))
    assert len(ours) == len(by_hand) == 3
    np.testing.assert_array_equal(ours, by_hand)


def test_a_row_holds_together() -> None:
    """Rates and their ratio are positive; a process never shrinks at its peak."""
    row = files.measure('mcap', 2, 5)
    assert row.rate > 0.0 and row.reference > 0.0 and row.ratio > 0.0
    assert row.memory >= 0.0


def test_the_worst_bag_decides() -> None:
    """The slowest one, and the one that takes most memory."""
    rows = [Row('a', 1000.0, 1000.0, 1.0, 20.0), Row('b', 800.0, 1000.0, 0.8, 1.0)]
    slow, large = judge(Report(files=rows), [])
    assert not slow.met and slow.where == 'b'
    assert not large.met and large.where == 'a'

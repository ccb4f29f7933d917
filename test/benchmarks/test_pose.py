"""The bench of poses: its bound is reached, and its targets can be missed."""

from __future__ import annotations

from dataclasses import replace

from benchmarks import pose
from benchmarks.pose import Case, limits
import numpy as np
import pytest


def test_the_pose_is_at_the_bound() -> None:
    """Within four standard errors of 60 sights of six numbers, on bearings and on frames."""
    for case in (Case(8), Case(8, frames=True)):
        row = pose._row(case, 60, np.random.default_rng(1))
        assert row.ratio == pytest.approx(1.0, abs=4.0 / (2.0 * 360)**0.5)
        assert row.nees == pytest.approx(row.ratio**2, rel=0.05)
        assert (row.refused, row.wrong) == (0, 0)


def test_each_target_can_be_missed() -> None:
    """Of a row that is at the bound, and of others."""
    good = pose.Row(Case(5), 1.0, 1.0, {'SQPnP': 1.1}, 0.0, 0, 0, 0.1, 100)
    assert all(
        figure >= limit if floor else figure <= limit
        for _, limit, figure, floor, _, _ in limits([good])
    )
    for changed in (
        replace(good, ratio=1.1), replace(good, nees=0.8), replace(good, nees=1.2),
        replace(good, wrong=1), replace(good, ms=1.0),
    ):
        missed = [
            figure < limit if floor else figure > limit
            for _, limit, figure, floor, _, _ in limits([changed])
        ]
        assert sum(missed) == 1

"""The bench of triangulation: its bound is reached, and its targets can be missed."""

from __future__ import annotations

from dataclasses import replace

from benchmarks import triangulation
from benchmarks.triangulation import Case, limits, LINEAR, OPENCV
import numpy as np
import pytest


@pytest.mark.parametrize('case', [Case(2), Case(5, poses=True)])
def test_the_position_is_at_the_bound(case: Case) -> None:
    """Within four standard errors of 150 sights of three numbers."""
    row = triangulation._row(case, 150, np.random.default_rng(1))
    assert row.ratio == pytest.approx(1.0, abs=4.0 / (2.0 * 450)**0.5)
    assert row.nees == pytest.approx(row.ratio**2, rel=0.05)
    assert (row.refused, row.wrong) == (0, 0)
    assert row.peers[OPENCV if case.cameras == 2 else LINEAR] > 0.95 * row.ratio


def test_each_target_can_be_missed() -> None:
    """Of a row that is at the bound, and of others."""
    good = triangulation.Row(Case(5), 1.0, 1.0, {LINEAR: 1.1}, 0, 0, 0.1, 100)
    assert all(
        figure >= limit if floor else figure <= limit
        for _, limit, figure, floor, _, _ in limits([good])
    )
    for changed in (
        replace(good, ratio=1.05), replace(good, nees=0.8), replace(good, nees=1.2),
        replace(good, wrong=1), replace(good, peers={LINEAR: 0.9}),
    ):
        missed = [
            figure < limit if floor else figure > limit
            for _, limit, figure, floor, _, _ in limits([changed])
        ]
        assert sum(missed) == 1

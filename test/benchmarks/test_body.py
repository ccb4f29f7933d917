"""The bench of bodies: errors beside what is stated."""

from __future__ import annotations

from benchmarks.body import cases, limits, Row, run


def test_errors_are_those_that_are_stated() -> None:
    """Two draws of each case; NEES of 12 to 18 numbers or more is within a factor of three."""
    ticks: list[str] = []
    rows = run(40, ticks.append)
    assert [row.case for row in rows] == cases()
    assert len(ticks) == len(rows)
    for row in rows:
        assert row.refused == 0
        assert 1.0 / 3.0 < row.nees < 3.0
        assert 0.01 < row.sigma_mm < 0.2


def test_the_targets_are_of_the_worst_case() -> None:
    """The greatest and the least."""
    rows = [Row(case, 0.1, 0.1, nees, 0, 1.0, 2) for case, nees in zip(cases(), (1.3, 1.0, 0.7))]
    assert [(limit, figure) for _, limit, figure, *_ in limits(rows)] == [(1.2, 1.3), (0.8, 0.7)]

"""The situations as a table in a terminal, beside the baseline."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

from benchmarks.world.baseline import Baseline
from benchmarks.world.judge import FOUND, NEES, OVER_BOUND, Row, WRONG
from rich.markup import escape
from rich.table import Table

CAPTION = (
    f'passed: found >= {FOUND:.0%}, wrong <= {WRONG:.1%}, NEES {NEES[0]} to {NEES[1]}, '
    f'rms <= {OVER_BOUND} x bound; or silent: wrong <= {WRONG:.1%} and a reason that names the '
    'cause. wrong: of the bearings, more than 5 of their own sigmas and 0.1 px off'
)
SAID = 48  # characters shown
LARGE = 1e4


def table(rows: Sequence[Row], baseline: Baseline) -> Table:
    """Return a line for each situation."""
    passed = sum(row.passed for row in rows)
    before = [baseline.rows.get((row.kind, row.strength)) for row in rows]
    were = sum(row is not None and row.passed for row in before)
    out = Table(
        title=f'Outside the lab: {passed} of {len(rows)} situations passed; {were} at '
        f'{baseline.commit}',
        caption=CAPTION,
    )
    for name in ('#', 'situation', 'strength'):
        out.add_column(name)
    for name in ('found, %', 'wrong, %', 'rms, px', '/ bound', 'NEES', 'chi2'):
        out.add_column(name, justify='right')
    for name in ('said most', 'verdict', f'{baseline.commit}: found, wrong, NEES', 'verdict'):
        out.add_column(name)
    kind = ''
    for row, was in zip(rows, before, strict=True):
        if row.kind != kind and kind:
            out.add_section()
        out.add_row(
            str(row.number) if row.kind != kind else '', row.kind if row.kind != kind else '',
            row.strength, _percent(row.found), _percent(row.wrong), _number(row.rms, 3),
            _number(row.ratio, 2), _number(row.nees, 2), _number(row.chi2, 1),
            escape(row.said if len(row.said) <= SAID else row.said[:SAID - 1] + '…'),
            _verdict(row),
            '' if was is None else
            f'[dim]{_percent(was.found)}, {_percent(was.wrong)}, {_number(was.nees, 2)}',
            '' if was is None else f'[dim]{was.verdict}',
        )
        kind = row.kind
    return out


def _verdict(row: Row) -> str:
    return f'[green]{row.verdict}' if row.passed else f'[bold red]{row.verdict}'


def _percent(share: float) -> str:
    return '-' if isnan(share) else f'{100.0 * share:.1f}'


def _number(value: float, digits: int) -> str:
    if isnan(value):
        return '-'
    return f'{value:.{digits}f}' if value < LARGE else f'{value:.0e}'

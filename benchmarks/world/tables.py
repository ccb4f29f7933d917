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
    'cause. found: %; wrong: % of the bearings, more than 5 of their own sigmas and 0.1 px off. '
    'Of the other commit: found, wrong, NEES'
)
LARGE = 1e3  # from which on the digits tell nothing
SAID = 25  # characters: that the line stays one line


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
    out.add_column('situation', no_wrap=True)
    for name in ('found', 'wrong', 'rms, px', '/ bound', 'NEES', 'chi2'):
        out.add_column(name, justify='right', no_wrap=True)
    out.add_column('verdict', no_wrap=True)
    out.add_column(baseline.commit, style='dim', no_wrap=True)
    out.add_column('verdict', style='dim', no_wrap=True)
    out.add_column('said most often', no_wrap=True)
    kind = ''
    for row, was in zip(rows, before, strict=True):
        if row.kind != kind:
            out.add_section()
            out.add_row(f'[bold]{row.number:2d}  {escape(row.kind)}')
            kind = row.kind
        out.add_row(
            f'    {escape(row.strength)}', _percent(row.found), _percent(row.wrong),
            _number(row.rms, 3), _number(row.ratio, 2), _number(row.nees, 2),
            _number(row.chi2, 1), _verdict(row), *_cells(was),
            escape(row.said[:SAID]),
        )
    return out


def _cells(was: Row | None) -> tuple[str, str]:
    if was is None:
        return '', ''
    figures = _percent(was.found), _percent(was.wrong), _number(was.nees, 2)
    return '  '.join(figures), was.verdict


def _verdict(row: Row) -> str:
    return f'[green]{row.verdict}' if row.passed else f'[bold red]{row.verdict}'


def _percent(share: float) -> str:
    return '-' if isnan(share) else f'{100.0 * share:.1f}'


def _number(value: float, digits: int) -> str:
    if isnan(value):
        return '-'
    return f'{value:.{digits}f}' if value < LARGE else f'{value:.0e}'

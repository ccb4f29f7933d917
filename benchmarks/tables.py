"""The figures as tables in a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.accuracy import Bias, Row, TARGET
from benchmarks.contender import Contender
from benchmarks.real_pixels import Row as RealRow
from benchmarks.report import Report
from benchmarks.speed import Pace
from benchmarks.targets import Target
import numpy as np
from rich.table import Table

TITLES = {
    'scene': 'rms error / Cramer-Rao bound on the named scenes',
    'snr': 'rms / bound against peak SNR (9x9, sigma 1.5 px)',
    'window': 'rms / bound against window, px (sigma 1.3 px, SNR 50)',
    'sigma': 'rms / bound against sigma, px (window 6 sigma, 7 to 25 px; SNR 50)',
    'axis ratio': 'rms / bound against the ratio of the axes (13x13, sigma 1.8 px, SNR 50)',
    'texture': 'rms / bound of the difference against texture behind the target (SNR 50)',
    'saturation': 'rms / bound of what is left against overexposure (15x15, sigma 2 px)',
}
CAPTION = '(n %): windows without an answer; +-: standard error'
SHOWN_FAILURES = 0.01


def settings(contenders: Sequence[Contender], missing: dict[str, str]) -> Table:
    """Return who takes part, at which setting, and who is missing."""
    table = Table('contender', 'setting', 'share of the windows', title='Contenders')
    for each in contenders:
        table.add_row(each.name, each.setting, f'{each.share:.1%}')
    for package, reason in missing.items():
        table.add_row(f'[bold red]{package}: MISSING', f'[red]{reason}', '')
    return table


def figures(report: Report) -> list[Table]:
    """Return a table for each thing that was measured."""
    tables = [*accuracy(report.accuracy), bias(report.bias)] if report.accuracy else []
    tables += [speed(report.speed)] if report.speed else []
    tables += [real(report.real)] if report.real else []
    return tables


def accuracy(rows: Sequence[Row]) -> list[Table]:
    """Return a table for each sweep: contenders down, values across."""
    tables = []
    for sweep, title in TITLES.items():
        chosen = [row for row in rows if row.sweep == sweep]
        values = list(dict.fromkeys(row.value for row in chosen))
        table = Table(title=title, caption=CAPTION)
        table.add_column('contender', no_wrap=True)
        for value in values:
            table.add_column(value, justify='right')
        for name in dict.fromkeys(row.contender for row in chosen):
            cells = {row.value: _cell(row) for row in chosen if row.contender == name}
            table.add_row(name, *(cells[value] for value in values))
        tables.append(table)
    return [*tables, _target_scenes(rows)]


def bias(biases: Sequence[Bias]) -> Table:
    """Return the greatest mean error over the phase for each scene."""
    scenes = list(dict.fromkeys(each.scene for each in biases))
    table = Table('contender', *scenes, title='Greatest bias against sub-pixel phase, SNR 200, px')
    for name in dict.fromkeys(each.contender for each in biases):
        found = {each.scene: each for each in biases if each.contender == name}
        table.add_row(
            name,
            *(
                f'{np.nanmax(np.abs(each.mean)):.4f} +-{np.nanmax(each.spread):.4f}'
                for each in (found[scene] for scene in scenes)
            ),
        )
    return table


def speed(paces: Sequence[Pace]) -> Table:
    """Return fits a second, ratio to Picasso and microseconds of a single call."""
    scenes = list(dict.fromkeys(pace.scene for pace in paces))
    table = Table('contender', title='Fits a second on one core (x Picasso); one call, us')
    for scene in scenes:
        table.add_column(scene, justify='right')
    for name in dict.fromkeys(pace.contender for pace in paces):
        found = {pace.scene: pace for pace in paces if pace.contender == name}
        table.add_row(name, *(_pace(found[scene]) for scene in scenes))
    return table


def real(rows: Sequence[RealRow]) -> Table:
    """Return residuals on real pixels."""
    table = Table(
        'frames',
        'contender',
        'residual, px',
        'first harmonic of the phase, px',
        'rms bias over the phase, px',
        'kept',
        title='Real pixels: residual to catalogue (3rd order) and grid (7th order)',
    )
    for row in rows:
        table.add_row(
            row.kind,
            row.contender,
            f'{row.rms:.4f}',
            f'{row.harmonic:.4f}',
            f'{row.phase_rms:.4f}',
            f'{row.found} of {row.total}',
        )
    return table


def targets(found: Sequence[Target]) -> Table:
    """Return the targets with 'met' or 'missed by'."""
    table = Table('target', 'asked', 'measured', 'decided by', '', title='Targets')
    for each in found:
        sign = '>=' if each.floor else '<='
        verdict = '[green]met' if each.met else f'[bold red]missed by {_gap(each)}'
        table.add_row(
            each.name,
            f'{sign} {each.limit:,.4g}{each.unit}',
            f'{each.measured:,.4g}{each.unit}',
            each.where,
            verdict,
        )
    return table


def _target_scenes(rows: Sequence[Row]) -> Table:
    """Return worst and median over the target's scenes, and the NEES."""
    chosen = [row for row in rows if row.sweep == TARGET]
    table = Table(
        'contender',
        'median',
        'worst',
        'at',
        'NEES, least to greatest',
        title='rms / bound over windows 7 to 15 px, SNR 10 to 200',
    )
    for name in dict.fromkeys(row.contender for row in chosen):
        mine = sorted((row for row in chosen if row.contender == name), key=lambda row: row.ratio)
        nees = [row.nees for row in mine if row.nees is not None]
        table.add_row(
            name,
            f'{mine[len(mine) // 2].ratio:.3f}',
            f'{mine[-1].ratio:.3f}',
            mine[-1].value,
            f'{min(nees):.3f} to {max(nees):.3f}' if nees else '',
        )
    return table


def _cell(row: Row) -> str:
    text = f'{row.ratio:.3f}' if row.ratio < 100 else f'{row.ratio:.0f}'
    if row.spread > 0.02 * row.ratio:
        text += f' +-{row.spread:.2f}'
    return text if row.failed < SHOWN_FAILURES else f'{text} ({row.failed:.0%})'


def _pace(pace: Pace) -> str:
    ratio = '' if pace.ratio is None else f' ({pace.ratio:.2f}x)'
    return f'{pace.per_second:,.0f}{ratio}; {pace.single * 1e6:,.0f}'


def _gap(target: Target) -> str:
    if target.measured != target.measured:
        return 'no figure'
    return f'{abs(target.measured / target.limit - 1):.1%}'

"""The figures as tables in a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.blink import tables as blink_tables
from benchmarks.contender import Contender
from benchmarks.report import Report
from benchmarks.speed import PAIRED
from benchmarks.tables_of_finding import capture, detection, files, frames, lab, search
from benchmarks.tables_of_locating import (
    accuracy, bearing, bias, body, motion, peers, pose, real, speed, triangulation,
)
from benchmarks.tables_of_running import beside, latency, tracking
from benchmarks.targets import against_peers, Target
from benchmarks.world import baseline, tables as world_tables
from rich.table import Table


def settings(contenders: Sequence[Contender], missing: dict[str, str]) -> Table:
    """Return who takes part, at which setting, and who is missing."""
    table = Table('contender', 'setting', 'share of the windows', title='Contenders')
    for each in contenders:
        table.add_row(each.name, each.setting, f'{each.share:.1%}')
    for package, reason in missing.items():
        table.add_row(f'[bold red]{package}: MISSING', f'[red]{reason}', '')
    return table


def figures(report: Report, ours: Sequence[str]) -> list[Table]:
    """Return a table for each thing that was measured; `ours` names this project's methods."""
    tables = []
    if report.accuracy:
        tables += [*accuracy(report.accuracy), peers(against_peers(report.accuracy, ours))]
        tables += [bias(report.bias), bearing(report.bearing)]
    if report.speed:
        tables += [
            speed([pace for pace in report.speed if pace.scene.endswith(PAIRED) == paired])
            for paired in (False, True)
        ]
    tables += [lab(report.lab)] if report.lab else []
    tables += [real(report.real)] if report.real else []
    tables += [frames(report.frames)] if report.frames else []
    tables += detection(report.detection) if report.detection else []
    tables += [search(report.search)] if report.search else []
    tables += [capture(report.capture)] if report.capture else []
    tables += [motion(report.motion)] if report.motion else []
    tables += tracking(report.tracking) if report.tracking.rows else []
    tables += latency(report.latency) if report.latency.rows else []
    tables += [beside(report.latency.beside)] if report.latency.beside else []
    tables += [world_tables.table(report.world, baseline.read())] if report.world else []
    tables += [blink_tables.table(report.blink)] if report.blink else []
    tables += [files(report.files)] if report.files else []
    tables += [pose(report.pose)] if report.pose else []
    tables += [body(report.body)] if report.body else []
    tables += [triangulation(report.triangulation)] if report.triangulation else []
    return tables


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


def _gap(target: Target) -> str:
    if target.measured != target.measured:
        return 'no figure'
    if not target.limit:
        return f'{target.measured:g}{target.unit}'
    over = abs(target.measured / target.limit - 1)
    return f'{over:.1%}' if over < 10.0 else f'a factor of {over + 1.0:,.0f}'

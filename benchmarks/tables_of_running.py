"""Tables of the nodes and the tracker: delays, memory, and errors of predictions."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan

from benchmarks.latency.figures import Comparison, Figures, HOP, NO_FRAME, SMALL, USUAL
from benchmarks.tracking import Figures as TrackingFigures, HORIZONS, RATE, SIGMA
import numpy as np
from rich.table import Table


def latency(figures: Figures) -> list[Table]:
    """Return the ways of the frames, and what starting and running the nodes takes."""
    ways = Table(
        'way', 'frames', 'Hz', 'median, ms', 'p99, ms', 'p99.9, ms', 'over bare hops: median, p99',
        'lost', 'of one core, %',
        title='From a frame to its bearing in another process',
        caption='medians over the rounds; p99.9 of all of them together; the three hops to a '
        f'bearing, bare, take {_three_hops(figures):.2f} times as long as the two',
    )
    for row in figures.rows:
        size = f'{row.size[0]} x {row.size[1]}' if row.size != NO_FRAME else 'a bearing'
        compared = f'{row.over_hops:.2f}, {row.tails_over_hops:.2f}'
        ways.add_row(
            row.way, size, f'{row.rate:g}',
            f'{1e3 * np.median(row.medians):.2f}', f'{1e3 * np.median(row.tails):.2f}',
            f'{1e3 * row.late:.2f}', '' if isnan(row.over_hops) else compared,
            f'{row.lost} of {row.expected:,}',
            ', '.join(f'{name} {100.0 * share:.0f}' for name, share in row.busy.items()),
        )
    nodes = Table(
        'node', 'memory, MB', 'of it its own, MB', 'growth, MB a minute',
        'garbage collections while frames came', 'the longest, ms', title='The nodes',
        caption='; '.join(
            f'start to first bearing, {start.way}: {np.median(start.seconds):.1f} s'
            for start in figures.starts
        ),
    )
    for each in figures.residents:
        nodes.add_row(
            each.node, f'{each.memory:.0f}', f'{each.own:.0f}', f'{each.growth:.2f}',
            str(each.collections), f'{1e3 * each.pause:.2f}',
        )
    return [ways, nodes]


def _three_hops(figures: Figures) -> float:
    """Return what the hops of frame, window and bearing take over those of frame and window."""
    hops = {row.size: float(np.median(row.medians)) for row in figures.rows if row.way == HOP}
    two = hops.get(USUAL, nan) + hops.get(SMALL, nan)
    return (two + hops.get(NO_FRAME, nan)) / two


def beside(figures: Sequence[Comparison]) -> Table:
    """Return what this source tree takes, what another one does, and the ratios."""
    table = Table(
        'figure', 'here', 'beside', 'here over beside',
        title='The nodes beside those of another source tree',
        caption='medians over the rounds, in which both take turns',
    )
    for each in figures:
        table.add_row(
            each.what, f'{each.own:.2f} {each.unit}', f'{each.other:.2f} {each.unit}',
            f'{each.ratio:.2f}',
        )
    return table


def tracking(figures: TrackingFigures) -> list[Table]:
    """Return the errors of the predictions on each vehicle, and what a bearing costs."""
    errors = Table(
        'vehicle', 'prediction', 'process noise', *(f'{1e3 * each:.0f} ms' for each in HORIZONS),
        'NEES', 'NIS', 'autocorrelation (95 % bound)',
        title=f'rms error of the predicted bearing, mrad; {RATE:g} bearings a second of '
        f'{SIGMA:g} mrad',
        caption='limit: the filter that knows the motion; NEES and NIS over their degrees of '
        'freedom; autocorrelation: the largest of the innovations of both axes over 10 lags',
    )
    for row in figures.rows:
        judged = ('', '', '') if isnan(row.nis) else (
            f'{row.nees:.3f}', f'{row.nis:.3f}', f'{row.correlation:.2f} ({row.bound:.2f})'
        )
        errors.add_row(
            row.motion, row.contender, '' if isnan(row.noise) else f'{row.noise:,.0f}',
            *(f'{each:.3f}' for each in row.rms), *judged,
        )
    costs = Table(
        'model', 'update, us', 'with a gyro', 'at, us', 'filterpy predict + update, us',
        'update over filterpy', title='What a bearing costs, one core',
        caption='' if not isnan(figures.costs[0].reference) else 'filterpy is not importable',
    )
    for cost in figures.costs:
        costs.add_row(
            cost.model, f'{cost.seconds * 1e6:.1f}', f'{cost.stabilised * 1e6:.1f}',
            f'{cost.answer * 1e6:.1f}', f'{cost.reference * 1e6:.1f}', f'{cost.ratio:.3f}',
        )
    return [errors, costs]

"""Tables of what is measured on windows: errors, bias, bearings, peers and speed."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.accuracy import Bias, Row, TARGET
from benchmarks.bearing import Row as BearingRow
from benchmarks.body import Row as BodyRow
from benchmarks.motion import Row as MotionRow
from benchmarks.pose import Row as PoseRow
from benchmarks.real_pixels import Row as RealRow
from benchmarks.speed import Pace
from benchmarks.targets import Comparison
from benchmarks.triangulation import Row as TriangulationRow
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


def peers(compared: Sequence[Comparison]) -> Table:
    """Return the default method beside each peer."""
    table = Table(
        'maximum_likelihood is',
        'peer',
        'rms over that of the peer',
        title='Beside the peers: the named and the target scenes, the same windows',
        caption='level with: less than 0.5 % and the standard error apart',
    )
    for each in compared:
        table.add_row(each.verdict, each.peer, f'{each.ratio:.4f} +-{each.spread:.4f}')
    return table


def bearing(rows: Sequence[BearingRow]) -> Table:
    """Return NEES and rms of the bearing for each scene."""
    table = Table(
        'scene',
        'NEES',
        'rms, mrad',
        'bearings',
        title='Bearing through a distorting lens, maximum_likelihood: 2 is a true covariance',
    )
    for row in rows:
        spread = 2.0 / row.count**0.5
        table.add_row(
            row.scene, f'{row.nees:.3f} +-{spread:.3f}', f'{row.rms:.4f}', str(row.count)
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
        'NEES',
        'kept',
        title='Real pixels: residual to catalogue (3rd order) and grid (7th order)',
        caption='phase correction and pulse: learned from the other frames, or half, no catalogue',
    )
    for row in rows:
        table.add_row(
            row.kind,
            row.contender,
            f'{row.rms:.4f}',
            f'{row.harmonic:.4f}',
            f'{row.phase_rms:.4f}',
            '' if np.isnan(row.nees) else f'{row.nees:.2f}',
            f'{row.found} of {row.total}',
        )
    return table


def motion(rows: Sequence[MotionRow]) -> Table:
    """Return the errors with the camera still and moving."""
    table = Table(
        'registration',
        'peak SNR',
        'camera still, px',
        'moving, px',
        'moving / still',
        'placed of the lit frames: still, moving',
        title='rms error of the located blob, the camera moving 5 px a frame over strong texture',
    )
    for row in rows:
        table.add_row(
            row.registration,
            f'{row.snr:g}',
            f'{row.still:.4f}',
            f'{row.moving:.4f}',
            f'{row.ratio:.3f} +-{row.ratio * row.spread:.3f}',
            f'{row.found_still}, {row.found_moving} of {row.lit}',
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


def pose(rows: Sequence[PoseRow]) -> Table:
    """Return a line for each case of a body's pose."""
    out = Table(
        'body', 'rms / bound', 'NEES/6', *(f'{name}, rms / bound' for name in rows[0].peers),
        'ambiguous, %', 'refused', 'wrong', 'ms',
        title='Pose of a body with lights: of the sights that leave one pose',
        caption='peers: solvePnP of OpenCV, on the same; wrong: another pose, given as certain',
    )
    for row in rows:
        out.add_row(
            row.case.name, f'{row.ratio:.3f}', f'{row.nees:.3f}',
            *(f'{each:.3g}' for each in row.peers.values()), f'{row.ambiguous:.1f}',
            f'{row.refused}/{row.count}', str(row.wrong), f'{row.ms:.3f}',
        )
    return out


def body(rows: Sequence[BodyRow]) -> Table:
    """Return a line for each case of the places of a body's lights."""
    out = Table(
        'body', 'rms, mm', 'sigma, mm', 'NEES per number', 'refused', 's',
        title='Places of the lights of a body, from turning it before a camera',
        caption='10 s at 20 frames/s, 0.1 mrad, 0.5 m at 2 m; one distance is known to 0.1 mm',
    )
    for row in rows:
        out.add_row(
            row.case.name, f'{row.rms_mm:.4f}', f'{row.sigma_mm:.4f}', f'{row.nees:.3f}',
            f'{row.refused}/{row.count}', f'{row.seconds:.2f}',
        )
    return out


def triangulation(rows: Sequence[TriangulationRow]) -> Table:
    """Return a line for each case of a light's place by several cameras."""
    out = Table(
        'cameras', 'rms / bound', 'NEES/3', 'others, rms / bound', 'refused', 'wrong', 'ms',
        title='Place of a light by several cameras',
        caption='wrong: the position is that of another light, and given all the same',
    )
    for row in rows:
        out.add_row(
            row.case.name, f'{row.ratio:.3f}', f'{row.nees:.3f}',
            ', '.join(f'{name} {each:.3g}' for name, each in row.peers.items()),
            f'{row.refused}/{row.count}', str(row.wrong), f'{row.ms:.3f}',
        )
    return out

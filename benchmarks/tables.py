"""The figures as tables in a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan

from benchmarks.accuracy import Bias, Row, TARGET
from benchmarks.bearing import Row as BearingRow
from benchmarks.capture import Row as CaptureRow
from benchmarks.contender import Contender
from benchmarks.detection import ASKED_SNR, OURS, Row as DetectionRow, share, SNRS
from benchmarks.finders import FINDERS
from benchmarks.lab import Row as LabRow
from benchmarks.latency import Figures, HOP, NO_FRAME, SMALL, USUAL
from benchmarks.motion import Row as MotionRow
from benchmarks.real_frames import Row as FrameRow
from benchmarks.real_pixels import Row as RealRow
from benchmarks.report import Report
from benchmarks.search import Row as SearchRow
from benchmarks.speed import Pace, PAIRED
from benchmarks.targets import against_peers, Comparison, Target
from benchmarks.tracking import Figures as TrackingFigures, HORIZONS, RATE, SIGMA
from benchmarks.world import baseline, tables as world_tables
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
    tables += [world_tables.table(report.world, baseline.read())] if report.world else []
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


def lab(rows: Sequence[LabRow]) -> Table:
    """Return frames a second of the virtual lab."""
    table = Table('scene', 'frames a second', title='The virtual lab on one core')
    for row in rows:
        table.add_row(row.scene, f'{row.per_second:,.0f}')
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


def frames(rows: Sequence[FrameRow]) -> Table:
    """Return what the segmenter finds in whole real frames."""
    table = Table(
        'frames',
        'of',
        'found',
        'others not refused',
        'SNR of the strongest of them',
        'windows, of lines those off it',
        'why no window',
        title='Real frames: the laser line of each pair, the stars above peak SNR 8',
        caption='others: off the line, by its colour; not in the catalogue, most of them stars',
    )
    for row in rows:
        table.add_row(
            row.kind,
            row.name,
            f'{row.found} of {row.total}',
            str(row.others),
            f'{row.strongest_other:.0f}',
            str(row.windows),
            row.reason,
        )
    return table


def detection(rows: Sequence[DetectionRow]) -> list[Table]:
    """Return who is compared, the curve, the scenes at the SNR asked for, and what was false."""
    return [_finders(), _curve(rows), _scenes(rows), _false(rows)]


def search(rows: Sequence[SearchRow]) -> Table:
    """Return microseconds and ratio of each path on each kind of frame."""
    kinds = list(dict.fromkeys((row.size, row.depth) for row in rows))
    table = Table(
        'path',
        *(f'{size}, {depth}' for size, depth in kinds),
        title='One frame, us (x cv2.subtract + cv2.minMaxLoc of the same frames)',
        caption='lost: the whole frame is searched; (n %): lit frames that gave a window',
    )
    one_each = {(row.size, row.depth): row for row in rows}
    reference = [f'{one_each[kind].reference * 1e6:,.0f}' for kind in kinds]
    table.add_row('subtract + minMaxLoc', *reference)
    for path in dict.fromkeys(row.path for row in rows):
        found = {(row.size, row.depth): row for row in rows if row.path == path}
        table.add_row(path, *(_search_cell(found[kind]) for kind in kinds))
    return table


def capture(rows: Sequence[CaptureRow]) -> Table:
    """Return microseconds from the driver's buffer to the reader, and of a copy."""
    table = Table(
        'GREY', 'frame at the reader, us', 'one copy, us', 'ratio',
        title='After DQBUF: decoding, stamp, capture thread to the reader',
    )
    for row in rows:
        table.add_row(
            row.size, f'{row.seconds * 1e6:,.0f}', f'{row.reference * 1e6:,.0f}',
            f'{row.ratio:.2f}',
        )
    return table


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


def _finders() -> Table:
    """Return the others' ways with their settings."""
    table = Table('beside it', 'setting', title='Other ways to find a spot in a whole frame')
    for each in FINDERS:
        table.add_row(each.name, each.setting)
    return table


def _curve(rows: Sequence[DetectionRow]) -> Table:
    table = Table(
        'contender',
        *(f'{snr:g}' for snr in SNRS),
        title='Lit frames found (answers that are not the target), %, against peak SNR',
        caption='all clutter scenes, sigma 1, 2 and 4 px; the others are told which of two frames '
        'is lit, and give the best answer they have',
    )
    for name in dict.fromkeys(row.contender for row in rows):
        mine = [[row for row in rows if (row.contender, row.snr) == (name, snr)] for snr in SNRS]
        table.add_row(name, *map(_detection_cell, mine))
    return table


def _scenes(rows: Sequence[DetectionRow]) -> Table:
    """Return all contenders on each scene at the SNR asked for."""
    names = list(dict.fromkeys(row.contender for row in rows))
    table = Table(
        'scene',
        *names,
        title=f'Lit frames found (answers that are not the target), %, at peak SNR {ASKED_SNR:g}',
    )
    asked = [row for row in rows if row.snr == ASKED_SNR]
    for scene in dict.fromkeys(row.scene for row in asked):
        cells = ([row for row in asked if (row.scene, row.contender) == (scene, n)] for n in names)
        table.add_row(scene, *map(_detection_cell, cells))
    return table


def _false(rows: Sequence[DetectionRow]) -> Table:
    """Return our false windows on each scene."""
    table = Table(
        'scene', 'without a target', 'with a target', title='False windows of blob_tracker'
    )
    ours = [row for row in rows if row.contender == OURS]
    for scene in dict.fromkeys(row.scene for row in ours):
        parts = [
            [row for row in ours if row.scene == scene and isnan(row.snr) == empty]
            for empty in (True, False)
        ]
        table.add_row(scene, *(
            f'{sum(row.false for row in part):,} in {sum(row.frames for row in part):,} frames'
            for part in parts
        ))
    return table


def _detection_cell(rows: Sequence[DetectionRow]) -> str:
    frames = sum(row.frames for row in rows)
    if not frames:
        return ''
    return f'{100 * share(rows):.2f} ({100 * sum(row.false for row in rows) / frames:.1f})'


def _search_cell(row: SearchRow) -> str:
    windows = '' if isnan(row.windows) else f' ({row.windows:.0%})'
    return f'{row.seconds * 1e6:,.0f} ({row.ratio:.2f}x){windows}'


def _gap(target: Target) -> str:
    if target.measured != target.measured:
        return 'no figure'
    if not target.limit:
        return f'{target.measured:g}{target.unit}'
    over = abs(target.measured / target.limit - 1)
    return f'{over:.1%}' if over < 10.0 else f'a factor of {over + 1.0:,.0f}'

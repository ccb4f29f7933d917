"""What the project must reach, and whether this run reached it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isnan
from statistics import geometric_mean

from benchmarks import blink, body, pose, triangulation
from benchmarks.accuracy import Bias, Row, TARGET
from benchmarks.bearing import Row as BearingRow
from benchmarks.capture import Row as CaptureRow
from benchmarks.detection import ASKED_SNR, OURS, Row as DetectionRow, share
from benchmarks.files import Row as FileRow
from benchmarks.lab import DEFAULT, Row as LabRow
from benchmarks.latency.figures import Figures, LARGE, ONE, Row as LatencyRow, THREE, USUAL
from benchmarks.motion import Row as MotionRow
from benchmarks.ours import CHAMPION, DIFFERENCE, LIT_ONLY
from benchmarks.real_frames import LASER, Row as FrameRow, STARS
from benchmarks.report import Report
from benchmarks.search import LOCKED, LOST, Row as SearchRow
from benchmarks.speed import Pace, PAIRED, REFERENCE
from benchmarks.tracking import Cost
from benchmarks.world import Row as WorldRow
import numpy as np
from scipy.stats import norm

# At the bound nobody can be better: no peer may be ahead by more than this and its standard error.
TIE = 0.005
NAMED_RATES = (100e3, 70e3, 50e3)
MANY = 100_000  # frames, in which at most one window may be false


@dataclass(frozen=True)
class Target:
    """
    One target.

    Parameters
    ----------
    name : str
        What is asked.
    limit, measured : float
        The limit and this run's figure.
    floor : bool
        True where the figure must reach the limit, False where it must stay below it.
    unit : str
        Of both.
    where : str
        The scene that decided.

    """

    name: str
    limit: float
    measured: float
    floor: bool = False
    unit: str = ''
    where: str = ''

    @property
    def met(self) -> bool:
        """Whether the figure keeps the limit; NaN does not."""
        if self.floor:
            return self.measured >= self.limit
        return self.measured <= self.limit


@dataclass(frozen=True)
class Comparison:
    """
    The default method beside one peer, on the same windows.

    Parameters
    ----------
    peer : str
        Name.
    ratio : float
        Our rms over the peer's, geometric mean over the scenes.
    spread : float
        Standard error of the ratio's logarithm, for ratios near 1 that of the ratio.

    """

    peer: str
    ratio: float
    spread: float

    @property
    def verdict(self) -> str:
        """Say better, level with or behind: level is within the standard error and TIE."""
        distance = self.ratio - 1.0
        if abs(distance) <= TIE + self.spread:
            return 'level with'
        return 'better than' if distance < 0.0 else 'behind'


def judge(report: Report, ours: Sequence[str]) -> list[Target]:
    """Return the targets that the report decides; `ours` names this project's methods."""
    judged = accuracy_targets(report.accuracy, report.bias, ours) if report.accuracy else []
    judged += [_bearing_target(report.bearing)] if report.bearing else []
    judged += speed_targets(report.speed) if report.speed else []
    judged += [_lab_target(report.lab)] if report.lab else []
    judged += frame_targets(report.frames) if report.frames else []
    judged += detection_targets(report.detection) if report.detection else []
    judged += search_targets(report.search) if report.search else []
    judged += [_motion_target(report.motion)] if report.motion else []
    judged += [_tracking_target(report.tracking.costs)] if report.tracking.costs else []
    judged += [_capture_target(report.capture)] if report.capture else []
    judged += latency_targets(report.latency) if report.latency.rows else []
    judged += [_world_target(report.world)] if report.world else []
    judged += file_targets(report.files) if report.files else []
    if report.blink:
        judged += [Target(*each) for each in blink.limits(report.blink)]
    if report.pose:
        judged += [Target(*each) for each in pose.limits(report.pose)]
    if report.body:
        judged += [Target(*each) for each in body.limits(report.body)]
    if report.triangulation:
        judged += [Target(*each) for each in triangulation.limits(report.triangulation)]
    return judged


def accuracy_targets(
    rows: Sequence[Row], biases: Sequence[Bias], ours: Sequence[str]
) -> list[Target]:
    """Return the targets that the accuracy run decides."""
    champion = [row for row in rows if row.contender == CHAMPION]
    asked = [row for row in champion if row.sweep == TARGET]
    clipped = [row for row in champion if row.sweep == 'saturation']
    return [
        _worst('rms over the bound, windows 7 to 15, SNR 10 to 200', 1.02, asked, _ratio),
        _worst('no answer, windows 7 to 15, SNR 10 to 200', 0.001, asked, lambda row: row.failed),
        _bias_target(biases),
        _nees_target(asked),
        _worst('rms over the bound of what is left, clipped to 8x', 1.3, clipped, _ratio),
        _texture_target(rows),
        _peer_target(rows, ours),
    ]


def speed_targets(paces: Sequence[Pace]) -> list[Target]:
    """Return the targets that the speed run decides."""
    ours = [
        pace for pace in paces if pace.contender == CHAMPION and not pace.scene.endswith(PAIRED)
    ]
    targets = [
        Target(f'fits a second, {pace.scene}', rate, pace.per_second, floor=True, unit='/s')
        for pace, rate in zip(ours, NAMED_RATES)
    ]
    for pace in ours:
        ratio = float('nan') if pace.ratio is None else pace.ratio
        name = f'fits a second over {REFERENCE}'
        targets.append(Target(name, 1.0, ratio, floor=True, where=pace.scene))
    slowest = max(ours, key=lambda pace: pace.single)
    call = slowest.single * 1e6
    targets.append(Target('one locate()', 50.0, call, unit=' us', where=slowest.scene))
    return targets


def frame_targets(rows: Sequence[FrameRow]) -> list[Target]:
    """Return the targets that whole real frames decide."""
    laser = [row for row in rows if row.kind == LASER]
    stars = [row for row in rows if row.kind == STARS]
    return [
        _found_target('line picked, of all pairs', laser),
        Target('windows off the line', 0, sum(row.windows for row in laser)),
        _found_target('stars found above peak SNR 8', stars),
    ]


def _found_target(name: str, rows: Sequence[FrameRow]) -> Target:
    found, total = sum(row.found for row in rows), sum(row.total for row in rows)
    share = 100.0 * found / total if total else float('nan')
    return Target(name, 100.0, share, floor=True, unit=' %', where=f'{found} of {total}')


def detection_targets(rows: Sequence[DetectionRow]) -> list[Target]:
    """Return the targets that the frames of the clutter scenes decide."""
    ours = [row for row in rows if row.contender == OURS]
    asked = [row for row in ours if row.snr == ASKED_SNR]
    worst = min(asked, key=lambda row: share([row]))
    return [
        Target(
            f'lit frames found at peak SNR {ASKED_SNR:g}',
            99.9,
            100.0 * share(asked),
            floor=True,
            unit=' %',
            where=f'{sum(row.lit for row in asked):,} frames; the least, '
            f'{share([worst]):.1%}, on {worst.scene}, sigma {worst.sigma:g} px',
        ),
        _false_target('without a target', [row for row in ours if isnan(row.snr)]),
        _false_target('with a target', [row for row in ours if not isnan(row.snr)]),
    ]


def _lab_target(rows: Sequence[LabRow]) -> Target:
    """Return the target that the drawing of frames decides."""
    (row,) = (row for row in rows if row.scene == DEFAULT)
    return Target(
        'frames of the virtual lab a second', 200.0, row.per_second, floor=True, unit='/s',
        where=row.scene,
    )


def _tracking_target(costs: Sequence[Cost]) -> Target:
    """Return the target that the costs of a bearing decide: with a gyro it is the dearest."""
    worst = max(costs, key=lambda each: each.stabilised)
    return Target(
        'a bearing into the track', 20.0, worst.stabilised * 1e6, unit=' us',
        where=f'{worst.model} with a gyro; without {worst.seconds * 1e6:.1f} us, '
        f'{worst.ratio:.2f} of filterpy',
    )


def _capture_target(rows: Sequence[CaptureRow]) -> Target:
    """Return the target that the way of a frame to its reader decides."""
    (row,) = (row for row in rows if row.size == '640 x 480')
    return Target(
        "a frame from the driver's buffer to the reader",
        300.0,
        row.seconds * 1e6,
        unit=' us',
        where=row.size,
    )


def file_targets(rows: Sequence[FileRow]) -> list[Target]:
    """Return the targets that reading bags decides."""
    slowest, largest = min(rows, key=lambda row: row.ratio), max(rows, key=lambda row: row.memory)
    return [
        Target('images from a bag, of what the libraries give by hand', 0.9, slowest.ratio,
               floor=True, where=slowest.bag),
        Target('a process that reads a bag grows by', 10.0, largest.memory, unit=' MB',
               where=largest.bag),
    ]


def latency_targets(figures: Figures) -> list[Target]:
    """Return the targets that the ways of the frames, the start and the memory decide."""
    rows = {(row.way, row.size, row.rate): row for row in figures.rows}
    three, one = rows[THREE, USUAL, 60.0], rows[ONE, USUAL, 60.0]
    largest = max(figures.residents, key=lambda each: each.own)
    targets = [
        Target('publish to bearing, three processes, over two bare hops', 1.4, three.over_hops,
               where=f'median, {_ms(three.medians)}'),
        Target('the same at the 99th percentile', 2.0, three.tails_over_hops,
               where=_ms(three.tails)),
        Target('frame in hand to bearing elsewhere, one process, over one bare hop', 1.4,
               one.over_hops, where=f'median, {_ms(one.medians)}'),
        *(_loss_target(row) for row in figures.rows if row.way in (THREE, ONE)),
        _busy_target(rows[ONE, USUAL, 500.0], 60.0),
        _busy_target(rows[ONE, LARGE, 60.0], 30.0),
        Target('memory of a node, without the files that all nodes share', 200.0, largest.own,
               unit=' MB', where=f'{largest.node}, {largest.memory:.0f} MB with them'),
    ]
    for start in figures.starts:
        targets.append(Target('start to first bearing', 3.0, float(np.median(start.seconds)),
                              unit=' s', where=start.way))
    return targets


def _loss_target(row: LatencyRow) -> Target:
    return Target(
        f'bearings lost, {row.way}, {row.size[0]} x {row.size[1]} at {row.rate:g} Hz', 0, row.lost,
        where=f'of {row.expected:,}',
    )


def _busy_target(row: LatencyRow, limit: float) -> Target:
    return Target(
        f'{row.way}, {row.size[0]} x {row.size[1]} at {row.rate:g} Hz, of one core', limit,
        100.0 * sum(row.busy.values()), unit=' %',
    )


def _ms(seconds: Sequence[float]) -> str:
    return f'{1e3 * float(np.median(seconds)):.2f} ms'


def search_targets(rows: Sequence[SearchRow]) -> list[Target]:
    """
    Return the targets that the timing of whole frames decides.

    A frame in which the target appears is measured, confirmed and cut besides: it is in the
    tables, and has no target.
    """
    whole = max(
        (row for row in rows if row.path == LOST),
        key=lambda row: row.ratio,
    )
    locked = max((row for row in rows if row.path == LOCKED), key=lambda row: row.seconds)
    return [
        Target(
            'whole-frame search over subtract + minMaxLoc',
            3.0,
            whole.ratio,
            where=f'{whole.size}, {whole.depth}',
        ),
        Target(
            'a frame while locked',
            60.0,
            locked.seconds * 1e6,
            unit=' us',
            where=f'{locked.size}, {locked.depth}',
        ),
    ]


def _false_target(name: str, rows: Sequence[DetectionRow]) -> Target:
    frames, false = sum(row.frames for row in rows), sum(row.false for row in rows)
    worst = max(rows, key=lambda row: row.false)
    where = f'{false:,} in {frames:,} frames'
    return Target(
        f'false windows in {MANY:,} frames {name}',
        1.0,
        false * MANY / frames,
        where=f'{where}, most on {worst.scene}' if false else where,
    )


def _motion_target(rows: Sequence[MotionRow]) -> Target:
    worst = max(rows, key=lambda row: inf if isnan(row.ratio) else row.ratio)
    return Target(
        'rms with the camera moving 5 px a frame over that of the still one',
        1.2,
        worst.ratio,
        where=f'{worst.registration}, SNR {worst.snr:g}, +-{worst.spread * worst.ratio:.2f}',
    )


def _world_target(rows: Sequence[WorldRow]) -> Target:
    """Return how many situations outside the lab are found as they should be, or named."""
    faults = [row for row in rows if not row.passed]
    first = f'; the first fault: {faults[0].kind}, {faults[0].strength}' if faults else ''
    return Target(
        'situations outside the lab passed', len(rows), len(rows) - len(faults), floor=True,
        where=f'{sum(row.verdict == "wrong" for row in rows)} give wrong bearings{first}',
    )


def _ratio(row: Row) -> float:
    return row.ratio


def _worst(
    name: str, limit: float, rows: Sequence[Row], figure: Callable[[Row], float]
) -> Target:
    """Return the target that the worst row decides."""
    worst = max(rows, key=figure)
    return Target(name, limit, figure(worst), where=f'{worst.sweep} {worst.value}')


def _bias_target(biases: Sequence[Bias]) -> Target:
    worst, where = max(
        (float(np.abs(bias.mean).max()), bias.scene)
        for bias in biases
        if bias.contender == CHAMPION
    )
    return Target('bias against phase at SNR 200', 0.005, worst, unit=' px', where=where)


def against_peers(rows: Sequence[Row], ours: Sequence[str]) -> list[Comparison]:
    """
    Return how the default method compares with each peer, the closest first.

    The geometric mean over the named and the target's scenes, each on the windows that both
    have located; a single scene of a slow peer is too few windows to tell.
    """
    scenes: dict[str, list[Row]] = {}
    for row in rows:
        if row.sweep in (TARGET, 'scene') and row.contender not in ours and row.champion > 0.0:
            scenes.setdefault(row.contender, []).append(row)
    compared = [
        Comparison(
            peer,
            geometric_mean(row.champion for row in seen),
            float(np.sqrt(sum(row.champion_spread**2 for row in seen))) / len(seen),
        )
        for peer, seen in scenes.items()
    ]
    return sorted(compared, key=lambda each: each.ratio, reverse=True)


def _peer_target(rows: Sequence[Row], ours: Sequence[str]) -> Target:
    """Return our rms over that of the peer that is farthest ahead, or closest behind."""
    name = 'rms over that of any peer, within its standard error + 0.5 %'
    compared = against_peers(rows, ours)
    if not compared:
        return Target(name, 1.0 + TIE, float('nan'), where='no peer to compare with')
    worst = max(compared, key=lambda each: each.ratio - each.spread)
    return Target(name, 1.0 + TIE + worst.spread, worst.ratio, where=worst.peer)


def _bearing_target(rows: Sequence[BearingRow]) -> Target:
    worst = max(rows, key=_nees_score)
    return Target(
        'NEES of the bearing in mrad^2, standard errors from 2',
        _nees_limit(len(rows)),
        _nees_score(worst),
        where=f'{worst.scene}, NEES {worst.nees:.3f}',
    )


def _nees_target(rows: Sequence[Row]) -> Target:
    worst = max(rows, key=_nees_score)
    return Target(
        'NEES of the covariance in px^2, standard errors from 2',
        _nees_limit(len(rows)),
        _nees_score(worst),
        where=f'{worst.value}, NEES {worst.nees:.3f}',
    )


def _nees_limit(scenes: int) -> float:
    """
    Return the greatest distance from 2 of R scenes' NEES, in standard errors of a scene.

    Of R distances, each standard normal if the covariance is true, the greatest stays below
    the z of probability 0.05 / R: the 95 % bounds, taken together (Bonferroni).
    """
    return float(norm.ppf(1 - 0.025 / scenes))


def _nees_score(row: Row | BearingRow) -> float:
    """Return how far a NEES is from 2 in standard errors of the scene, 2 / sqrt(N)."""
    assert row.nees is not None
    return abs(row.nees - 2.0) / (2.0 / row.count**0.5)


def _texture_target(rows: Sequence[Row]) -> Target:
    """Return the worst rms of the choice made per blob over the better of the pure choices."""
    table = {(row.value, row.contender): row.rms for row in rows if row.sweep == 'texture'}
    worst, where = max(
        (rms / min(table[value, LIT_ONLY], table[value, DIFFERENCE]), value)
        for (value, contender), rms in table.items()
        if contender == CHAMPION
    )
    name = 'rms over the better of lit only and difference'
    return Target(name, 1.1, worst, where=f'texture {where}')

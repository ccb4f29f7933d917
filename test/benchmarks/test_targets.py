"""Targets are judged as they are worded, and comparisons know their own noise."""

from __future__ import annotations

from benchmarks.accuracy import compare, nees, Row, TARGET
from benchmarks.bearing import Row as BearingRow
from benchmarks.detection import OURS as OUR_SEGMENTER, Row as DetectionRow
from benchmarks.motion import Row as MotionRow
from benchmarks.report import Report
from benchmarks.search import ACQUIRED, COMPONENTS, LOCKED, LOST, Row as SearchRow
from benchmarks.speed import Pace, PAIRED, REFERENCE
from benchmarks.targets import against_peers, Comparison, judge, speed_targets, Target
import numpy as np
import pytest

OURS = ['maximum_likelihood']


def row(
    contender: str, *, champion: float = 1.0, spread: float = 0.001, value: str = '9x9, snr 50'
) -> Row:
    """Return a row of the target's scenes."""
    return Row(TARGET, value, contender, 0.02, 1.0, 0.01, 0.0, 100, 2.0, champion, spread)


def pace(
    scene: str, rate: float, ratio: float | None = 1.5, contender: str = 'maximum_likelihood',
    single: float = 20e-6,
) -> Pace:
    """Return a pace."""
    return Pace(scene, contender, rate, single, ratio, 100, 3)


@pytest.mark.parametrize(
    ('measured', 'floor', 'met'),
    [
        (1.02, False, True),
        (1.021, False, False),
        (1.02, True, True),
        (1.019, True, False),
        (float('nan'), False, False),
        (float('nan'), True, False),
    ],
)
def test_limits(measured: float, floor: bool, met: bool) -> None:
    """Meet at the limit, miss beyond it, and miss without a figure."""
    assert Target('', 1.02, measured, floor=floor).met is met


def test_speed_targets_judge_lit_windows_alone() -> None:
    """Judge the three rates, their ratio to the peer and the slowest call; not the pairs."""
    scenes = ['7x7', '9x9', '15x15']
    lit = [pace(scene, rate) for scene, rate in zip(scenes, (100e3, 69e3, 50e3))]
    pairs = [pace(scene + PAIRED, 1.0, single=1.0) for scene in scenes]
    other = [pace(scene, 1e6, contender=REFERENCE) for scene in scenes]
    judged = speed_targets([*lit, *pairs, *other])
    assert [target.met for target in judged] == [True, False, True, True, True, True, True]
    alone = speed_targets([pace(scene, 1e6, ratio=None) for scene in scenes])
    assert [target.met for target in alone] == [True, True, True, False, False, False, True]


def test_bearing_target_takes_the_worst_scene() -> None:
    """Miss where one scene's NEES leaves the 95 % bounds of all of them together."""
    # 2 +- 2 / sqrt(10000) = 0.02 a scene; of two scenes one is beyond 2.24 in 20 runs.
    scenes = [BearingRow('a', 2.01, 0.1, 10_000), BearingRow('b', 2.044, 0.1, 10_000)]
    (kept,) = judge(Report(bearing=scenes), OURS)
    assert kept.met and kept.where.startswith('b')
    (missed,) = judge(Report(bearing=[scenes[0], BearingRow('b', 1.95, 0.1, 10_000)]), OURS)
    assert not missed.met


@pytest.mark.parametrize(
    ('ratio', 'verdict'),
    [(0.99, 'better than'), (0.9945, 'level with'), (1.0055, 'level with'), (1.007, 'behind')],
)
def test_verdict(ratio: float, verdict: str) -> None:
    """Say level where the difference is within 0.5 % and the standard error."""
    assert Comparison('', ratio, 0.001).verdict == verdict


def test_peers_are_compared_over_all_scenes() -> None:
    """Take the geometric mean, its standard error, and leave our own methods out."""
    rows = [row('peer', champion=ratio, value=str(ratio)) for ratio in (0.5, 2.0)]
    rows += [row('far', champion=0.1), row('maximum_likelihood')]
    first, second = against_peers(rows, OURS)
    assert (first.peer, second.peer) == ('peer', 'far')
    assert first.ratio == pytest.approx(1.0)
    assert first.spread == pytest.approx(0.001 / np.sqrt(2.0))


def test_standard_error_of_a_comparison() -> None:
    """Hold the scatter of the ratio of two rms that have noise in common."""
    random = np.random.default_rng(8)
    logs, spreads = [], []
    for _ in range(1000):
        shared, own, other = random.standard_normal((3, 200, 2))
        ratio, spread = compare(shared + 0.3 * own, shared + 0.3 * other)
        logs.append(np.log(ratio))
        spreads.append(spread)
    # A standard deviation from 1000 runs is good to 2 %, 200 windows bias it by under 1 %.
    assert np.mean(spreads) == pytest.approx(np.std(logs), rel=0.07)
    assert compare(shared, shared) == (1.0, 0.0)
    assert compare(2.0 * shared, shared) == pytest.approx((2.0, 0.0))
    assert np.isnan(compare(shared[:0], shared[:0])).all()


def test_nees_of_normal_errors() -> None:
    """Have two where the covariance is that of the errors, four where it is half."""
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    errors = np.random.default_rng(9).multivariate_normal([0.0, 0.0], covariance, 20_000)
    stated = np.broadcast_to(covariance, (20_000, 2, 2))
    # Standard error 2 / sqrt(20,000) = 0.014.
    assert nees(errors, stated) == pytest.approx(2.0, abs=0.045)
    assert nees(errors, stated / 2) == pytest.approx(4.0, abs=0.09)


def seen(
    scene: str, found: int, false: int = 0, *, snr: float = 8.0, contender: str = OUR_SEGMENTER
) -> DetectionRow:
    """Return a row of a thousand lit frames, or of a hundred thousand empty ones."""
    if np.isnan(snr):
        return DetectionRow(contender, scene, snr, snr, 0, 0, 100_000, false)
    return DetectionRow(contender, scene, 1.0, snr, 1000, found, 2000, false)


def test_detection_is_judged_at_the_snr_asked_for() -> None:
    """Pool the scenes at SNR 8; the others and the other SNRs do not count."""
    rows = [
        seen('a', 1000), seen('b', 998), seen('b', 0, snr=6.0), seen('a', 0, 9, contender='peer'),
        seen('a', 0, 1, snr=float('nan')),
    ]
    found, empty, aimed = judge(Report(detection=rows), OURS)
    assert found.met and found.measured == pytest.approx(99.9)
    assert 'b, sigma 1' in found.where
    assert empty.met and empty.measured == 1.0
    assert aimed.met and aimed.measured == 0.0
    worse = judge(Report(detection=[*rows, seen('a', 998, 1)]), OURS)
    assert not worse[0].met and not worse[2].met


def test_search_is_judged_by_its_worst() -> None:
    """The greatest ratio without a target, and the longest locked frame, in any depth."""
    rows = [
        SearchRow('640 x 480', 'uint8', LOST, 50e-6, 20e-6, 2.5, 0.0),
        SearchRow('640 x 480', 'uint8', ACQUIRED, 90e-6, 20e-6, 4.5, 1.0),
        SearchRow('640 x 480', 'uint16', LOST, 58e-6, 20e-6, 2.9, 0.0),
        SearchRow('640 x 480', 'uint8', LOCKED, 50e-6, 20e-6, 2.5, 1.0),
        SearchRow('640 x 480', 'uint16', LOCKED, 61e-6, 20e-6, 3.5, 1.0),
        SearchRow('640 x 480', 'uint8', COMPONENTS, 1.0, 20e-6, 100.0, 0.0),
    ]
    whole, locked = judge(Report(search=rows), OURS)
    assert whole.met and whole.measured == 2.9
    assert not locked.met and locked.measured == pytest.approx(61.0)


@pytest.mark.parametrize(('ratio', 'met'), [(1.2, True), (1.21, False), (float('nan'), False)])
def test_motion_is_judged_by_its_worst(ratio: float, met: bool) -> None:
    """A registration under which nothing was placed is the worst."""
    rows = [
        MotionRow('affine', 10.0, 0.1, 0.1, each, 0.02, 100, 100, 100) for each in (1.0, ratio)
    ]
    (target,) = judge(Report(motion=rows), OURS)
    assert target.met is met

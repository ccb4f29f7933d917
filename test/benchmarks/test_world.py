"""The situations show what they say, and are judged by the rule that is printed."""

from collections import Counter
from math import isnan, nan
from pathlib import Path
from typing import Any

from benchmarks import world
from benchmarks.report import Report
from benchmarks.targets import judge as judge_targets
from benchmarks.world import baseline, plots, tables
from benchmarks.world.judge import judge, Row, verdict
from benchmarks.world.play import play, Played
from benchmarks.world.situation import NOISE, Shot, Situation
from benchmarks.world.situations import KINDS, situations
from blob_tracker.kernel import Array
from blob_tracker.types import Window
import numpy as np
import pytest
from rich.console import Console

SEED = 7  # not that of the bench
FRAMES = 8
NUMBERS = 21
# Row 12 has no target; in row 6 no answer is judged in the first frames, the light is hidden.
WITHOUT = (6, 12)
SILENT = Situation(0, 'kind', 'strength', lambda *_: iter(()), 'clipped')


@pytest.mark.parametrize('name', situations())
def test_every_situation_renders(name: str) -> None:
    """8-bit frames of one size, lit ones with a place inside them, the same of the same seed."""
    situation = situations()[name]
    first, second = (
        list(situation.frames(FRAMES, np.random.default_rng(SEED))) for _ in range(2)
    )
    assert len(first) == FRAMES
    assert {shot.image.dtype for shot in first} == {np.dtype(np.uint8)}
    (shape,) = {shot.image.shape for shot in first}
    for shot, again in zip(first, second):
        assert type(shot.on) is bool  # NumPy's own would make counts that JSON does not know
        assert (shot.image == again.image).all()
        if shot.lit:
            assert 20.0 < shot.x < shape[1] - 20.0 and 20.0 < shot.y < shape[0] - 20.0
    assert any(shot.lit for shot in first) or situation.number in WITHOUT
    assert any(not shot.on for shot in first)


@pytest.mark.parametrize('name', situations())
def test_the_model_is_what_is_drawn(name: str) -> None:
    """Expect the pixels of the lit frame, but for noise, and the place in the first parameters."""
    situation = situations()[name]
    for shot in situation.frames(FRAMES, np.random.default_rng(SEED)):
        if not shot.lit or shot.model is None:
            continue
        assert tuple(shot.model.parameters[:2]) == (shot.x, shot.y)
        mean = shot.model.mean(shot.model.parameters)
        mean = mean[0] if mean.ndim == 3 else mean
        assert mean.shape == shot.image.shape
        assert np.isfinite(mean).all()


def test_all_rows_of_the_table_are_there() -> None:
    """Numbers 1 to 21, each kind at three strengths and more, no name twice."""
    every = [each for kind in KINDS for each in kind.SITUATIONS]
    assert len(situations()) == len(every) == world.steps()
    assert {each.number for each in every} == set(range(1, NUMBERS + 1))
    assert min(Counter(each.kind for each in every).values()) >= 3


def test_a_plain_light_is_found_and_judged_well() -> None:
    """Half the gain is within the limits; its figures are those of the bound."""
    row = world.look_at('undersampled, sigma 0.5 px', 40, SEED)
    assert row.lit == 40
    assert row.found >= 0.9
    assert row.wrong == 0.0
    assert 0.7 < row.ratio < 1.3  # 40 flashes: the standard error of an rms is 8 %


def test_what_is_left_of_a_repeated_frame_is_not_asked_twice() -> None:
    """A copy of a lit frame is no lit frame, and its place is known."""
    shots = list(situations()['frames that come twice, newly stamped, every 5th'].frames(
        24, np.random.default_rng(SEED)
    ))
    same = [
        (one, two) for one, two in zip(shots, shots[1:]) if one.image is two.image
    ]
    assert len(same) == 4
    for one, two in same:
        assert not two.on
        assert (one.x, one.y) == (two.x, two.y) or isnan(one.x)


def played(
    errors: Array, sigma: float = 0.05, lit: int = 100, said: str = ''
) -> Played:
    """Return what a run with these errors would be, of true covariances."""
    errors = np.asarray(errors, dtype=float)
    return Played(
        frames=2 * lit, lit=lit, found=min(len(errors), lit), errors=list(errors),
        covariances=[np.eye(2) * sigma**2] * len(errors), chi2=[1.0] * len(errors),
        bounds=[np.eye(2) * 0.05**2], said=Counter([said] if said else []), words={said: said},
    )


def normal(count: int, sigma: float = 0.05) -> Array:
    """Return errors of a sigma, px."""
    return np.random.default_rng(SEED).normal(0.0, sigma, (count, 2))


def test_true_errors_are_found() -> None:
    """At the bound, NEES 2, both within the noise of 1000 errors."""
    row = judge(SILENT, played(normal(1000), lit=1000))
    assert row.rms == pytest.approx(0.05, rel=0.07)
    assert row.ratio == pytest.approx(1.0, rel=0.07)
    assert row.nees == pytest.approx(2.0, abs=0.2)
    assert (row.found, row.wrong, row.verdict, row.passed) == (1.0, 0.0, 'found', True)
    assert len(row.distances) == 334
    # The root of the mean square of them is 1 where the covariance is true.
    assert np.sqrt(np.mean(np.square(row.distances))) == pytest.approx(1.0, rel=0.15)


@pytest.mark.parametrize(
    ('errors', 'sigma', 'expected'),
    [
        (normal(100, 0.02), 0.02, 'found'),
        (normal(94), 0.05, 'not found'),
        (normal(100), 0.03, 'NEES'),
        (normal(100), 0.07, 'NEES'),
        (normal(100, 0.08), 0.08, 'rms'),
        (np.vstack([normal(99), [[0.4, 0.0]]]), 0.05, 'wrong'),
        (np.vstack([normal(99), [[nan, nan]]]), 0.05, 'wrong'),
        # Beyond five sigmas, within 0.1 px: not wrong, but the covariance is not true.
        (np.full((100, 2), 0.06), 0.01, 'NEES'),
        (np.empty((0, 2)), 0.05, 'not found'),
    ],
)
def test_what_is_not_right_is_named(errors: Array, sigma: float, expected: str) -> None:
    """The first fault: wrong, too few, a false covariance, too far from the bound."""
    assert judge(SILENT, played(errors, sigma)).verdict == expected


def test_silence_has_to_name_the_cause() -> None:
    """The most frequent sentence decides; a wrong bearing is never excused."""
    said = '12 pixels are clipped'
    assert judge(SILENT, played(normal(10), said=said)).verdict == 'silent'
    assert judge(SILENT, played(normal(10), said='nothing lit up')).verdict == 'not found'
    assert judge(SILENT, played(np.full((10, 2), 1.0), said=said)).verdict == 'wrong'
    # What is right in spite of a warning is found.
    assert judge(SILENT, played(normal(100), said=said)).verdict == 'found'


def test_without_a_target() -> None:
    """Nothing to be found: any bearing in a thousand frames is wrong, silence needs a reason."""
    assert verdict(nan, 0.0, nan, nan, 'the whole scene flashes', 'whole scene') == 'silent'
    assert verdict(nan, 0.0, nan, nan, '', 'whole scene') == 'no reason'
    empty = played(np.full((3, 2), nan), lit=0)
    empty.frames = 100
    row = judge(SILENT, empty)
    assert isnan(row.found)
    assert (row.wrong, row.verdict) == (0.03, 'wrong')


def test_a_pulse_without_a_middle_may_be_off_by_a_constant() -> None:
    """The mean error is taken off where the situation says so."""
    off = played(normal(400) + 0.5, lit=400)
    assert judge(SILENT, off).verdict == 'wrong'
    centred = Situation(0, 'kind', 'strength', SILENT.frames, 'clipped', centred=True)
    assert judge(centred, off).verdict == 'found'


def test_sentences_are_counted_whatever_their_numbers() -> None:
    """And shown with those of the first one."""
    heard = Played()
    for sentence in ('a rise of 20 DN', 'no frame yet', 'a rise of 3.5 DN'):
        heard.hear(sentence)
    ((kind, count),) = heard.said.most_common(1)
    assert (count, heard.words[kind]) == (2, 'a rise of 20 DN')


def test_of_two_places_as_right_the_nearer_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mirror image as bright as the light."""
    image = np.zeros((20, 20), np.uint8)
    window = Window(lit=image, unlit=image)
    monkeypatch.setattr('benchmarks.world.play.FIRST', 0)
    monkeypatch.setattr('benchmarks.world.play.Segmenter.update', lambda *_: window)

    class Found:
        x, y, covariance, chi2, warning = 9.0, 5.0, np.eye(2), 1.0, ''
        stamp_ns = 0

    monkeypatch.setattr('benchmarks.world.play.Locator.locate', lambda *_, **__: Found())
    monkeypatch.setattr('benchmarks.world.play.NoiseCheck.add', lambda *_: None)
    shots = [Shot(image, True, 5.0, 5.0, also=(9.5, 5.0)), Shot(image, True, 5.0, 5.0)]
    situation = Situation(5, 'k', 's', lambda *_: iter(shots), 'x', NOISE)
    errors = np.array(play(situation, 1, SEED).errors)
    np.testing.assert_allclose(errors, [[-0.5, 0.0], [4.0, 0.0]])


def row(
    kind: str = 'glow', strength: str = '20 DN', verdict: str = 'found', **figures: Any
) -> Row:
    """Return a row."""
    values = {'found': 1.0, 'wrong': 0.0, 'rms': 0.02, 'ratio': 1.1, 'nees': 2.1, 'chi2': 1.0}
    values |= figures
    return Row(
        7, kind, strength, 100, 100, **values, said='a, "quoted" reason', verdict=verdict,
        distances=[0.5, 1.0, 9.0],
    )


def test_the_baseline_comes_back_from_its_file(tmp_path: Path) -> None:
    """To five digits, with the commit, NaN and commas."""
    rows = [row(rms=0.0123456), row('dark', ratio=nan, verdict='no reason')]
    baseline.write(tmp_path / 'world.csv', rows, '0123abc')
    read = baseline.read(tmp_path / 'world.csv')
    assert read.commit == '0123abc'
    first, second = read.rows['glow', '20 DN'], read.rows['dark', '20 DN']
    assert first.rms == pytest.approx(0.0123456, rel=1e-4)
    assert (first.said, first.verdict, first.lit) == ('a, "quoted" reason', 'found', 100)
    assert isnan(second.ratio)
    assert not second.passed


def test_the_baseline_has_every_situation() -> None:
    """Of commit 766ebf6, in a full run."""
    kept = baseline.read()
    assert kept.commit == '766ebf6'
    assert set(kept.rows) == {(each.kind, each.strength) for each in situations().values()}
    assert {each.lit for each in kept.rows.values()} & {world.FULL}


def test_the_table_shows_now_and_then(tmp_path: Path) -> None:
    """Both verdicts, and how many pass."""
    then = baseline.Baseline('0123abc', {('glow', '20 DN'): row(verdict='wrong', nees=8e4)})
    console = Console(width=220, record=True, file=(tmp_path / 'out').open('w'))
    console.print(tables.table([row(), row(strength='40 DN', verdict='NEES')], then))
    text = console.export_text()
    assert '1 of 2 situations passed; 0 at 0123abc' in text
    assert '8e+04' in text


def test_the_plots_are_one_a_kind(tmp_path: Path) -> None:
    """With or without bearings, and where the baseline does not know the kind."""
    silent = Row(12, 'flood, dark', '5 DN', 0, 0, nan, 0.0, nan, nan, nan, nan, '', 'no reason')
    then = baseline.Baseline('0123abc', {('glow', '20 DN'): row()})
    drawn = plots.draw(tmp_path / 'world', [row(), row(strength='40 DN'), silent], then)
    assert [path.name for path in drawn] == ['07_glow.png', '12_flood_dark.png']
    assert all(path.stat().st_size > 1000 for path in drawn)


def test_the_target_counts_what_passed() -> None:
    """All of them are asked for, and the first fault is named."""
    (target,) = judge_targets(Report(world=[row(), row(verdict='wrong')]), [])
    assert (target.limit, target.measured, target.met) == (2, 1, False)
    assert '1 give wrong bearings; the first fault: glow' in target.where
    (target,) = judge_targets(Report(world=[row()]), [])
    assert target.met

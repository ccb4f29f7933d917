"""Found is found, false is false, and the sequences are those of the target."""

from __future__ import annotations

from math import isnan

from benchmarks import detection
from benchmarks.clutter import clutter
from benchmarks.detection import contains, Counts, FULL, holds, look_at, OURS, Row, share, Take
from benchmarks.finders import FINDERS
from blob_tracker.simulation import Truth
from blob_tracker.types import Window
import numpy as np
import pytest

WINDOW = Window(lit=np.zeros((7, 9), np.uint8), x0=10, y0=20)


@pytest.mark.parametrize('x, y, inside', [
    (14.0, 23.0, True), (9.6, 19.6, True), (18.4, 26.4, True), (9.4, 23.0, False),
    (14.0, 26.6, False),
])
def test_a_window_contains_what_lies_in_its_pixels(x: float, y: float, inside: bool) -> None:
    """To the outer edges of its outermost pixels."""
    assert contains(WINDOW, Truth(x, y, True)) is inside


def test_a_window_must_be_about_the_target() -> None:
    """Its middle is (14, 23); 2 sigma + 1 px are 3 px of a sigma of 1 px."""
    assert holds(WINDOW, Truth(16.9, 23.0, True), 1.0)
    assert not holds(WINDOW, Truth(17.1, 23.0, True), 1.0)


def test_a_bright_target_is_found_on_a_plain_wall() -> None:
    """In every frame but the first twelve, and nothing else."""
    rows = look_at(Take('plain', 2.0, 30.0, 1000, 44, 5))
    ours = rows[0]
    assert ours.contender == OURS
    assert (ours.lit, ours.found, ours.frames, ours.false) == (16, 16, 32, 0)
    assert {(row.lit, row.frames) for row in rows[1:]} == {(5, 5)}
    assert len(rows) == 1 + len(FINDERS)


def test_without_a_target_every_window_is_false(monkeypatch: pytest.MonkeyPatch) -> None:
    """And nobody else is asked."""
    monkeypatch.setattr('benchmarks.detection.Segmenter.update', lambda *_: WINDOW)
    (row,) = look_at(Take('plain', float('nan'), float('nan'), 0, 24, 0))
    assert (row.lit, row.found, row.frames, row.false) == (0, 0, 12, 12)


def test_a_window_elsewhere_is_false(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a target there are windows that miss it, and windows of the dark frames."""
    monkeypatch.setattr('benchmarks.detection.Segmenter.update', lambda *_: WINDOW)
    row = look_at(Take('plain', 2.0, 30.0, 0, 24, 0))[0]
    assert (row.lit, row.found, row.frames, row.false) == (6, 0, 12, 12)


def test_full_run_is_large_enough() -> None:
    """5,000 lit frames at the SNR asked for, 100,000 without a target, every scene in both."""
    takes = detection.takes(FULL)
    asked = [take for take in takes if take.snr == 8.0]
    assert sum((take.count - detection.FIRST) // 2 for take in asked) >= 5_000
    empty = [take for take in takes if isnan(take.snr)]
    assert sum(take.count - detection.FIRST for take in empty) >= 100_000
    assert {take.scene for take in asked} == {take.scene for take in empty} == set(clutter())
    assert {take.snr for take in takes if not isnan(take.snr)} == {
        2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 50
    }


def test_processes_give_the_rows_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever is first."""
    monkeypatch.setattr(detection, 'takes', lambda counts: [
        Take('plain', 2.0, 30.0, 0, 20, 1), Take('plain', float('nan'), float('nan'), 0, 16, 0)
    ])
    ticks: list[str] = []
    rows = detection.run(Counts(20, 20, 16, 1), ticks.append, workers=1)
    assert [row.frames for row in rows if row.contender == OURS] == [8, 4]
    assert ticks == ['detection plain'] * 2


def test_share_is_that_of_the_frames() -> None:
    """Not that of the rows; NaN of nothing."""
    rows = [
        Row(OURS, 'a', 1.0, 8.0, 90, 90, 180, 0), Row(OURS, 'b', 1.0, 8.0, 10, 0, 20, 0),
    ]
    assert share(rows) == 0.9
    assert isnan(share([]))

"""The bench of blinking lights: frames are those of its truth, and its targets can be missed."""

from __future__ import annotations

from dataclasses import replace

from benchmarks import blink
from benchmarks.blink import Case, cases, limits, Row, tables
from benchmarks.blink.lights import (
    codes, EXPOSURE, lights, patterns, RATE, Sinusoid, truth, Turning,
)
from benchmarks.blink.pixels import BACKGROUND, frame
from benchmarks.blink.play import play
from benchmarks.blink.points import FULL_FLUX
import numpy as np
import pytest


@pytest.mark.parametrize('timing', ['in step', 'free', 'waves'])
def test_frames_hold_the_light_of_the_truth(timing: str) -> None:
    """Flux and centroid of one light, against share and place: to the noise of the pixels."""
    random = np.random.default_rng(1)
    known = patterns(timing, 1)
    light = lights(timing, known, 10.0, False, 2.0, random)[0]
    seen = 0
    for index in range(30):
        true = truth(light, index / RATE)
        if true is None or true.share < 0.3:
            continue
        seen += 1
        x, y = round(true.x), round(true.y)
        part = frame([light], [False], index / RATE, random).astype(float)
        part = part[y - 12:y + 13, x - 12:x + 13] - BACKGROUND
        flux = part.sum()
        # 625 pixels of 1 DN and their rounding
        assert flux == pytest.approx(true.share * FULL_FLUX, abs=4 * 26.0)
        columns = np.arange(x - 12, x + 13)
        assert (part.sum(axis=0) @ columns) / flux == pytest.approx(true.x, abs=4 * 190.0 / flux)
    assert seen > 8


def test_in_step_bits_change_between_the_exposures() -> None:
    """A light in step is on for the whole of an exposure or for none of it."""
    for light in lights('in step', patterns('in step', 3), 0.0, False, 1.0,
                        np.random.default_rng(2)):
        shares = {0.0 if (one := truth(light, k / RATE)) is None else one.share
                  for k in range(20)}
        assert shares == {0.0, 1.0}


def test_paths_are_as_fast_as_they_say() -> None:
    """At the top, px a frame; and they stay in the picture."""
    times = np.arange(0.0, 8.0, 1e-3)
    for path in (Sinusoid(10.0, np.random.default_rng(3)),
                 Turning(10.0, np.random.default_rng(3), 8.0)):
        places = path.at(times)
        speeds = np.hypot(*np.diff(places, axis=0).T) / (1e-3 * RATE)
        assert np.quantile(speeds, 0.99) <= 10.05 and speeds.max() > 8.0
        assert places.min() >= 0.0 and (places < [752.0, 480.0]).all()


def test_codes_differ_in_every_rotation() -> None:
    """By four bits, so that one that is hidden does not make another of it."""
    found = codes(3, 10)
    for first, second in ((0, 1), (0, 2), (1, 2)):
        a = np.array(list(found[first]))
        assert min(
            int((np.roll(list(found[second]), k) != a).sum()) for k in range(10)
        ) >= 4


def test_a_short_play_finds_its_lights() -> None:
    """90 frames of three waves: all found, none wrong, and the tracker's time is told."""
    row = play(Case('waves', speed=5.0), 90, 1)
    assert row.found > 95.0 and row.wrong == 0.0 and row.ms > 0.0
    assert row.peer == 97.0


def test_targets_can_be_missed() -> None:
    """Each is met by good rows, and missed by bad ones."""
    good = [
        Row(case, 100.0, 100.0, 0.0, 0.0, 1.0, 0.02, 8.0, 0.1, float('nan')) for case in cases()
    ]
    bad = [
        replace(row, found=50.0, wrong=5.0, named=5.0, nees=3.0, first=30.0, ms=2.0)
        for row in good
    ]
    assert all((figure >= limit) if floor else (figure <= limit)
               for _, limit, figure, floor, _, _ in limits(good))
    assert sum((figure < limit) if floor else (figure > limit)
               for _, limit, figure, floor, _, _ in limits(bad)) >= 11
    assert tables.table(good).row_count == len(cases()) == blink.steps()
    assert EXPOSURE == 0.5 / RATE

"""What decides about the causes of a quarter of a pixel."""

from __future__ import annotations

from blob_tracker.studies.beyond.causes import (
    CAUSES, CENTROID, LM, SEEDS, STEP, STUDY, TOGETHER_ALL,
)
from blob_tracker.studies.beyond.causes_printed import implied, ratio_of_looks
from blob_tracker.studies.chapter_5.displacements import bound, TARGETS
import numpy as np
import pytest
from support.quick_study import measured

ML = 'maximum likelihood, extended'


def apart(cause: str, locator: str, name: str = 'apart') -> float:
    """Return the rms of a figure over four sequences of the lamp, one look."""
    # Those of the quick run, and two more.
    parts = measured(STUDY, *(
        {'cause': cause, 'target': 'active', 'seeds': seeds} for seeds in ([0, 1], [2, 3])
    ))
    entries = [entry for part in parts for entry in part['found'][f'{locator}|single']]
    assert len(entries) == 4
    return float(np.sqrt(np.mean([entry[name] ** 2 for entry in entries])))


def test_every_cause_is_measured_for_both_targets() -> None:
    """And the sizes that it would take, for the lamp."""
    cases = STUDY.cases(True)
    assert {(case.get('cause'), case.get('target')) for case in cases if 'cause' in case} == {
        (cause, target) for cause in CAUSES for target in TARGETS
    }
    assert STEP == '0.05'
    for quick, count in zip((True, False), SEEDS):
        seeds = [
            seed for case in STUDY.cases(quick)
            if (case.get('cause'), case.get('target')) == (TOGETHER_ALL, 'active')
            for seed in case['seeds']
        ]
        assert seeds == list(range(count))


def test_windows_alone_spoil_the_centroid() -> None:
    """Nothing but rounding: beyond the goal, three Gaussians fifty times better (75 found)."""
    centroid = apart('rounding to 8 bit', CENTROID)
    assert centroid > 0.05
    assert apart('rounding to 8 bit', LM) < centroid / 50


def test_noise_alone_leaves_three_gaussians_near_the_bound() -> None:
    """To 1.3 times of it: one sixth of the 44 errors is sampling, the small window the rest."""
    assert apart('noise 1 DN', LM) < 1.5 * bound(TARGETS['active'], 1)


def test_the_trailing_edge_is_an_offset() -> None:
    """Tens of times what it scatters: it cannot turn steps of 0.05 px into 0.25."""
    assert apart('trailing edge', LM, 'rms') > 0.2
    assert apart('trailing edge', LM) < 0.05


@pytest.mark.parametrize('locator', [LM, ML])
def test_all_defects_together_leave_the_goal(locator: str) -> None:
    """0.05 px rms but for the common offset."""
    assert apart(TOGETHER_ALL, locator) < 0.05


def test_what_the_printed_numbers_imply() -> None:
    """Averaging did not help: the cause stays for all looks of a place; 0.1 px, 0.2 mrad."""
    assert 0.8 < ratio_of_looks() < 1.1
    rows = implied({'passive': 0.0, 'active': 0.0})
    assert len(rows) == 6
    assert rows[-1][3] == pytest.approx(np.sqrt(0.0140 / 2))

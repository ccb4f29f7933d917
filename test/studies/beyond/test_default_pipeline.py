"""The default pipeline on the sequences of chapter 5: the goal is met, the defects removed."""

from __future__ import annotations

from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.studies.beyond.default_pipeline import (
    calibration, limits, shear, STUDY, WAYS,
)
from blob_tracker.studies.chapter_5.displacements import LABORATORY, STEPS
import numpy as np
import pytest
from support.quick_study import measured, quick_findings


def errors(way: str) -> np.ndarray:
    """Return the errors of the single looks of one sequence, px."""
    found = measured(STUDY, {'way': way, 'step': '0.10', 'seed': 0})[0]
    assert len(found['single']) == found['asked single']
    return np.array(found['single'])[:, 1]


def test_without_defects_it_is_at_the_bound() -> None:
    """Of 55 looks: four standard errors above it at most."""
    rms = float(np.sqrt(np.mean(errors('no defects') ** 2)))
    assert rms < limits(1, jitter=False) * (1.0 + 4.0 / np.sqrt(2 * 55))


def test_with_defects_it_is_off_by_the_trailing_edge() -> None:
    """Far beyond the goal, and all but for 0.05 px the same for all."""
    found = errors('with the defects')
    assert abs(found.mean()) > 0.5
    assert found.std() < 0.05


def test_with_defects_removed_the_goal_is_met() -> None:
    """0.05 px rms against the truth but for the jitter's straight line: the thesis had 0.25."""
    assert float(np.sqrt(np.mean(errors('defects removed') ** 2))) < 0.05


def test_what_the_camera_matrix_takes_up_is_said() -> None:
    """The straight line through a drift of 0.25 px is 0.04 px in the middle of the picture."""
    assert shear(LABORATORY.chain, 240.0) == pytest.approx(-0.042, abs=0.001)
    assert shear(AnalogueChain(), 240.0) == 0.0


def test_a_covariance_that_is_not_true_is_reported() -> None:
    """One Gaussian on a lamp of three: the chi2 of the misfit hides in no average."""
    cases = [{'way': way, 'step': step, 'seed': 0} for way in WAYS for step in STEPS]
    checks = quick_findings(STUDY, cases).checks
    unmet = {check.what for check in checks if not check.met}
    assert {'a true covariance, no defects', 'a true covariance, with the defects'} <= unmet


def test_calibration_finds_the_laboratory() -> None:
    """From half a second of an edge: the filter to 2 %, the jitter to a tenth."""
    jitter, edge = calibration(LABORATORY.chain, 0)
    assert LABORATORY.chain.trailing_edge is not None
    assert edge.peaking == pytest.approx(LABORATORY.chain.trailing_edge.peaking, rel=0.02)
    assert jitter.sigma_from_frame_to_frame == pytest.approx(0.05, rel=0.1)
    assert set(WAYS) == {'no defects', 'with the defects', 'defects removed'}

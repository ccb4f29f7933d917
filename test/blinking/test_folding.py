"""Folded at its period, a light changes as often as it does in one."""

from __future__ import annotations

from blob_tracker.blinking.folding import likely_periods
import numpy as np
import pytest


@pytest.mark.parametrize('period', [2.19, 4.38, 6.0, 17.3, 50.0])
def test_the_period_is_among_the_likeliest(period: float) -> None:
    """To a tenth of a frame at the end of the recording, where the phases would part."""
    clock = np.arange(150.0)
    level = ((clock / period + 0.21) % 1.0 < 0.5).astype(float)
    found = likely_periods(clock, level, 24)
    assert len(found) <= 24
    assert np.abs(found / period - 1.0).min() < 0.2 / 150.0


def test_missing_frames_do_not_matter() -> None:
    """What was not seen is not folded."""
    clock = np.delete(np.arange(150.0), slice(40, 60))
    level = ((clock / 7.3) % 1.0 < 0.5).astype(float)
    assert np.abs(likely_periods(clock, level, 24) / 7.3 - 1.0).min() < 0.2 / 150.0


def test_few_frames_have_no_period() -> None:
    """Two periods of two frames each are the least."""
    assert likely_periods(np.arange(3.0), np.array([1.0, 0.0, 1.0]), 24).size == 0

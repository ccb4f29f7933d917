"""Frames that did not come."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.losses import Losses, StampGaps
import numpy as np
import pytest

INTERVAL = 33_333_333  # ns


def test_what_is_missing_is_counted():
    """With stamps that jitter by a fifth of their interval; the rate is known after 15."""
    random = np.random.default_rng(1)
    index = np.delete(np.arange(400), [50, 120, 121, 122, 300])
    stamps = index * INTERVAL + random.uniform(-0.1, 0.1, index.size) * INTERVAL
    gaps = StampGaps()
    missing = [gaps.missing(int(stamp)) for stamp in stamps]
    assert {place: lost for place, lost in enumerate(missing) if lost} == {50: 1, 119: 3, 296: 1}


def test_a_pause_and_a_clock_that_jumps_are_no_loss():
    """Nor is another rate, once it has lasted for eight frames."""
    gaps = StampGaps()
    stamps = np.arange(30) * INTERVAL
    for part in (stamps, stamps + 60 * 10**9, stamps, stamps):
        assert not any(gaps.missing(int(stamp)) for stamp in part)
    counted = [gaps.missing(int(stamp)) for stamp in stamps[-1] + np.arange(1, 30) * 2 * INTERVAL]
    assert counted == [1] * 8 + [0] * 21


@pytest.mark.parametrize(('lost', 'grave'), [([0] * 300, False), ([0] * 298 + [1] * 2, False),
                                             ([0] * 290 + [1] * 10, True)])
def test_a_few_losses_are_no_fault(lost, grave):
    """Two in three hundred are shown; ten are a fault until three hundred have come after them."""
    losses = Losses()
    for each in lost:
        losses.add(each)
    assert (losses.grave, losses.total) == (grave, sum(lost))
    assert losses.share == pytest.approx(sum(lost) / (300 + sum(lost)))
    for _ in range(300):
        losses.add(0)
    assert not losses.grave
    assert losses.total == sum(lost)

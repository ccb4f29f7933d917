"""Predictions are better than the last bearing, and none is better than it can be."""

from __future__ import annotations

from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.studies.beyond.prediction import (
    directions, FILTERS, HELD, HORIZONS, limit, measure, STUDY,
)
from blob_tracker.tracking import PlatformRates, Tracker
from blob_tracker.types import Bearing
import numpy as np
import pytest


@pytest.mark.parametrize('motion', MOTIONS)
def test_a_filter_lies_between_limit_and_the_bearing_held(motion: str) -> None:
    """At 10 and 30 ms; two rides of 4 s have 240 bearings: by chance 20 % below the limit."""
    rides = [measure({'motion': motion, 'seed': seed, 'duration': 4.0}) for seed in (1, 2)]
    for name in ('constant velocity', 'constant acceleration'):
        for place in (0, 1):
            error, held = (
                np.sqrt(np.mean([ride[which]['squares'][place] for ride in rides]))
                for which in (name, HELD)
            )
            assert 0.8 * limit(motion, HORIZONS[place]) < error < held


def test_the_covariance_is_true() -> None:
    """NEES of 300 bearings in a row: their mean is known to 10 %, correlated as they are to 25."""
    for motion in MOTIONS:
        rides = [measure({'motion': motion, 'seed': seed, 'duration': 4.0}) for seed in (3, 4)]
        for name in FILTERS:
            nees = np.concatenate([ride[name]['nees'] for ride in rides])
            assert nees.mean() == pytest.approx(2.0, abs=0.6)


def test_a_light_ahead_goes_left_as_the_vehicle_turns_right() -> None:
    """And nowhere by roll alone."""
    ride = MOTIONS['sea'].ride(5.0, 1)
    times = np.linspace(0.0, 5.0, 50)
    yaw = 1e3 * ride.angles(times)[:, 2]
    # Roll and pitch mix into it in second order: 50 x 26 urad.
    assert np.corrcoef(directions(ride, times)[:, 0], -yaw)[0, 1] > 0.95


def test_no_sample_of_the_gyro_is_used_before_it_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its stamp is its middle: at 200 Hz it is over 2.5 ms later, and the next in 5 more."""
    pushed: list[int] = []
    ages: list[int] = []
    push, update = PlatformRates.push, Tracker.update

    def pushing(self: PlatformRates, stamp_ns: int, *sample: object) -> None:
        pushed.append(stamp_ns)
        push(self, stamp_ns, *sample)  # type: ignore[arg-type]

    def updating(self: Tracker, bearing: Bearing) -> object:
        if self.platform is not None:
            ages.append(bearing.stamp_ns - pushed[-1])
        return update(self, bearing)

    monkeypatch.setattr(PlatformRates, 'push', pushing)
    monkeypatch.setattr(Tracker, 'update', updating)
    measure({'motion': 'sea', 'seed': 1, 'duration': 2.0})
    assert len(ages) == 2 * 57
    assert 2_500_000 - 1 <= min(ages) <= max(ages) < 7_500_000 + 1  # to the rounding of a ns


def test_the_study_concludes() -> None:
    """From one short ride of each motion."""
    cases = [{**case, 'duration': 2.0} for case in STUDY.cases(True) if case['seed'] == 1]
    findings = STUDY.conclude([(case, measure(case)) for case in cases])
    rows = {(row[0], row[1]) for row in findings.tables[0].rows}
    assert len(rows) == len(MOTIONS) * (2 + len(FILTERS))
    assert 'prediction' in findings.figures

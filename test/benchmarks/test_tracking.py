"""The tracker and filterpy's filter are the same filter, and the limit is not beaten."""

from benchmarks import tracking
from benchmarks.report import Report
from benchmarks.targets import judge
from benchmarks.tracking import Cost, Figures, HELD, HORIZONS, LIMIT
from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import MODELS, Tracker
import numpy as np
import pytest

SECONDS = 5.0


@pytest.mark.parametrize('model', list(MODELS))
def test_filterpys_filter_is_ours(model):
    """The same model, noise and prior: on a few degrees of the sphere they differ by little."""
    pytest.importorskip('filterpy', reason='it is not installed: see requirements/test.txt')
    bearings = tracking.bearings_of(MOTIONS['sea'].ride(SECONDS + 1.0, 3), SECONDS, 3)
    tracker = Tracker(model, acceleration=40.0, jerk=400.0, gate_sigma=np.inf, max_sigma=1e6)
    noise = {'constant_velocity': 40.0, 'constant_acceleration': 400.0}[model]
    mine = tracking.ours(tracker, bearings)
    other = tracking.filtered(model, noise, bearings)
    for first, second in zip(mine[5:], other[5:]):
        # At an elevation of 50 mrad an angle of azimuth is 0.1 % less of an arc.
        np.testing.assert_allclose(first.angles, second.angles, atol=0.02)
        np.testing.assert_allclose(first.covariance, second.covariance, rtol=0.02, atol=1e-5)
        np.testing.assert_allclose(first.innovation, second.innovation, atol=0.05)


@pytest.mark.parametrize('motion', list(MOTIONS))
def test_prediction_is_between_the_limit_and_the_last_bearing(motion):
    """At the horizons at which the process is linear; the limit is an average over all rides."""
    rows = {row.contender: row for row in tracking.ride_rows(motion, SECONDS + 5.0)}
    for model in MODELS:
        limit, mine, held = (rows[each].rms for each in (LIMIT, model, HELD))
        assert len(mine) == len(HORIZONS)
        for index in range(2):
            assert 0.8 * limit[index] < mine[index] < 0.8 * held[index]
    assert rows['constant_velocity and gyro'].nees == pytest.approx(1.0, abs=0.35)


@pytest.mark.parametrize(('dearest', 'met'), [(19e-6, True), (21e-6, False)])
def test_the_target_is_the_dearest_update(dearest, met):
    """Whatever filterpy takes, or where it is missing."""
    costs = [Cost('one', 10e-6, 8e-6, 12e-6, float('nan')),
             Cost('two', 10e-6, 8e-6, dearest, 100e-6)]
    target, = judge(Report(tracking=Figures((), costs)), [])
    assert target.met is met
    assert target.where.startswith('two')

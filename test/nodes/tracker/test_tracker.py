"""The tracker as a real process in simulated time: beside the filter in Python, and fed ill."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan, pi
import time

from blob_tracker.nodes.tracker import TrackerNode
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.ros.endpoints.qos import STATE
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.track import to_track
from blob_tracker.tracking import Tracker
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
import pytest
import rclpy
from rclpy.clock import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.time import Time
from std_msgs.msg import Bool
from support.played_bearings import (
    COAST, FRAME, LATENCY, MAX_SIGMA, MS, path, playing, ROUNDING, SIGMA,
)
from support.processes import probe, start
from support.slowness import slowness


def test_predictions_and_tracks_are_those_of_the_filter(domain: int) -> None:
    """With each bearing, for its instant: angles, rates and covariances of the Python Tracker."""
    tracker = Tracker(max_sigma=MAX_SIGMA)
    delay = 60 * MS
    with playing(domain, servo_delay=0.06, prediction_rate=0.0) as played:
        for _ in range(30):
            played.tick(FRAME)
            played.compare(played.message(*path(played.now_ns - LATENCY)), tracker, delay)
        prediction = played.predictions[0]
        stamp_ns = played.now_ns + delay
        assert prediction.header.frame_id == 'optical'
        assert played.tracks[-1].child_frame_id == 'target'
        # The target goes on meanwhile: it is where the prediction was, to what 60 ms add.
        assert prediction.vector.x == pytest.approx(path(stamp_ns)[0], abs=2.0)


def test_the_timer_predicts_until_the_loss_rule_says_silence(domain: int) -> None:
    """By the clock of the stamps; target/tracked says so, also to who comes late."""
    tracker = Tracker(max_sigma=100.0)
    with playing(domain, prediction_rate=50.0, max_sigma=100.0) as played:
        for _ in range(10):
            played.tick(FRAME)
            message = played.message(*path(played.now_ns - LATENCY))
            played.take(message)
            tracker.update(to_bearing(message))
        played.expect_tracked(tracked=True)
        played.predictions.clear()
        played.tick(2 * COAST)
        played.expect_tracked(tracked=False)
        late = played.node.record(Bool, 'target/tracked', STATE)
        played.node.spin_until(lambda: late)
        assert late[-1].data is False
        stamps = [to_ns(each.header.stamp) for each in played.predictions]
        last_ns = to_ns(message.header.stamp)
        assert max(stamps) <= last_ns + COAST
        # 480 ms at 50 Hz; a tick of the clock may get lost, and the timer waits for the next.
        assert 10 <= len(stamps) <= 25
        for each, stamp_ns in zip(played.predictions, stamps):
            assert each.vector.x == pytest.approx(tracker.at(stamp_ns).azimuth, abs=ROUNDING)
        played.expect_shown('state', 'lost: the last bear')

        played.follow(3)
        played.node.spin_until(lambda: late[-1].data is True)
        assert late[-1].data is True
        played.node.spin_until(lambda: played.shown('state') in ('tracking', 'coasting'))
        assert float(played.shown('predicted sigma (mrad)')) < 1.0
        played.expect_shown('tracks begun', '2')


def test_a_deviation_that_grows_is_silence_as_well(domain: int) -> None:
    """Without bearings, until max_sigma is reached, long before coast."""
    # 1.4 mrad over a frame, and 7 over a tenth of a second.
    with playing(domain, max_sigma=5.0, coast=10.0) as played:
        played.follow(10)
        played.expect_tracked(tracked=True)
        played.tick(1000 * MS)
        played.expect_tracked(tracked=False)
        played.node.spin_until(lambda: 'max_sigma is 5 mrad' in played.shown('state'))


def test_time_that_stands_still_is_silence(domain: int) -> None:
    """A bag that ends: no time goes by in which anything could be lost, and it is all the same."""
    with playing(domain) as played:
        played.follow(5)
        played.expect_tracked(tracked=False)


def _covariance(value: float) -> Callable[[PoseWithCovarianceStamped], None]:
    def spoil(message: PoseWithCovarianceStamped) -> None:
        message.pose.covariance = [value] * 36

    return spoil


def _beside(value: float) -> Callable[[PoseWithCovarianceStamped], None]:
    def spoil(message: PoseWithCovarianceStamped) -> None:
        message.pose.covariance[3 * 6 + 4] = value

    return spoil


def _turn(**values: float) -> Callable[[PoseWithCovarianceStamped], None]:
    def spoil(message: PoseWithCovarianceStamped) -> None:
        for name, value in values.items():
            setattr(message.pose.pose.orientation, name, value)

    return spoil


def _stamp(message: PoseWithCovarianceStamped) -> None:
    message.header.stamp = from_ns(to_ns(message.header.stamp) - FRAME)


BAD = {
    'covariance of zero': (_covariance(0.0), 'it must be symmetric and positive definite'),
    'covariance of NaN': (_covariance(nan), 'it must be symmetric and positive definite'),
    'covariance of inf': (_covariance(inf), 'it must be symmetric and positive definite'),
    'covariance of 1e308': (_covariance(1e308), 'it must be symmetric and positive'),
    'covariance with 1e200 beside the diagonal': (_beside(1e200), 'it must be symmetric'),
    'turn of NaN': (_turn(w=nan), 'a quaternion must have length 1'),
    'turn of zero': (_turn(w=0.0, x=0.0, y=0.0, z=0.0), 'a quaternion must have length 1'),
    'turn of inf': (_turn(x=inf), 'a quaternion must have length 1'),
    'stamp that comes twice': (_stamp, 'there is a bearing with the stamp'),
}


def test_what_is_no_bearing_is_said_and_nothing_else(domain: int) -> None:
    """Each by its sentence; predictions go on as if it had not come."""
    tracker = Tracker(max_sigma=MAX_SIGMA)
    with playing(domain, prediction_rate=0.0) as played:
        def good() -> None:
            played.tick(FRAME)
            played.compare(played.message(*path(played.now_ns - LATENCY)), tracker)

        for _ in range(5):
            good()
        for name, (spoil, sentence) in BAD.items():
            played.tick(FRAME)
            message = played.message(*path(played.now_ns - LATENCY))
            spoil(message)
            before = len(played.predictions)
            played.diagnostics.clear()
            played.rays.publish(message)
            played.expect(sentence)
            assert len(played.predictions) == before, name
            good()
        assert played.shown('resets') == '0'


def test_a_leap_of_30_degrees_is_followed_once_it_is_sure(domain: int) -> None:
    """Two bearings elsewhere are refused, the third is the target; never anything in between."""
    leap = 30.0 * pi / 180.0 * 1e3  # mrad
    with playing(domain) as played:
        played.follow(10)
        for _ in range(6):
            played.tick(FRAME)
            played.rays.publish(played.message(leap, 0.0))
        played.node.spin_until(lambda: abs(played.predictions[-1].vector.x - leap) < 1.0)
        for each in played.predictions:
            assert min(abs(each.vector.x - leap) / 5.0, abs(each.vector.x) / 70.0) < 1.0
        played.expect_tracked(tracked=True)
        played.expect('standard deviations from where the track expects it')
        played.expect_shown('outside the gate', '2')


def test_stamps_and_clocks_that_jump_back_reset_it(domain: int) -> None:
    """An hour back: a warning, and on from there; an hour ahead and back, once more."""
    with playing(domain) as played:
        played.follow(10)
        # The stamps alone: of another clock, nothing can be said of now.
        played.rays.publish(played.message(0.0, 0.0, age=3600 * 1000 * MS))
        played.expect('s before the newest one; a bearing can be')
        played.expect_tracked(tracked=False)
        played.follow(3)
        assert played.predictions[-1].vector.x == pytest.approx(path(played.now_ns)[0], abs=5.0)
        # The clock as well: a bag that begins again.
        played.now_ns -= 3600 * 1000 * MS
        played.tick(FRAME)
        played.expect('the ROS clock jumped back by 3')
        played.predictions.clear()
        played.follow(10)
        played.tick(100 * MS)
        newest = to_ns(played.predictions[-1].header.stamp)
        assert abs(newest - played.now_ns) < 50 * MS  # and the timer goes on
        assert played.predictions[-1].vector.x == pytest.approx(path(newest)[0], abs=5.0)
        # A stamp of an hour ahead, once: the bearings that follow are its past.
        played.rays.publish(played.message(0.0, 0.0, age=-3600 * 1000 * MS))
        played.node.settle(0.1)
        played.follow(10)
        newest = to_ns(played.predictions[-1].header.stamp)
        assert played.predictions[-1].vector.x == pytest.approx(path(newest)[0], abs=5.0)


class SetClock:
    """The system's clock, for it cannot be set by a test."""

    ros_time_is_active = False

    def __init__(self, now_ns: int) -> None:
        self.now_ns = now_ns

    def now(self) -> Time:
        """Return the time."""
        return Time(nanoseconds=self.now_ns, clock_type=ClockType.ROS_TIME)


@pytest.mark.parametrize('step', [100 * MS, 500 * MS, 900 * MS])
def test_a_step_of_the_system_s_clock_starts_it_afresh(
    step: int, monkeypatch: pytest.MonkeyPatch, domain: int
) -> None:
    """Nobody tells of it, and late bearings are usual: those of before it must not stay."""
    rate = 0.3  # mrad/ms
    rclpy.init(args=[], domain_id=domain)
    node = TrackerNode()
    try:
        clock = SetClock(node.get_clock().now().nanoseconds + 1000 * MS)
        monkeypatch.setattr(node, 'get_clock', lambda: clock)
        spinner = SingleThreadedExecutor()
        spinner.add_node(node)
        begin_ns, stepped = clock.now_ns, 0

        def track() -> float | None:
            """Let a frame's time pass; return how far off the light is said to be now, mrad."""
            clock.now_ns += FRAME
            truth = rate * (clock.now_ns + stepped - begin_ns) / MS
            before = truth - rate * LATENCY / MS
            bearing = Bearing(before, 0.0, SIGMA**2 * np.eye(2), clock.now_ns - LATENCY)
            node.track(Delivery(bearing, 'optical'))
            said = node.seen_at('', clock.now_ns)
            return None if said is None else abs(said.azimuth - truth)

        for _ in range(40):  # longer than the step
            error = track()
        # What two bearings lead to over the latency, five standard deviations.
        assert error is not None and error < 0.5
        spinner.spin_once(1.0)  # the clock before the step is looked at
        until = time.monotonic() + 10.0 * slowness()
        while node._time[1] != clock.now() and time.monotonic() < until:
            spinner.spin_once(0.1)
        clock.now_ns -= step
        stepped = step
        track()  # one comes before it is noticed
        while node._time[1] != clock.now() and time.monotonic() < until:
            spinner.spin_once(0.1)
        assert node._time[1] == clock.now()
        errors = [track() for _ in range(30)]
        assert all(each is None for each in errors[:1])
        assert all(each is None or each < 0.5 for each in errors)
        assert None not in errors[5:]
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


@pytest.mark.parametrize('ratio', [1.0, 3.0])
def test_bearings_that_scatter_more_than_they_say_are_told(ratio: float, domain: int) -> None:
    """The mean normalised innovation squared is 2 times that; far above, it names the cause."""
    random = np.random.default_rng(1)
    said = SIGMA**2 * np.array([[1.0, 0.2], [0.2, 1.5]])
    # A target at rest, and a filter that expects little else.
    with playing(domain, max_innovation=100.0, acceleration=1.0) as played:
        for _ in range(101):
            played.tick(FRAME, FRAME)
            noise = ratio * random.multivariate_normal((0.0, 0.0), said)
            played.take(played.message(300.0 + noise[0], -100.0 + noise[1]))
        played.expect_shown('bearings', '101')
        mean = float(played.shown('innovation squared'))
        if ratio == 1.0:
            assert mean == pytest.approx(2.0, abs=0.6)  # three standard errors of 100
            assert not played.said('innovation')
        else:
            assert 12.0 < mean < 24.0
            played.expect('the mean normalised innovation squared is')
            played.expect('raise acceleration; or the bearings scatter more')


def test_everything_changes_while_it_runs(domain: int) -> None:
    """Another model begins afresh; rate and delay leave the track as it is; all or none."""
    with playing(domain, max_sigma=100.0) as played:
        node = played.node
        played.follow(5)
        assert node.set_parameter('tracker', 'prediction_rate', 0.0).successful
        assert node.set_parameter('tracker', 'servo_delay', 0.25).successful
        node.settle(0.1)
        played.predictions.clear()
        played.tick(200 * MS)
        assert not played.predictions
        played.follow(1)
        assert to_ns(played.predictions[-1].header.stamp) == played.now_ns + 250 * MS
        assert node.set_parameter('tracker', 'prediction_rate', 200.0).successful
        played.predictions.clear()
        played.tick(100 * MS)
        played.node.spin_until(lambda: len(played.predictions) >= 10)
        assert len(played.predictions) <= 21
        played.expect_shown('tracks begun', '1')
        for name, value in (
            ('coast', 2.0), ('max_sigma', 900.0), ('max_innovation', 8.0), ('joints.sigma', 0.5)
        ):
            assert node.set_parameter('tracker', name, value).successful
            played.follow(1)
        played.expect_shown('bearings', '10')
        played.expect_shown('tracks begun', '1')
        played.tick(1000 * MS)
        assert played.tracked[-1].data is True  # twice the coast of before
        assert node.set_parameter('tracker', 'coast', 0.5).successful
        played.expect_tracked(tracked=False)
        assert node.set_parameter('tracker', 'model', 'constant_acceleration').successful
        played.follow(5)
        played.expect_shown('bearings', '5')
        refused = node.set_parameter('tracker', 'lights', 'a b,c__d')
        assert not refused.successful and 'is not a name for a light' in refused.reason
        assert node.set_parameter('tracker', 'joints.pan', 'head').successful
        refused = node.set_parameter('tracker', 'joints.tilt', 'head')
        assert not refused.successful and 'they must be two joints' in refused.reason


def test_each_light_has_its_own_track(domain: int) -> None:
    """target/<name>/ray in, target/<name>/... out; a light that is left out is not tracked."""
    with playing(domain, 'target/port', lights='port,starboard') as played:
        played.follow(5)
        assert played.predictions[-1].vector.x == pytest.approx(path(played.now_ns)[0], abs=5.0)
        assert played.tracks[-1].child_frame_id == 'target_port'
        played.expect_shown('starboard: state', 'lost: no bearing has come')
        assert played.node.set_parameter('tracker', 'lights', 'starboard').successful
        played.expect_tracked(tracked=False)


def test_the_pipeline_tracks_as_a_process_of_its_own_does(domain: int) -> None:
    """The same bearings, handed over in memory and by topic: the same tracks."""
    with (
        probe(domain) as node,
        start(
            'tracker', domain, '-r', '__ns:=/alone', '-r', 'target/ray:=/target/ray', coast=0.3
        ),
        start(
            'pipeline', domain, source='simulator', width=160, height=120, focal_length=200.0,
            coast=0.3,
        ),
    ):
        inside = node.record(Odometry, 'target/track', 1000)
        outside = node.record(Odometry, 'alone/target/track', 1000)
        visible = node.record(Bool, 'target/visible', STATE)
        predictions = node.record(Vector3Stamped, 'target/bearing_predicted', 1000)
        node.spin_until(lambda: len(inside) > 5 and len(outside) > 5)
        # Out and on again: both begin with the same bearing.
        assert node.set_parameter('simulator', 'amplitude', 0.0).successful
        node.spin_until(lambda: visible and visible[-1].data is False)
        node.settle(0.6)
        inside.clear(), outside.clear()
        assert node.set_parameter('simulator', 'amplitude', 150.0).successful
        node.spin_until(lambda: len(inside) > 40 and len(outside) > 40)
        assert predictions
    alone = {to_ns(each.header.stamp): to_track(each) for each in outside}
    together = [(each, alone[each.stamp_ns]) for message in inside
                if (each := to_track(message)).stamp_ns in alone]
    assert len(together) >= 40
    for one, other in together:
        # Through a quaternion and back; what a first rate makes of it is 30 times as large.
        np.testing.assert_allclose(one.state, other.state, rtol=1e-9, atol=1e-7)
        np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-7, atol=1e-12)

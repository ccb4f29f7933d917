"""The tracker as a real process in simulated time: beside the filter in Python, and fed ill."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import atan2, cos, hypot, inf, nan, pi, sin
import time

from blob_tracker.nodes.tracker import TrackerNode
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.ros.endpoints.qos import RESULT, STATE
from blob_tracker.ros.messages.imu import turn_of
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.target import ray_message, to_bearing
from blob_tracker.ros.messages.track import to_track
from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import PanTiltAngles, PlatformRates, Tracker
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
import pytest
import rclpy
from rclpy.clock import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Bool
from support.processes import Probe, probe, Process, start
from support.slowness import slowness

MS = 1_000_000  # ns
FRAME = 33 * MS  # between two bearings
LATENCY = 20 * MS  # from the stamp of a bearing to its arrival
SIGMA = 0.02  # mrad, of the bearings
FIRST = 0.3  # s for what comes of a bearing: nothing, of the first two of a track
COAST, MAX_SIGMA = 500 * MS, 20.0  # mrad; the defaults
# mrad: doubles that go through a quaternion, once each way; angles are up to 1000 mrad.
ROUNDING = 1e-9


def path(stamp_ns: int) -> tuple[float, float]:
    """Return where the target is: a swing of 60 mrad in 4 s, mrad."""
    phase = 2.0 * pi * (stamp_ns % (4000 * MS)) / (4000 * MS)
    return 60.0 * sin(phase), 20.0 * sin(phase + 1.0)


class Played:
    """Bearings, time and a platform that the test plays to a tracker."""

    def __init__(self, node: Probe, process: Process, topic: str) -> None:
        self.node, self.process = node, process
        self.topic = topic
        self.now_ns = 1_700_000_000_000 * MS
        self._clock = node.create_publisher(Clock, '/clock', RESULT)
        self.rays = node.create_publisher(PoseWithCovarianceStamped, f'{topic}/ray', RESULT)
        self.imu = node.create_publisher(Imu, 'imu', RESULT)
        self.joints = node.create_publisher(JointState, 'joint_states', RESULT)
        self.predictions = node.record(Vector3Stamped, f'{topic}/bearing_predicted', 1000)
        self.tracks = node.record(Odometry, f'{topic}/track', 1000)
        self.tracked = node.record(Bool, f'{topic}/tracked', STATE)
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        ours = (self._clock, self.rays)
        node.spin_until(lambda: all(each.get_subscription_count() for each in ours))
        node.spin_until(lambda: node.count_publishers(f'{topic}/bearing_predicted'))
        self.tick(0)
        node.settle(0.3)

    def tick(self, nanoseconds: int, step: int = 5 * MS) -> None:
        """Let time pass in small steps."""
        end_ns = self.now_ns + nanoseconds
        while True:
            self.now_ns = min(self.now_ns + step, end_ns)
            self._clock.publish(Clock(clock=from_ns(self.now_ns)))
            self.node.spin(0.004)
            if self.now_ns >= end_ns:
                return

    def message(
        self, azimuth: float, elevation: float, sigma: float = SIGMA, age: int = LATENCY
    ) -> PoseWithCovarianceStamped:
        """Return the message of a bearing, mrad, of a moment ago."""
        covariance = sigma**2 * np.array([[1.0, 0.2], [0.2, 1.5]])
        bearing = Bearing(azimuth, elevation, covariance, self.now_ns - age)
        return ray_message(bearing, 'optical')

    def take(self, message: PoseWithCovarianceStamped) -> None:
        """Publish a good bearing, and wait for what comes of it, if anything does."""
        count = len(self.tracks)
        self.rays.publish(message)
        until = time.monotonic() + FIRST * slowness()
        while len(self.tracks) == count and time.monotonic() < until:
            self.node.spin(0.005)
        self.node.spin(0.02)  # the prediction follows its track

    def compare(
        self, message: PoseWithCovarianceStamped, tracker: Tracker, ahead: int = 0
    ) -> None:
        """Have both filter a bearing, and expect the same track and prediction so far ahead."""
        self.predictions.clear()
        count = len(self.tracks)
        self.take(message)
        tracker.update(to_bearing(message))
        seen = tracker.seen_at(to_ns(message.header.stamp))
        if seen is None:
            assert len(self.tracks) == count
            assert not self.predictions
            return
        self.node.spin_until(lambda: len(self.tracks) > count)
        self.node.spin(0.02)
        track = to_track(self.tracks[-1])
        assert track.stamp_ns == seen.stamp_ns
        np.testing.assert_allclose(track.state, seen.state, rtol=1e-9, atol=ROUNDING)
        np.testing.assert_allclose(track.angle_covariance, seen.angle_covariance, rtol=1e-9)
        np.testing.assert_allclose(track.rate_covariance, seen.rate_covariance, rtol=1e-9)
        if tracker.at(self.now_ns + ahead) is None:  # it is not sure enough so far ahead
            assert not self.predictions
            return
        assert len(self.predictions) == 1
        prediction = self.predictions[0]
        assert to_ns(prediction.header.stamp) == self.now_ns + ahead
        expected = tracker.at(self.now_ns + ahead)
        assert prediction.vector.x == pytest.approx(expected.azimuth, abs=ROUNDING)
        assert prediction.vector.y == pytest.approx(expected.elevation, abs=ROUNDING)
        assert prediction.vector.z == 0.0

    def follow(self, frames: int) -> None:
        """Publish good bearings of the target on its path."""
        for _ in range(frames):
            self.tick(FRAME)
            self.take(self.message(*path(self.now_ns - LATENCY)))

    def said(self, sentence: str) -> bool:
        """Tell whether a diagnostic has said this."""
        return any(sentence in each.status[0].message for each in self._of_tracker())

    def level(self, sentence: str) -> int:
        """Return the level at which a sentence was said."""
        return max(
            each.status[0].level[0] for each in self._of_tracker()
            if sentence in each.status[0].message
        )

    def shown(self, key: str) -> str:
        """Return a value of the last diagnostic; empty before it says it."""
        for array in self._of_tracker()[-1:]:
            return {each.key: each.value for each in array.status[0].values}.get(key, '')
        return ''

    def expect_shown(self, key: str, value: str) -> None:
        """Wait for a diagnostic with a value that begins like this."""
        self.node.spin_until(lambda: self.shown(key).startswith(value))

    def expect(self, sentence: str) -> None:
        """Wait for a diagnostic that says this."""
        self.node.spin_until(lambda: self.said(sentence))
        assert self.process.running

    def _of_tracker(self) -> list[DiagnosticArray]:
        return [each for each in self.diagnostics if each.status[0].name == '/tracker: tracking']


@contextmanager
def playing(domain: int, topic: str = 'target', **parameters: object) -> Iterator[Played]:
    """Start a tracker in simulated time; it must end well, whatever it was fed."""
    with (
        probe(domain) as node,
        start('tracker', domain, use_sim_time=True, **parameters) as process,
    ):
        yield Played(node, process, topic)
        assert process.running
        assert process.end() == 0
    assert 'Traceback' not in process.output, process.output


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
        assert played.tracked[-1].data is True
        played.predictions.clear()
        played.tick(2 * COAST)
        played.node.spin_until(lambda: played.tracked[-1].data is False)
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
        assert played.tracked[-1].data is True
        played.tick(1000 * MS)
        played.node.spin_until(lambda: played.tracked[-1].data is False)
        played.node.spin_until(lambda: 'max_sigma is 5 mrad' in played.shown('state'))


def test_time_that_stands_still_is_silence(domain: int) -> None:
    """A bag that ends: no time goes by in which anything could be lost, and it is all the same."""
    with playing(domain) as played:
        played.follow(5)
        played.node.spin_until(lambda: played.tracked[-1].data is False)


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
    'turn of NaN': (_turn(w=nan), 'a quaternion must have the length 1'),
    'turn of zero': (_turn(w=0.0, x=0.0, y=0.0, z=0.0), 'a quaternion must have the length 1'),
    'turn of inf': (_turn(x=inf), 'a quaternion must have the length 1'),
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
        assert played.tracked[-1].data is True
        played.expect('standard deviations from where the track expects it')
        played.expect_shown('outside the gate', '2')


def test_stamps_and_clocks_that_jump_back_reset_it(domain: int) -> None:
    """An hour back: a warning, and on from there; an hour ahead and back, once more."""
    with playing(domain) as played:
        played.follow(10)
        # The stamps alone: of another clock, nothing can be said of now.
        played.rays.publish(played.message(0.0, 0.0, age=3600 * 1000 * MS))
        played.expect('s before the newest one; a bearing can be')
        played.node.spin_until(lambda: played.tracked[-1].data is False)
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


def _imu(played: Played, rate: tuple[float, float, float], frame_id: str = 'imu_link') -> Imu:
    message = Imu()
    message.header.stamp, message.header.frame_id = from_ns(played.now_ns), frame_id
    x, y, z = rate
    message.angular_velocity = Vector3(x=x, y=y, z=z)
    return message


def test_the_platform_s_rotation_is_taken_off(domain: int) -> None:
    """The filter that has the same rates, in the base's axes, says the same."""
    rates = PlatformRates()
    tracker = Tracker(platform=rates, max_sigma=MAX_SIGMA)
    turn = turn_of(-0.5 * pi, 0.0, -0.5 * pi)
    with playing(domain, imu__enabled=True, prediction_rate=0.0, servo_delay=0.03) as played:
        played.node.spin_until(played.imu.get_subscription_count)
        for count in range(60):
            played.tick(10 * MS)
            # Forward, left, up: it yaws to the left, and the target goes right.
            rate = 0.02 * sin(0.1 * count), 0.05, 0.3
            message = _imu(played, rate)
            message.angular_velocity_covariance[0] = 1e-8
            played.imu.publish(message)
            rates.push(played.now_ns, turn.T @ np.array(rate), 1e-8)
            played.node.spin(0.01)
            if count % 3 == 2:
                age = 15 * MS
                azimuth = 0.3 * 10.0 * count  # mrad: the platform's 0.3 rad/s
                played.compare(played.message(azimuth, 0.0, age=age), tracker, 30 * MS)
        assert not tracker.platform_gap
        # As the camera sees it.
        assert to_track(played.tracks[-1]).rate[0] == pytest.approx(300.0, abs=10.0)
        played.expect_shown('stabilised', 'yes')


def test_an_imu_that_is_silent_or_wrong_is_named_and_tracked_without(domain: int) -> None:
    """No message, another frame, no gyro, NaN, nonsense, a jump: each sentence, and bearings."""
    with playing(domain, imu__enabled=True) as played:
        played.node.spin_until(played.imu.get_subscription_count)
        played.follow(5)
        played.expect('tracked without the rotation of the platform')
        played.expect('is imu published, with stamps of the clock of the images?')
        no_gyro = _imu(played, (0.0, 0.0, 0.0))
        no_gyro.angular_velocity_covariance[0] = -1.0
        negative = _imu(played, (0.0, 0.0, 0.0))
        negative.angular_velocity_covariance[4] = nan
        for message, sentence in (
            (_imu(played, (0.0, 0.0, 0.0), 'camera'), "the frame_id is 'camera' and imu.frame_id"),
            (no_gyro, 'this IMU measures no angular velocity'),
            (_imu(played, (nan, 0.0, 0.0)), 'it must be 3 numbers within +-100'),
            (_imu(played, (0.0, inf, 0.0)), 'it must be 3 numbers within +-100'),
            (_imu(played, (0.0, 0.0, 573.0)), 'it must be 3 numbers within +-100'),
            (negative, 'the variance of the angular velocity is'),
        ):
            played.imu.publish(message)
            played.expect(sentence)
            played.follow(2)
        played.imu.publish(_imu(played, (0.0, 0.0, 0.0)))
        played.node.settle(0.1)
        played.now_ns -= 10_000 * MS
        played.imu.publish(_imu(played, (0.0, 0.0, 0.0)))
        played.expect('imu: the stamp of the angular velocity is 10.')
        played.now_ns += 10_000 * MS
        played.follow(10)
        assert played.predictions[-1].vector.x == pytest.approx(path(played.now_ns)[0], abs=5.0)


SIDEWAYS = turn_of(0.0, 0.0, 0.5)  # of an IMU that is not mounted as the parameters say


@pytest.mark.parametrize('wrong, words, remedy', [
    (180.0 / pi * np.eye(3), 'its rates are in degrees/s', 'have its driver publish rad/s'),
    (-np.eye(3), 'its rates have the wrong sign', 'about right-handed axes'),
    (SIDEWAYS, 'its axes are off by 29 degrees', 'set imu.roll to -1.571, imu.pitch to'),
    (np.eye(3), '', ''),
])
def test_a_gyro_that_says_other_than_the_picture(
    wrong: np.ndarray, words: str, remedy: str, domain: int
) -> None:
    """It is named and not used, and the prediction goes on; a right one is used."""
    ride = MOTIONS['rover'].ride(9.0, 4)
    turn = turn_of(-0.5 * pi, 0.0, -0.5 * pi)
    errors = []
    with playing(domain, imu__enabled=True, prediction_rate=0.0) as played:
        played.node.spin_until(played.imu.get_subscription_count)
        start_ns = played.now_ns
        for count in range(800):
            played.tick(10 * MS, 10 * MS)
            since = 1e-9 * (played.now_ns - start_ns)
            rate = wrong @ turn @ ride.rates(np.array([since]))[0]
            played.imu.publish(_imu(played, tuple(rate.tolist())))
            if count % 4 == 3:
                x, y, z = ride.rotations(np.array([since]))[0][2]  # of the level frame's z
                seen = 1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z))
                played.rays.publish(played.message(*seen, 0.1, age=0))
                played.node.spin(0.005)
                if count > 700 and played.predictions:
                    # At its own instant: a busy machine may not have taken the last rays yet.
                    prediction = played.predictions[-1]
                    at = 1e-9 * (to_ns(prediction.header.stamp) - start_ns)
                    x, y, z = ride.rotations(np.array([at]))[0][2]
                    errors.append((
                        prediction.vector.x - 1e3 * atan2(x, z),
                        prediction.vector.y - 1e3 * atan2(-y, hypot(x, z)),
                    ))
        assert played.process.running
        # Without the gyro a bearing of 0.1 mrad is what is known of where it is.
        assert len(errors) > 20
        assert np.sqrt(np.mean(np.square(errors))) < 10.0
        if not words:
            assert not played.said('imu: by what the lights do')
            played.expect_shown('stabilised', 'yes')
            return
        played.expect(words)
        played.expect(remedy)
        assert not played.said('is imu published')
        played.expect_shown('stabilised', f'no: {words}')


# The direction of azimuth 500 and elevation 50 mrad.
AT_REST = np.array([sin(0.5) * cos(0.05), -sin(0.05), cos(0.5) * cos(0.05)])


def _joints(played: Played, names: list[str], positions: list[float]) -> JointState:
    message = JointState(name=names, position=positions)
    message.header.stamp = from_ns(played.now_ns)
    return message


def test_with_joints_the_prediction_is_the_angle_to_command(domain: int) -> None:
    """A light at rest in the base, a camera that pans before it: x and y stay where they are."""
    angles = PanTiltAngles(sigma=3e-5)  # the default of joints.sigma
    tracker = Tracker(pan_tilt=angles, max_sigma=MAX_SIGMA)
    with playing(
        domain, joints__pan='pan', joints__tilt='tilt', joints__tilt_reversed=True,
        prediction_rate=0.0,
    ) as played:
        played.node.spin_until(played.joints.get_subscription_count)
        for count in range(40):
            played.tick(20 * MS)
            pan, tilt = 0.4 + 0.01 * count, 0.05
            names = ['wheel', 'tilt', 'pan']
            played.joints.publish(_joints(played, names, [nan, -tilt, pan]))
            angles.push(played.now_ns, pan, tilt)
            played.node.spin(0.01)
            if not count:
                continue  # between two places of the joints it is known where it looks
            x, y, z = angles.at(played.now_ns - 10 * MS).T @ AT_REST
            ray = played.message(
                1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)), age=10 * MS
            )
            played.compare(ray, tracker)
        prediction = played.predictions[0]
        assert prediction.header.frame_id == 'base_optical_frame'
        assert prediction.vector.x == pytest.approx(500.0, abs=0.5)
        assert prediction.vector.y == pytest.approx(50.0, abs=0.5)
        assert played.tracks[-1].header.frame_id == 'optical'
        # As the camera sees it, the light goes left at the rate of the pan.
        assert to_track(played.tracks[-1]).rate[0] == pytest.approx(-500.0, abs=5.0)


def test_without_the_joints_nothing_is_predicted(domain: int) -> None:
    """Nobody knows where the camera looks: an error that says what would be right."""
    with playing(domain, joints__pan='pan', joints__tilt='tilt') as played:
        played.node.spin_until(played.joints.get_subscription_count)

        def bearings(count: int) -> None:
            for _ in range(count):
                played.tick(FRAME)
                played.rays.publish(played.message(*path(played.now_ns - LATENCY)))

        bearings(50)
        played.expect('start the driver of the pan/tilt, or remap joint_states')
        assert played.level('no angle of pan and tilt arrives on joint_states') == 2
        for message, sentence in (
            (_joints(played, ['left', 'right'], [0.0, 0.0]), 'it has left, right: set joints.pan'),
            (_joints(played, ['pan', 'tilt'], [0.0]), "the joint 'tilt' has no position"),
            (_joints(played, ['pan', 'tilt'], [0.0, inf]), 'tilt is inf rad; it must be finite'),
            (_joints(played, ['pan', 'tilt'], [nan, nan]), 'is NaN there: home the pan/tilt'),
        ):
            played.joints.publish(message)
            played.expect(sentence)
            bearings(3)
        assert not played.predictions
        assert all(each.data is False for each in played.tracked)
        for _ in range(30):
            played.tick(FRAME)
            played.joints.publish(_joints(played, ['pan', 'tilt'], [0.1, 0.0]))
            played.rays.publish(played.message(*path(played.now_ns - LATENCY)))
        played.node.spin_until(lambda: played.tracked and played.tracked[-1].data is True)
        assert played.predictions[-1].vector.x == pytest.approx(
            100.0 + path(to_ns(played.predictions[-1].header.stamp))[0], abs=5.0
        )


def _one_a_message(played: Played, name: str, angle: float, stamped: bool = True) -> JointState:
    message = _joints(played, [name], [angle])
    if not stamped:
        message.header.stamp = from_ns(0)
    return message


@pytest.mark.parametrize('stamped', [True, False])
def test_joints_of_several_nodes_one_a_message(stamped: bool, domain: int) -> None:
    """Wheels from another node, NaN until the tilt has homed, and stamps of 0: it points right."""
    with (
        playing(domain, joints__pan='pan', joints__tilt='tilt') as played,
        probe(domain, 'base') as other,
    ):
        wheels = other.create_publisher(JointState, '/joint_states', RESULT)
        played.node.spin_until(played.joints.get_subscription_count)
        other.spin_until(wheels.get_subscription_count)
        for count in range(120):
            played.tick(10 * MS, 10 * MS)
            pan = 0.4 + 0.002 * count
            tilt = nan if count < 30 else 0.05
            wheels.publish(_one_a_message(played, 'left_wheel', 0.1 * count, stamped))
            played.joints.publish(_one_a_message(played, 'pan', pan, stamped))
            played.joints.publish(_one_a_message(played, 'tilt', tilt, stamped))
            played.node.spin(0.01)
            # Between the last two angles, of either joint.
            turned = PanTiltAngles()
            turned.push(0, pan - 0.001, 0.05)
            x, y, z = turned.at(0).T @ AT_REST
            played.rays.publish(
                played.message(1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)), 0.1, age=5 * MS)
            )
            if count < 30:
                assert not played.predictions
        played.node.spin_until(lambda: bool(played.predictions))
        prediction = played.predictions[-1]
        assert prediction.vector.x == pytest.approx(500.0, abs=1.0)
        assert prediction.vector.y == pytest.approx(50.0, abs=1.0)
        played.node.spin_until(lambda: played.shown('state') == 'tracking')
        assert not played.said('publish')
        assert not played.said('set joints')
        if not stamped:
            played.node.spin_until(
                lambda: int(played.shown('joint_states without a stamp') or 0) >= 200
            )


def test_a_joint_that_two_nodes_publish_is_told(domain: int) -> None:
    """By the names of those that publish, of which one must go."""
    with (
        playing(domain, joints__pan='pan', joints__tilt='tilt') as played,
        probe(domain, 'second') as other,
    ):
        again = other.create_publisher(JointState, '/joint_states', RESULT)
        played.node.spin_until(played.joints.get_subscription_count)
        other.spin_until(again.get_subscription_count)
        sentence = "several nodes publish the joint 'pan' on /joint_states"
        for _ in range(300):
            played.tick(10 * MS, 10 * MS)
            played.joints.publish(_joints(played, ['pan', 'tilt'], [0.1, 0.0]))
            played.tick(10 * MS, 10 * MS)
            again.publish(_joints(played, ['pan'], [0.5]))
            if played.said(sentence):
                break
        assert played.said('of /probe, /second/probe let one do so')
        assert not played.said("the joint 'tilt' on")
        assert played.level(sentence) == 1


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
        assert 10 <= len(played.predictions) <= 21
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
        played.node.spin_until(lambda: played.tracked[-1].data is False)
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
        played.node.spin_until(lambda: played.tracked[-1].data is False)


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

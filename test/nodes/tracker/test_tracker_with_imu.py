"""The tracker as a real process that hears of the platform's rotation by an IMU."""

from __future__ import annotations

from math import atan2, hypot, inf, nan, pi, sin

from blob_tracker.ros.messages.imu import turn_of
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.track import to_track
from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import PlatformRates, Tracker
from geometry_msgs.msg import Vector3
import numpy as np
import pytest
from sensor_msgs.msg import Imu
from support.played_bearings import MAX_SIGMA, MS, path, Played, playing


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
            played.node.settle(0.01)
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

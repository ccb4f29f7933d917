"""The pan/tilt's place from its joint angles."""

from __future__ import annotations

from blob_tracker.tracking import PanTiltAngles, PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.joint_angle import UNKNOWN_RATE_RAD_S
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.consistency import of_rays

MS = 1_000_000  # ns


def test_boresight_has_pan_and_tilt_as_its_angles() -> None:
    """Azimuth and elevation in the base, between two samples too."""
    angles = PanTiltAngles()
    angles.push(0, 0.1, -0.2)
    angles.push(10 * MS, 0.3, 0.2)
    for stamp, expected in ((0, (100.0, -200.0)), (5 * MS, (200.0, 0.0)), (10 * MS, (300, 200))):
        turn = angles.at(stamp)
        assert of_rays(turn[None, :, 2])[0] == pytest.approx(expected)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)


def test_rate_is_the_derivative() -> None:
    """In the base's axes, past the newest sample too."""
    angles = PanTiltAngles()
    angles.push(0, 0.1, -0.2)
    angles.push(100 * MS, 0.4, 0.1)
    for stamp in (50 * MS, 180 * MS):
        before, after = (Rotation.from_matrix(angles.at(stamp + d)) for d in (-MS, MS))
        moved = (after * before.inv()).as_rotvec() / 0.002
        np.testing.assert_allclose(angles.rate_at(stamp), moved, atol=1e-5)


def test_a_turn_is_taken_the_short_way() -> None:
    """Of a joint that is read modulo a turn."""
    angles = PanTiltAngles()
    angles.push(0, np.pi - 0.01, 0.0)
    angles.push(10 * MS, -np.pi + 0.03, 0.0)
    assert angles.rate_at(5 * MS) == pytest.approx([0.0, 4.0, 0.0])
    assert abs(of_rays(angles.at(5 * MS)[None, :, 2])[0, 0]) == pytest.approx(1e3 * np.pi - 10.0)


def test_order_and_gaps() -> None:
    """A late sample is put in its place, an instant that is not covered is told."""
    angles = PanTiltAngles(hold=0.1, memory=1.0)
    with pytest.raises(PlatformGap, match='no angle of pan has come'):
        angles.at(0)
    angles.push(100 * MS, 0.2, 0.0)
    angles.push(0, 0.0, 0.0)
    angles.push(50 * MS, 0.05, 0.0)
    assert of_rays(angles.at(75 * MS)[None, :, 2])[0, 0] == pytest.approx(125.0)
    with pytest.raises(TrackingError, match='with the stamp'):
        angles.push(50 * MS, 0.0, 0.0)
    with pytest.raises(PlatformGap, match='not kept'):
        angles.at(-MS)
    with pytest.raises(PlatformGap, match='0.101 s old'):
        angles.at(201 * MS)
    angles.push(5000 * MS, 0.0, 0.0)
    with pytest.raises(StampJump, match='4.900 s before'):
        angles.push(100 * MS, 0.0, 0.0)
    angles.reset()
    angles.push(100 * MS, 0.3, 0.0)
    assert of_rays(angles.at(150 * MS)[None, :, 2])[0, 0] == pytest.approx(300.0)
    angles.push(400 * MS, 0.0, 0.0)
    with pytest.raises(PlatformGap, match='apart'):
        angles.at(300 * MS)
    # What moved in so long a time tells no rate.
    np.testing.assert_array_equal(angles.rate_at(450 * MS), np.zeros(3))


def test_impossible_angles_and_parameters_are_refused() -> None:
    """Each by its name."""
    for pan, tilt, name in ((np.nan, 0.0, 'pan'), (0.0, np.inf, 'tilt')):
        with pytest.raises(TrackingError, match=f'{name} is'):
            PanTiltAngles().push(0, pan, tilt)
    with pytest.raises(TrackingError, match='hold'):
        PanTiltAngles(hold=-1.0)
    with pytest.raises(TrackingError, match='memory'):
        PanTiltAngles(memory=0.0)
    with pytest.raises(TrackingError, match=r'acceleration is -1.0 rad/s\^2'):
        PanTiltAngles(acceleration=-1.0)


def test_the_rate_is_taken_over_a_span() -> None:
    """Not over 20 us, in which an encoder's step of 0.1 mrad would be 5 rad/s."""
    angles = PanTiltAngles()
    assert angles.newest_ns is None
    for index in range(3):
        stamp = index * 50 * MS
        angles.push(stamp, 0.01 * index - 1e-4, 0.0)
        angles.push(stamp + 20_000, 0.01 * index, 0.0)
    assert angles.newest_ns == stamp + 20_000
    for asked in (stamp, stamp + 10_000, stamp + 20_000, stamp + 30 * MS):
        # 0.2 rad/s, and the step over 50 ms.
        assert angles.rate_at(asked)[1] == pytest.approx(0.2, abs=2.1e-3)
    assert of_rays(angles.at(stamp + 30 * MS)[None, :, 2])[0, 0] == pytest.approx(26.0, abs=0.1)
    # Of one burst alone nothing is known of a rate.
    angles.reset()
    angles.push(0, 0.0, 0.0)
    angles.push(20_000, 1e-4, 0.0)
    np.testing.assert_array_equal(angles.rate_at(10 * MS), np.zeros(3))


def test_the_variance_past_the_newest_sample() -> None:
    """That of joints that swing as strongly as stated, read with an error, at any horizon."""
    random = np.random.default_rng(7)
    swing, acceleration, sigma = 3.0, 5.0, 5e-5  # rad/s, far slower than the horizon
    for ahead in (2, 5, 20):
        strayed, stated = [], 0.0
        for _ in range(2000):
            phase = random.uniform(0.0, 2.0 * np.pi)
            times = 1e-3 * np.array([-20, -10, 0, ahead])
            true = np.sqrt(2.0) * acceleration / swing**2 * np.sin(swing * times + phase)
            angles = PanTiltAngles(sigma=sigma, acceleration=acceleration)
            for time, angle in zip((0, 10, 20), true + random.normal(scale=sigma, size=4)):
                angles.push(time * MS, 0.0, angle)
            seen = of_rays(angles.at((20 + ahead) * MS)[None, :, 2])[0, 1]
            strayed.append(1e-3 * seen - true[3])
            stated = angles.variances_at((20 + ahead) * MS)[1]
        # A variance of 2000 draws is known to 3 %, three times.
        assert np.mean(np.square(strayed)) / stated == pytest.approx(1.0, abs=0.1)
    for between in (0, 7, 20):
        assert angles.variances_at(between * MS) == (sigma**2, sigma**2)


def test_an_unknown_rate_is_uncertain() -> None:
    """After a first sample the pan/tilt may turn, however still it seems."""
    angles = PanTiltAngles(sigma=1e-3)
    angles.push(0, 0.1, 0.2)
    assert angles.variances_at(0) == (1e-6, 1e-6)
    unsure = 1e-6 + (UNKNOWN_RATE_RAD_S * 0.01) ** 2
    assert angles.variances_at(10 * MS) == pytest.approx((unsure, unsure))


def test_each_joint_has_samples_of_its_own() -> None:
    """Of one joint a sample, at other instants and rates; known until the older of the newest."""
    angles = PanTiltAngles(sigma=1e-4)
    for index in range(11):
        angles.push(index * 10 * MS, 0.01 * index, None)
    assert angles.newest_ns is None
    with pytest.raises(PlatformGap, match='no angle of tilt has come'):
        angles.at(100 * MS)
    for stamp in (3, 53):
        angles.push(stamp * MS, None, 0.002 * stamp)
    assert angles.newest_ns == 53 * MS
    assert of_rays(angles.at(28 * MS)[None, :, 2])[0] == pytest.approx((28.0, 56.0))
    # The one is known at that instant, the other goes on at its rate.
    pan, tilt = angles.variances_at(60 * MS)
    assert pan == 1e-8
    assert tilt > 1e-8
    with pytest.raises(PlatformGap, match='the newest angle of tilt is 0.207 s old'):
        angles.at(260 * MS)


def test_what_is_said_twice_is_no_fault() -> None:
    """A driver that repeats its last state; another angle at that stamp is one."""
    angles = PanTiltAngles()
    angles.push(0, 0.1, 0.2)
    angles.push(0, 0.1, None)
    with pytest.raises(TrackingError, match='another angle of pan with the stamp'):
        angles.push(0, 0.3, None)

"""The platform's rotation from samples of its angular velocity."""

from __future__ import annotations

from blob_tracker.tracking import PlatformGap, PlatformRates, StampJump, TrackingError
from blob_tracker.tracking.platform_rates import DENSEST_HZ
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

MS = 1_000_000  # ns


def coning(times: np.ndarray) -> tuple[Rotation, np.ndarray]:
    """Return attitudes and rates in the base of a motion whose axis turns: the hard case."""
    slow, fast, tilt = 0.7, 9.0, 0.3
    zero = np.zeros_like(times)
    spin = Rotation.from_rotvec(np.stack([zero, fast * times, zero], 1))
    lean = Rotation.from_rotvec([tilt, 0.0, 0.0])
    roll = Rotation.from_rotvec(np.stack([zero, zero, slow * times], 1))
    attitude = spin * lean * roll
    rates = roll.inv().apply(lean.inv().apply([0.0, fast, 0.0])) + [0.0, 0.0, slow]
    return attitude, rates


def error_at(rate_hz: int) -> float:
    """Return how far the rotation over half a second is off, rad."""
    times = np.arange(-1, rate_hz) / rate_hz
    _, samples = coning(times)
    platform = PlatformRates()
    for time, sample in zip(times, samples):
        platform.push(round(1e9 * time), sample)
    attitude, _ = coning(np.array([0.1003, 0.6008]))
    exact = attitude[1].inv() * attitude[0]
    turn, variance = platform.between(100_300_000, 600_800_000)
    assert variance == 0.0
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-13)
    return float((Rotation.from_matrix(turn) * exact.inv()).magnitude())


def test_rotation_is_exact_to_the_fourth_order_of_a_linear_rate() -> None:
    """What is left is the rate's bend between samples: its square falls with the interval's."""
    coarse, fine = error_at(100), error_at(200)
    assert fine < 5e-5  # rad, of a turn by 4.5 rad
    assert coarse / fine == pytest.approx(4.0, rel=0.3)


def test_constant_rate_is_exact() -> None:
    """A great turn about one axis; it takes a fixed vector to its components in the base."""
    platform = PlatformRates()
    for index in range(11):
        platform.push(index * 100 * MS, [0.0, 2.0, 0.0])
    turn, _ = platform.between(0, 1000 * MS)
    exact = Rotation.from_rotvec([0.0, -2.0, 0.0]).as_matrix()
    np.testing.assert_allclose(turn, exact, atol=1e-14)
    # The base turns to the right by 2 rad: what was ahead is on its left.
    assert np.arctan2(*(turn @ [0.0, 0.0, 1.0])[[0, 2]]) == pytest.approx(-2.0)


def test_parts_add_up() -> None:
    """To the whole, in rotation and variance, wherever they are cut."""
    random = np.random.default_rng(1)
    platform = PlatformRates()
    for index in range(100):
        platform.push(index * 5 * MS + int(random.integers(MS)), random.normal(size=3), 1e-4)
    whole, variance = platform.between(20 * MS, 400 * MS)
    part, total = np.eye(3), 0.0
    for t0, t1 in ((20, 33), (33, 34), (34, 300), (300, 400)):
        turn, added = platform.between(t0 * MS, t1 * MS)
        part, total = turn @ part, total + added
    # The rate is linear on both sides of a cut; what the axis turns across it is 4th order.
    np.testing.assert_allclose(part, whole, atol=1e-6)
    assert total == pytest.approx(variance, rel=1e-9)


def test_variance_is_that_of_the_samples_noise() -> None:
    """Of 2000 integrals of noise over many samples; its deviation is 2 % for three axes."""
    random = np.random.default_rng(2)
    ends = []
    for _ in range(400):
        platform = PlatformRates()
        for index in range(61):
            platform.push(index * 5 * MS, random.normal(scale=0.01, size=3), 1e-4)
        turn, variance = platform.between(0, 300 * MS)
        ends.append(Rotation.from_matrix(turn).as_rotvec())
    # The first and last sample count half, of 60: 1.25 % less than stated.
    assert np.var(ends) / variance == pytest.approx(1.0, abs=0.12)


def test_order_of_samples_does_not_matter() -> None:
    """A late one is put in its place."""
    random = np.random.default_rng(3)
    samples = [(index * 5 * MS, random.normal(size=3), 1e-6) for index in range(200)]
    in_order, shuffled = PlatformRates(), PlatformRates()
    for sample in samples:
        in_order.push(*sample)
    for index in random.permutation(200):
        shuffled.push(*samples[index])
    first, second = in_order.between(MS, 990 * MS), shuffled.between(MS, 990 * MS)
    np.testing.assert_array_equal(first[0], second[0])
    assert first[1] == second[1]


def test_last_rate_goes_on_for_hold_and_no_longer() -> None:
    """And each gap is told."""
    platform = PlatformRates(hold=0.1)
    with pytest.raises(PlatformGap, match='no angular velocity of the platform has come'):
        platform.between(0, MS)
    for stamp in (0, 50, 100, 300, 350):
        platform.push(stamp * MS, [0.0, 0.0, 0.5], 1e-4)
    turn, variance = platform.between(350 * MS, 450 * MS)
    exact = Rotation.from_rotvec([0.0, 0.0, -0.05]).as_matrix()
    np.testing.assert_allclose(turn, exact, atol=1e-14)
    assert variance == pytest.approx(1e-4 * 0.1**2)  # one error, all the time
    np.testing.assert_array_equal(platform.rate_at(450 * MS), [0.0, 0.0, 0.5])
    with pytest.raises(PlatformGap, match='the newest angular velocity is 0.101 s old'):
        platform.between(350 * MS, 451 * MS)
    with pytest.raises(PlatformGap, match=r'more than 0.1 s apart'):
        platform.between(50 * MS, 320 * MS)
    with pytest.raises(PlatformGap, match='is not kept'):
        platform.between(-MS, 20 * MS)


def test_memory_is_bounded() -> None:
    """By the time, and by the number where samples come faster than any gyro's."""
    platform = PlatformRates(memory=1.0)
    for index in range(3000):
        platform.push(index * MS, [0.0, 0.0, 1e-3 * index])
    assert platform.newest_ns == 2999 * MS
    assert platform.rate_at(2_500 * MS) == pytest.approx([0.0, 0.0, 2.5])
    with pytest.raises(PlatformGap, match='is not kept'):
        platform.rate_at(1_998 * MS)
    for index in range(3 * DENSEST_HZ):
        platform.push(3000 * MS + index * 1000, np.zeros(3))
    newest = 3000 * MS + (3 * DENSEST_HZ - 1) * 1000
    assert platform.newest_ns == newest
    platform.between(newest - DENSEST_HZ // 2 * 1000, newest)
    with pytest.raises(PlatformGap, match='is not kept'):
        platform.between(newest - (DENSEST_HZ + 1) * 1000, newest)


def test_stamps_that_jump() -> None:
    """Back beyond the memory is refused; forward is a gap."""
    platform = PlatformRates(memory=1.0)
    platform.push(5000 * MS, np.zeros(3))
    with pytest.raises(StampJump, match='4.000 s before'):
        platform.push(1000 * MS, np.zeros(3))
    with pytest.raises(TrackingError, match='with the stamp'):
        platform.push(5000 * MS, np.ones(3))
    platform.push(9000 * MS, np.zeros(3))
    with pytest.raises(PlatformGap):
        platform.between(5000 * MS, 9000 * MS)
    platform.reset()
    assert platform.newest_ns is None
    platform.push(1000 * MS, np.zeros(3))


@pytest.mark.parametrize(('rate', 'variance'), [
    ([0.0, np.nan, 0.0], 0.0), ([np.inf, 0.0, 0.0], 0.0), ([0.0, 0.0], 0.0),
    ([0.0, 101.0, 0.0], 0.0), ([0.0, 0.0, 0.0], -1.0), ([0.0, 0.0, 0.0], np.nan),
])
def test_impossible_rates_are_refused(rate: list[float], variance: float) -> None:
    """With the reason, and nothing is kept."""
    platform = PlatformRates()
    with pytest.raises(TrackingError, match='angular velocity'):
        platform.push(0, rate, variance)
    assert platform.newest_ns is None


def test_impossible_parameters_are_refused() -> None:
    """Each by its name."""
    with pytest.raises(TrackingError, match='hold'):
        PlatformRates(hold=0.0)
    with pytest.raises(TrackingError, match='memory'):
        PlatformRates(memory=np.inf)


def test_an_instant_in_a_gap_is_not_covered() -> None:
    """Even where no time passes: the rate there is not known."""
    platform = PlatformRates()
    for stamp in (0, 50, 350, 355):
        platform.push(stamp * MS, [0.0, 0.1, 0.0])
    for stamp in (100, 200, 349):
        with pytest.raises(PlatformGap, match=r'more than 0.2 s apart'):
            platform.between(stamp * MS, stamp * MS)
    turn, _ = platform.between(352 * MS, 352 * MS)
    np.testing.assert_array_equal(turn, np.eye(3))


def swinging(times: np.ndarray) -> np.ndarray:
    """Return rates about the vertical axis of a boat, rad/s."""
    return np.stack([0.0 * times, 0.3 * np.sin(2.0 * times), 0.0 * times], 1)


@pytest.mark.parametrize('fault', [1.0, -10.0, 99.0])
def test_a_fault_of_the_sensor_does_not_turn_the_platform(fault: float) -> None:
    """One sample of 200 Hz: neither the turn nor what is ahead is off, in whatever order."""
    times = 5e-3 * np.arange(200)
    good, bad, late = PlatformRates(), PlatformRates(), PlatformRates()
    faulty = swinging(times)
    faulty[150] += [0.0, fault, 0.0]
    stamps = [index * 5 * MS for index in range(200)]
    for index, (stamp, rate) in enumerate(zip(stamps, swinging(times))):
        good.push(stamp, rate)
        bad.push(stamp, faulty[index])
        if index > 50:
            then = stamp - 50 * MS, stamp + 40 * MS
            # The neighbour's rate, 0.003 rad/s off, at one of ten samples; ahead, by a sample
            # less at the end of the line.
            np.testing.assert_allclose(bad.between(*then)[0], good.between(*then)[0], atol=1e-4)
            np.testing.assert_allclose(bad.rate_at(stamp), good.rate_at(stamp), atol=4e-3)
    for index in np.random.default_rng(6).permutation(200):
        late.push(stamps[index], faulty[index])
    np.testing.assert_array_equal(late.between(0, 1000 * MS)[0], bad.between(0, 1000 * MS)[0])


def test_faults_side_by_side_that_contradict_each_other() -> None:
    """Up and down again: neither counts."""
    platform = PlatformRates()
    for index in range(40):
        platform.push(index * 5 * MS, [{20: 10.0, 21: -10.0}.get(index, 0.1), 0.0, 0.0])
        if index > 0:
            rate = platform.rate_at(index * 5 * MS + 30 * MS)
            np.testing.assert_allclose(rate, [0.1, 0.0, 0.0], atol=1e-12)
    turn, _ = platform.between(0, 195 * MS)
    exact = Rotation.from_rotvec([-0.1 * 0.195, 0.0, 0.0]).as_matrix()
    np.testing.assert_allclose(turn, exact, atol=1e-12)


def test_a_change_of_the_rate_that_lasts_counts() -> None:
    """From the second sample on it is known, and from the first on it turned the platform."""
    platform = PlatformRates()
    for index in range(21):
        platform.push(index * 5 * MS, [0.0, 5.0 if index >= 20 else 0.0, 0.0])
    assert platform.newest_ns == 95 * MS
    np.testing.assert_array_equal(platform.rate_at(100 * MS), np.zeros(3))
    platform.push(105 * MS, [0.0, 5.0, 0.0])
    assert platform.newest_ns == 105 * MS
    turn, _ = platform.between(95 * MS, 105 * MS)
    # Linear from 95 to 100 ms, then 5 rad/s.
    exact = Rotation.from_rotvec([0.0, -5.0 * 0.0075, 0.0]).as_matrix()
    np.testing.assert_allclose(turn, exact, atol=1e-12)


def test_a_blow_that_is_real_is_no_fault() -> None:
    """2 rad/s within 30 ms and back, 105 rad/s^2 at most: to the sample as it was measured."""
    times = 5e-3 * np.arange(-10, 10)
    rates = np.where(np.abs(times) < 0.03, 1.0 + np.cos(np.pi * times / 0.03), 0.0)
    platform = PlatformRates()
    for time, rate in zip(times, rates):
        platform.push(round(1e9 * time), [rate, 0.0, 0.0])
        assert platform.newest_ns == round(1e9 * time)
    for time, rate in zip(times[:-1], rates):  # at the newest it is that of the line
        np.testing.assert_array_equal(platform.rate_at(round(1e9 * time)), [rate, 0.0, 0.0])


def test_distrusted_samples_are_a_gap() -> None:
    """At each instant, with the reason, for as long as it lasts."""
    rates = PlatformRates()
    for index in range(5):
        rates.push(index * 10_000_000, [0.0, 0.1, 0.0])
    rates.distrusted = 'its rates are in degrees/s'
    with pytest.raises(PlatformGap, match='degrees/s'):
        rates.rate_at(20_000_000)
    with pytest.raises(PlatformGap, match='degrees/s'):
        rates.between(10_000_000, 20_000_000)
    rates.distrusted = ''
    assert rates.rate_at(20_000_000)[1] == pytest.approx(0.1)

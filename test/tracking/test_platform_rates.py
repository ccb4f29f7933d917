"""The platform's rotation from samples of its angular velocity."""

from __future__ import annotations

from blob_tracker.tracking import PlatformGap, PlatformRates, StampJump, TrackingError
from blob_tracker.tracking.platform_rates import DENSEST
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
    for index in range(3 * DENSEST):
        platform.push(3000 * MS + index * 1000, np.zeros(3))
    newest = 3000 * MS + (3 * DENSEST - 1) * 1000
    assert platform.newest_ns == newest
    platform.between(newest - DENSEST // 2 * 1000, newest)
    with pytest.raises(PlatformGap, match='is not kept'):
        platform.between(newest - (DENSEST + 1) * 1000, newest)


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

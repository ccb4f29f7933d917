"""Clocks are named by their offset, and taken off exactly where that is known."""

from __future__ import annotations

import time

from blob_tracker.ros.diagnostics.stamp_clock import name_clock, SampleClock, StampClock
import numpy as np
import pytest

NOW_NS = 1_790_000_000_000_000_000
COAST_S = 0.5
BOOT_S = time.monotonic() - time.time()


def take(clock: StampClock, offset: float, delays: np.ndarray) -> np.ndarray:
    """Return what is left of an offset after so many delays on the way, s."""
    left = []
    for index, delay in enumerate(delays):
        instant_ns = NOW_NS + index * 16_666_667
        stamp_ns = instant_ns + round(1e9 * offset)
        left.append(1e-9 * (clock.corrected(stamp_ns, instant_ns + round(1e9 * delay))
                            - instant_ns))
    return np.array(left)


def delays(count: int = 30) -> np.ndarray:
    """Return delays of 20 to 40 ms."""
    return np.random.default_rng(7).uniform(0.02, 0.04, count)


@pytest.mark.parametrize(
    'offset, name, exact',
    [
        (36.97, 'TAI', 37.0), (36.2, 'TAI', 37.0), (17.95, 'GPS', 18.0),
        (BOOT_S - 0.03, 'since this computer was started', BOOT_S),
        (3.2, 'another machine', None), (-0.7, 'a long way to here', None),
        (-90000.0, 'a recording', None),
    ],
    ids=['TAI', 'late TAI', 'GPS', 'boot', 'ahead', 'late', 'recording'],  # not this boot's
)
def test_clocks_have_names(offset: float, name: str, exact: float | None) -> None:
    """With the delay that there always is; the boot of a computer is known to its microsecond."""
    said, ahead = name_clock(offset)
    assert name in said
    assert ahead == (None if exact is None else pytest.approx(exact, abs=1e-3))


def test_stamps_of_the_systems_clock_are_left_alone() -> None:
    """To the last ns, and without a word: also with `auto`."""
    for auto in (False, True):
        clock = StampClock(auto=auto, latest=COAST_S)
        assert (take(clock, 0.0, delays()) == 0.0).all()
        assert clock.fault == ''


@pytest.mark.parametrize(
    'offset, words',
    [
        (37.0, ('36.97', 'ahead of', 'TAI', 'set stamp_offset to 37.000')),
        (-0.7, ('0.73', 'behind', 'set clocks by NTP', 'set stamp_offset to -0.73')),
        (-90000.0, ('behind', 'play a recording with --clock')),
        # The filter knows where the light was, and that is what it tells.
        (0.3, ('0.27', 'ahead of', 'and what is predicted is of 0.27', 'set stamp_offset to')),
    ],
)
def test_another_clock_is_told_with_what_to_do(offset: float, words: tuple[str, ...]) -> None:
    """By how much, whose it may be, and the parameter with its value."""
    clock = StampClock(latest=COAST_S)
    take(clock, offset, delays())
    for each in words:
        assert each in clock.fault


@pytest.mark.parametrize('offset', [37.0, 18.0])
def test_an_offset_that_is_known_is_taken_off_exactly(offset: float) -> None:
    """Measured or given; the delay on the way does not enter."""
    for clock in (StampClock(auto=True, latest=COAST_S), StampClock(offset, latest=COAST_S)):
        assert np.abs(take(clock, offset, delays())[10:]).max() < 1e-9
        assert clock.fault == ''


def test_the_offset_of_another_machine_is_that_of_the_soonest() -> None:
    """Once: a track would not bear an offset that changes from stamp to stamp."""
    clock = StampClock(auto=True, latest=COAST_S)
    left = take(clock, 3.2, delays())[10:]
    assert (left == left[0]).all()
    assert 0.02 <= left[0] < 0.025  # the least of ten delays of 20 to 40 ms
    assert clock.fault == ''


def test_a_clock_that_is_set_is_measured_anew() -> None:
    """PTP comes up in the midst of a run."""
    clock = StampClock(auto=True, latest=COAST_S)
    take(clock, 0.0, delays())
    assert np.abs(take(clock, 37.0, delays())[15:]).max() < 1e-9


@pytest.mark.parametrize(
    'there, set_to, words',
    [
        (0.0, 37.0, ('37.03', 'behind', "the clock is this computer's", 'to 0.000')),
        (37.0, 18.0, ('18.97', 'ahead of', 'offset of 18.000 s taken off', 'TAI', 'to 37.000')),
    ],
)
def test_an_offset_that_is_wrong_is_told_with_the_right_one(
    there: float, set_to: float, words: tuple[str, ...]
) -> None:
    """The clock is named by its stamps as they come, not by what the offset made of them."""
    clock = StampClock(set_to, latest=COAST_S)
    take(clock, there, delays())
    for each in words:
        assert each in clock.fault


def test_stamps_that_stand_are_no_clock_s() -> None:
    """A driver that sets none: no offset helps. Twenty lights of one frame are something else."""
    for stamp_ns, said in ((0, 'all stamps are 0.000 s, and nothing can be predicted: have the'),
                           (7_500_000_000, 'all stamps are 7.500 s')):
        clock = StampClock(auto=True, latest=COAST_S)
        for index in range(60):
            clock.corrected(stamp_ns, NOW_NS + index * 33_333_333)
        assert clock.fault.startswith(said)
    clock = StampClock(latest=COAST_S)
    for index in range(60):
        for _ in range(20):
            clock.corrected(NOW_NS + index * 33_333_333, NOW_NS + index * 33_333_333)
    assert clock.fault == ''


@pytest.mark.parametrize('offset, words', [
    (37.0, "36.970 s ahead of this computer's clock as they come (TAI, which PTP keeps): have its "
           "driver stamp by the system's clock"),
    (-0.7, '0.730 s behind'),
    (-0.1, ''),
])
def test_samples_of_another_clock_are_told(offset: float, words: str) -> None:
    """Of a gyro or of joints, which come at once."""
    clock = SampleClock(0.2)
    assert clock.fault == ''
    for index in range(10):
        instant_ns = NOW_NS + index * 10_000_000
        clock.took(instant_ns + round(1e9 * offset), instant_ns + 30_000_000)
    assert words in clock.fault
    assert bool(clock.fault) is bool(words)

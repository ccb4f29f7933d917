"""Monotonic stamps in real time: right, in order, and jumping only where the clock was set."""

import time

from blob_tracker.capture.clock import MAX_SLEW, RealtimeClock, STEP_NS
import pytest

SECOND = 1_000_000_000
FRAME = SECOND // 60
BOOT = 1_700_000_000 * SECOND  # real time at monotonic zero


class Clocks:
    """Two clocks, of which one is set, and which are read slowly."""

    def __init__(self):
        self.now = 5 * SECOND
        self.offset = BOOT
        self.reading_ns = 100

    def monotonic(self):
        self.now += self.reading_ns
        return self.now

    def realtime(self):
        self.now += self.reading_ns
        return self.now + self.offset


def error(clock, clocks):
    """Return how far a stamp of this instant comes out from the truth, ns."""
    stamp = clocks.now
    truth = stamp + clocks.offset
    return clock.from_monotonic(stamp) - truth


def test_offset_is_exact_for_steady_clocks():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    for _ in range(100):
        clocks.now += FRAME
        assert error(clock, clocks) == 0


def test_a_stamp_in_real_time_is_one_of_the_same_instant():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    stamp = clocks.now
    assert clock.monotonic(stamp) == stamp
    assert clock.monotonic(stamp + SECOND) == stamp + SECOND  # vivid's end of a frame
    assert clock.monotonic(stamp + BOOT) == stamp


def test_one_interrupted_reading_does_no_harm():
    clocks = Clocks()
    delays = iter([100, 100, 9_000_000] + [100] * 1000)  # 9 ms between realtime and monotonic

    def monotonic():
        clocks.now += next(delays)
        return clocks.now

    clock = RealtimeClock(monotonic, clocks.realtime)
    assert clock.from_monotonic(0) == BOOT


def test_a_machine_busy_throughout_moves_a_stamp_by_microseconds():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    clocks.now += FRAME
    # Every reading is interrupted for 5 ms between the real-time clock and the one after it.
    readings = iter([0, 5_000_000] * 5)

    def late_monotonic():
        clocks.now += next(readings)
        return clocks.now

    clock._monotonic = late_monotonic
    start = clocks.now
    moved = abs(clock.from_monotonic(start) - (start + BOOT))
    # The frame before this reading took 1/60 s and the reading itself 25 ms at most.
    assert 0 < moved <= MAX_SLEW * (FRAME + 25_000_000)


def test_a_small_correction_is_slewed_and_stamps_keep_their_order():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    correction = 800_000  # ns back, a fraction of a frame
    assert correction < STEP_NS
    clocks.offset -= correction
    errors = [correction]
    for _ in range(600):
        clocks.now += FRAME
        errors.append(error(clock, clocks))
    steps = [b - a for a, b in zip(errors, errors[1:])]
    # Reading the clocks takes 15 times 100 ns on top of the frame's time.
    assert all(-MAX_SLEW * (FRAME + 2000) - 1 <= step <= 0 for step in steps)
    assert errors[-1] == 0  # arrived: 0.8 ms take 1.6 s at 500 ppm


@pytest.mark.parametrize('step', [3600 * SECOND, SECOND // 10, -SECOND // 10, 2_000_000])
def test_a_clock_that_was_set_is_followed_at_once(step):
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    clocks.now += FRAME
    clocks.offset += step
    assert error(clock, clocks) == 0


def test_a_step_behind_wide_brackets_is_followed_when_they_are_tight_again():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    step = 20_000_000
    clocks.now += FRAME
    clocks.offset += step
    clocks.reading_ns = 5_000_000  # a bracket of 10 ms, within which half the step may lie
    # Fifteen readings of 5 ms on top of the frame's time.
    assert 0 < step + error(clock, clocks) <= MAX_SLEW * (FRAME + 15 * clocks.reading_ns) + 1
    clocks.reading_ns = 100
    assert error(clock, clocks) == 0


def test_this_machines_clocks():
    clock = RealtimeClock()
    before = time.time_ns()
    stamp = clock.from_monotonic(time.monotonic_ns())
    after = time.time_ns()
    # Half a bracket, microseconds at the worst; 1 ms leaves room for a busy machine.
    assert before - 1_000_000 <= stamp <= after + 1_000_000

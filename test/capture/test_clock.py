"""Monotonic stamps in real time: right, ordered, and never jumping."""

import time

from blob_tracker.capture.clock import MAX_SLEW, RealtimeClock, STEP_NS

SECOND = 1_000_000_000
FRAME = SECOND // 60
BOOT = 1_700_000_000 * SECOND  # real time at monotonic zero


class Clocks:
    """Two clocks that run apart at a rate, are set, and are read slowly."""

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


def test_drift_is_followed_without_lag():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    drift = 100  # ppm: more than any crystal's
    for _ in range(600):
        clocks.now += FRAME
        clocks.offset += FRAME * drift // 1_000_000
        assert abs(error(clock, clocks)) <= 1  # rounding of the bracket's middle


def test_a_small_correction_is_slewed_and_stamps_keep_their_order():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    correction = 2_000_000  # ns back, a fraction of a frame
    clocks.offset -= correction
    errors = [correction]
    for _ in range(600):
        clocks.now += FRAME
        errors.append(error(clock, clocks))
    steps = [b - a for a, b in zip(errors, errors[1:])]
    # Reading the clocks takes 15 times 100 ns on top of the frame's time.
    assert all(-MAX_SLEW * (FRAME + 2000) - 1 <= step <= 0 for step in steps)
    assert errors[-1] == 0  # arrived: 2 ms take 4 s at 500 ppm


def test_a_clock_that_was_set_is_followed_at_once():
    clocks = Clocks()
    clock = RealtimeClock(clocks.monotonic, clocks.realtime)
    clocks.offset += 3600 * SECOND
    assert 3600 * SECOND > STEP_NS
    assert error(clock, clocks) == 0


def test_this_machines_clocks():
    clock = RealtimeClock()
    before = time.time_ns()
    stamp = clock.from_monotonic(time.monotonic_ns())
    after = time.time_ns()
    # Half a bracket, microseconds at the worst; 1 ms leaves room for a busy machine.
    assert before - 1_000_000 <= stamp <= after + 1_000_000

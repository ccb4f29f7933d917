"""Rate, age and latency of the last seconds."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.timing import plausible, ROOM, Timing, UsualRate
import numpy as np
import pytest

SECOND = 10**9
START = 7 * SECOND  # of a clock that began some time ago


def test_a_steady_stream():
    """50 Hz, of which each message is 20 ms old as it comes and 30 as its result leaves."""
    timing = Timing()
    for index in range(1000):
        now = START + index * SECOND // 50
        timing.arrived(now, 20_000_000)
        timing.left(now + 10_000_000, 30_000_000)
    figures = timing.figures(now + 15_000_000)
    assert figures.rate == pytest.approx(50.0)
    assert figures[1:4] == pytest.approx((20.0, 30.0, 30.0))
    assert figures.results == pytest.approx(500, abs=2)  # of the last 10 s
    assert not figures.uneven


def test_percentiles_are_those_of_the_last_ten_seconds():
    """What is longer ago is forgotten, however large it was."""
    timing = Timing()
    random = np.random.default_rng(1)
    latencies = np.concatenate([np.full(600, 900e6), random.exponential(20e6, 600)])
    for index, latency in enumerate(latencies):
        timing.left(START + index * SECOND // 60, int(latency))
    figures = timing.figures(START + 20 * SECOND)
    assert figures.latency == pytest.approx(np.median(latencies[600:]) / 1e6)
    assert figures.latency_p99 == pytest.approx(np.percentile(latencies[600:], 99.0) / 1e6)


def test_more_than_the_ring_holds():
    """At 5000 Hz the oldest are overwritten, and nothing else changes."""
    timing = Timing()
    for index in range(3 * ROOM):
        timing.arrived(START + index * 200_000, index)
    figures = timing.figures(START + 3 * ROOM * 200_000)
    assert figures.rate == pytest.approx(5000.0, rel=1e-3)
    assert figures.age == pytest.approx((2.5 * ROOM - 0.5) / 1e6)


@pytest.mark.parametrize(('silence', 'rate'), [(0.0, 30.0), (0.05, 30.0), (0.5, 2.0), (4.0, 0.25)])
def test_the_rate_falls_with_silence(silence, rate):
    """A stream that stops has no rate that lingers."""
    timing = Timing()
    for index in range(90):
        timing.arrived(START + index * SECOND // 30, 0)
    now = START + 89 * SECOND // 30 + int(silence * SECOND)
    assert timing.figures(now).rate == pytest.approx(rate)


def test_a_slow_stream_has_a_rate():
    """One message in four seconds is 0.25 Hz, not 0; nothing yet is 0, with an unknown age."""
    timing = Timing()
    nothing = timing.figures(START)
    assert nothing.rate == 0.0
    assert np.isnan(nothing[1:4]).all()
    for index in range(4):
        timing.arrived(START + 4 * index * SECOND, 0)
    assert timing.figures(START + 13 * SECOND).rate == pytest.approx(0.25)


def test_fits_and_starts_are_told_from_a_long_way():
    """Two results in a hundred that are four frames late; not a stream that is evenly late."""
    for base, late, uneven in ((20, 160, True), (20, 60, False), (300, 300, False)):
        timing = Timing()
        for index in range(400):
            now = START + index * SECOND // 30
            timing.arrived(now, 0)
            timing.left(now, 10**6 * (late if index % 50 == 0 else base))
        assert timing.figures(now).uneven == uneven


@pytest.mark.parametrize(
    ('age', 'known'), [(0.3, True), (-0.5, True), (-2.0, False), (3e10, False), (np.nan, False)]
)
def test_an_age_of_another_clock_is_none(age, known):
    """Recordings are years old, or of a time that is to come."""
    assert plausible(age) == known


def test_a_rate_that_falls_is_told_for_half_a_minute():
    """Not at the first slow second, not where it falls by a third, not for ever."""
    usual = UsualRate()
    assert not any(usual.fell(30.0) for _ in range(60))
    assert not any(usual.fell(20.0) for _ in range(5))
    said = [usual.fell(10.0) for _ in range(60)]
    assert said[:2] == [None, None]
    assert said[2:25] == [30.0] * 23
    assert said[-20:] == [None] * 20

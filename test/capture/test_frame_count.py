from blob_tracker.capture.frame_count import FrameCount
import numpy as np
import pytest

INTERVAL = 33_333_333  # ns


def counted(numbers, frames, numbered, jitter_ns=0.0):
    """Return the count after the frames of these indices came with these numbers."""
    count = FrameCount(numbered)
    late = np.random.default_rng(4).normal(0.0, jitter_ns, len(frames))
    for number, frame, error in zip(numbers, frames, late):
        count.came(number, 10**9 + frame * INTERVAL + round(error))
    return count


def without(*lost, count=60):
    return [frame for frame in range(count) if frame not in lost]


def test_numbers_with_holes():
    frames = without(3, 20, 21)
    count = counted(frames, frames, numbered=True)
    assert count.lost == 3
    assert count.interval_ns == INTERVAL


def test_a_number_that_runs_over_or_begins_again():
    assert counted([0xfffffffe, 0xffffffff, 0, 2], range(4), numbered=True).lost == 1
    assert counted([7, 8, 0, 1], range(4), numbered=True).lost == 0


@pytest.mark.parametrize('jitter_ns', [0.0, 0.08 * INTERVAL])
@pytest.mark.parametrize('step', [1, 2])
def test_stamps_tell_where_the_numbers_do_not(jitter_ns, step):
    # Each lost frame takes the next with it, and the number does not jump; or it jumps by two
    # though none is lost.
    frames = without(20, 21, 40, 41, 42, 43)
    count = counted(range(0, step * len(frames), step), frames, numbered=False,
                    jitter_ns=jitter_ns)
    assert count.lost == 6
    assert count.interval_ns == pytest.approx(INTERVAL, rel=0.05)


def test_frames_that_a_busy_machine_stamps_late_are_not_lost():
    stamps = np.arange(200.0)
    stamps[[20, 50, 51, 90]] += [1.3, 2.6, 1.7, 0.9]
    assert counted(range(200), np.maximum.accumulate(stamps), numbered=False).lost == 0


@pytest.mark.parametrize('rate', [0.98, 1.02])
def test_an_interval_that_is_a_little_off_adds_up_to_nothing(rate):
    # Half of the intervals are those of a camera that alternates between two.
    stamps = np.cumsum(np.where(np.arange(400) % 3 == 0, 2.0 - rate, rate))
    assert counted(range(400), stamps, numbered=False).lost <= 1


def test_a_camera_that_takes_longer_in_the_dark_loses_few():
    stamps = np.cumsum([1] * 30 + [2] * 30)
    # Those until the median follows.
    assert counted(range(60), stamps, numbered=False).lost <= 8


def test_the_rate_counts_what_was_lost():
    count = FrameCount(numbered=True)
    for number in range(0, 60, 2):
        count.came(number, 20_000_000 * number)
    assert count.lost == 29 and count.rate == pytest.approx(50.0)

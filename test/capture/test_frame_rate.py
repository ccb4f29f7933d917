"""Frame rates as fractions: what a driver is asked for, and what comes."""

from fractions import Fraction

from blob_tracker.capture import videodev2
from blob_tracker.capture.frame_rate import (
    ENOUGH, frame_interval, MeasuredRate, set_frame_rate,
)
import pytest


class Rated:
    """A driver that takes any frame rate."""

    def call(self, number, argument):
        argument.capability = videodev2.CAP_TIMEPERFRAME
        if number == videodev2.S_PARM:
            interval = argument.timeperframe
            self.asked = (interval.denominator, interval.numerator)


@pytest.mark.parametrize(('wanted', 'asked'), [
    (29.97, (30000, 1001)), (30000 / 1001, (30000, 1001)), (59.94, (60000, 1001)),
    (23.976, (24000, 1001)), (23.98, (24000, 1001)), (119.88, (120000, 1001)),
    # 5, 10 and 990 lie within 0.01 of such a rate too.
    (30.0, (30, 1)), (5.0, (5, 1)), (10.0, (10, 1)), (990.0, (990, 1)),
    (7.5, (15, 2)), (0.5, (1, 2)), (1 / 3, (1, 3)), (29.5, (59, 2)),
])
def test_a_frame_rate_is_asked_for_as_drivers_know_it(wanted, asked):
    driver = Rated()
    given = set_frame_rate(driver.call, videodev2.BUF_TYPE_VIDEO_CAPTURE, wanted, 0.0)
    assert given == pytest.approx(wanted, abs=0.01)
    assert driver.asked == asked


class Forgetful:
    """A driver that a format takes back to 30 Hz, as uvcvideo."""

    def __init__(self):
        self.interval = Fraction(1, 15)
        self.asked = 0

    def call(self, number, argument):
        argument.capability = videodev2.CAP_TIMEPERFRAME
        interval = argument.timeperframe
        if number == videodev2.S_PARM:
            self.asked += 1
            self.interval = Fraction(interval.numerator, interval.denominator)
        interval.numerator, interval.denominator = self.interval.as_integer_ratio()


KIND = videodev2.BUF_TYPE_VIDEO_CAPTURE


def test_a_rate_that_somebody_chose_before_is_kept():
    driver = Forgetful()
    before = frame_interval(driver.call, KIND)
    driver.interval = Fraction(1, 30)  # the format was set
    assert set_frame_rate(driver.call, KIND, 0.0, 0.0, before) == 15.0
    # Nothing is set that is so already: some drivers refuse, or stop, at each setting.
    assert set_frame_rate(driver.call, KIND, 0.0, 0.0, before) == 15.0
    assert set_frame_rate(driver.call, KIND, 15.0, 0.0, before) == 15.0
    assert driver.asked == 1
    assert set_frame_rate(driver.call, KIND, 20.0, 0.0, before) == 20.0


def test_the_rate_is_measured_whatever_is_lost():
    measured = MeasuredRate()
    assert measured.rate == 0.0
    for number in range(0, 3 * ENOUGH, 3):  # two of three do not come through
        measured.add(number, 40_000_000 * number)
        assert measured.rate in (0.0, pytest.approx(25.0))
    assert measured.rate == pytest.approx(25.0)
    measured.add(0, 0)  # the driver counts anew
    assert measured.rate == 0.0


def test_the_measured_rate_follows():
    measured = MeasuredRate()
    stamp_ns = 0
    for number in range(300):
        stamp_ns += 40_000_000 if number < 200 else 100_000_000
        measured.add(number, stamp_ns)
    assert measured.rate == pytest.approx(10.0)

"""Frame rates as fractions: what a driver is asked for."""

from blob_tracker.capture import videodev2
from blob_tracker.capture.frame_rate import set_frame_rate
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

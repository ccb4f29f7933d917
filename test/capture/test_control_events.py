"""Changes that others make on controls; a real driver's events are met in test/vm."""

import errno

from blob_tracker.capture import Control, videodev2
from blob_tracker.capture.control_events import ControlEvents
import pytest


def control(number, kind='integer'):
    return Control(number, str(number), '', kind, 0, 9, 1, 0, {}, False, False, False)


class Driver:
    """A driver that tells of some controls."""

    def __init__(self, events=(), tells=(7, 8)):
        self.events = list(events)
        self.tells = tells
        self.asked = []

    def __call__(self, number, argument):
        if number == videodev2.SUBSCRIBE_EVENT:
            self.asked.append(argument.id)
            if argument.id not in self.tells:
                raise OSError(errno.EINVAL, 'no such event')
        else:
            assert number == videodev2.DQEVENT
            if not self.events:
                raise OSError(errno.ENOENT, 'no event')
            argument.id, argument.timestamp.tv_sec, argument.timestamp.tv_nsec = (
                self.events.pop(0))


def test_the_last_change_of_each_is_taken_once():
    events = ControlEvents(
        Driver([(7, 3, 5), (8, 3, 7), (7, 3, 900)]), [control(7), control(8)])
    assert events.told
    assert events.take() == {7: 3_000_000_900, 8: 3_000_000_007}
    assert events.take() == {}


def test_a_driver_may_tell_of_some_controls_or_of_none():
    assert ControlEvents(Driver(), [control(6), control(7)]).told
    silent = ControlEvents(Driver([(7, 3, 5)], tells=()), [control(7)])
    assert not silent.told
    assert silent.take() == {}


def test_a_button_has_nothing_to_tell():
    driver = Driver()
    ControlEvents(driver, [control(7, 'button'), control(8)])
    assert driver.asked == [8]


def test_a_device_that_is_gone_is_an_error():
    def gone(number, argument):
        raise OSError(errno.ENODEV, 'gone')

    with pytest.raises(OSError, match='gone'):
        ControlEvents(gone, [control(7)])

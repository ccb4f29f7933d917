"""What a control may be; reading and setting run in test/vm on a real driver."""

import errno
from types import MappingProxyType

from blob_tracker.capture import Control, ControlError, controls, videodev2
import pytest

INTEGER = Control(1, 'gain', 'Gain', 'integer', -6, 30, 3, 0, MappingProxyType({}),
                  False, False, False)


@pytest.mark.parametrize(('label', 'name'), [
    ('Brightness', 'brightness'),
    ('White Balance, Automatic', 'white_balance_automatic'),
    ('Exposure Time, Absolute', 'exposure_time_absolute'),
    ('Limited RGB Range (16-235)', 'limited_rgb_range_16_235'),
    ("Y'CbCr Encoding", 'y_cbcr_encoding'),
])
def test_names_are_spelled_as_v4l2_ctl_does(label, name):
    assert controls.spelled(label) == name


class Driver:
    """Takes a value, with the error that it is told to give."""

    def __init__(self, error=None):
        self.error = error
        self.value = None

    def __call__(self, number, argument):
        assert number == videodev2.S_EXT_CTRLS
        if self.error:
            raise OSError(self.error, 'its text')
        self.value = argument.controls[0].value.value


@pytest.mark.parametrize('value', [-6, -3, 30, 0.0])
def test_values_on_the_steps_are_set(value):
    driver = Driver()
    controls.set_control(driver, INTEGER, value)
    assert driver.value == value


@pytest.mark.parametrize('value', [-7, -5, 1, 31, 33, 2.5, '3', None, float('inf')])
def test_other_values_are_refused_with_what_is_right(value):
    driver = Driver()
    with pytest.raises(ControlError) as error:
        controls.set_control(driver, INTEGER, value)
    assert str(error.value) == (f"control 'gain' is {value!r}; it must be a whole number from -6 "
                                'to 30 in steps of 3')
    assert driver.value is None


@pytest.mark.parametrize(('number', 'inactive', 'words'), [
    (13, False, "control 'gain' cannot be set: its text"),
    (13, True, "control 'gain' cannot be set while it is inactive: another control, mostly an "
               'automatic mode, governs it; switch that off first'),
    (16, False, "control 'gain' cannot be set now: the driver locks it while frames are streaming "
                'or another program holds it'),
    (34, False, "control 'gain' cannot be set: the driver refuses the value; it must be a whole "
                'number from -6 to 30 in steps of 3'),
])
def test_what_a_driver_refuses_is_told(number, inactive, words):
    control = Control(1, 'gain', 'Gain', 'integer', -6, 30, 3, 0, MappingProxyType({}),
                      False, inactive, False)
    with pytest.raises(ControlError) as error:
        controls.set_control(Driver(number), control, 3)
    assert str(error.value) == words


def test_a_device_that_is_gone_is_not_the_controls_fault():
    with pytest.raises(OSError, match='its text'):
        controls.set_control(Driver(19), INTEGER, 3)


class Repeating:
    """A driver from before the flag for the next control: it knows one and gives it again."""

    def __call__(self, number, argument):
        argument.id = 0x00980913
        argument.name = b'Gain'
        argument.type = videodev2.CTRL_TYPE_INTEGER


def test_a_driver_that_repeats_itself_ends():
    assert list(controls.controls(Repeating())) == ['gain']


class Webcam:
    """A driver with menus of three items, of which some controls or items cannot be told."""

    def __init__(self, numbers, broken=(), error=errno.EIO, broken_item=None):
        self.numbers = numbers
        self.broken = broken
        self.error = error
        self.broken_item = broken_item
        self.failures = 0

    def __call__(self, number, argument):
        if number == videodev2.QUERYMENU:
            if argument.index == self.broken_item:
                raise OSError(self.error, 'its text')
            argument.item.name = b'Item %d' % argument.index
            return
        asked = argument.id & ~videodev2.CTRL_FLAG_NEXT_CTRL
        least = asked + 1 if asked != argument.id else asked
        following = min((known for known in self.numbers if known >= least), default=None)
        if following is None or asked == argument.id != following:
            raise OSError(errno.EINVAL, 'Invalid argument')
        if following in self.broken:
            self.failures += 1
            raise OSError(self.error, 'its text')
        argument.id = following
        argument.name = b'%x' % following
        argument.type = videodev2.CTRL_TYPE_MENU
        argument.maximum = 2


# Three of the user class with the one that names it before them, and two of the camera class.
WEBCAM = (0x980001, 0x980900, 0x980902, 0x98091c, 0x9a0901, 0x9a0902)


@pytest.mark.parametrize('error', [errno.EIO, errno.EPIPE, errno.ETIMEDOUT])
@pytest.mark.parametrize('broken', [(number,) for number in WEBCAM[1:3] + WEBCAM[4:]]
                         + [WEBCAM[1:3], WEBCAM[:2]])
def test_a_broken_control_is_left_out_alone(broken, error):
    found = controls.controls(Webcam(WEBCAM, broken, error))
    assert [control.number for control in found.values()] == [
        number for number in WEBCAM if number not in broken]


@pytest.mark.parametrize('broken', [WEBCAM[3:4], WEBCAM[1:3], WEBCAM[3:5], WEBCAM[5:]])
def test_a_control_that_makes_each_try_wait_hides_no_other_and_is_not_asked_again(broken):
    webcam = Webcam(WEBCAM, broken, errno.ETIMEDOUT)
    silent: dict[int, int] = {}
    answering = [number for number in WEBCAM if number not in broken]
    for _ in range(3):
        found = controls.controls(webcam, silent)
        assert [control.number for control in found.values()] == answering
    assert webcam.failures == 2 * len(broken)


def test_a_driver_whose_controls_are_all_broken_has_none():
    assert controls.controls(Webcam(WEBCAM, WEBCAM)) == {}


def test_a_broken_item_is_left_out_of_its_menu():
    found = controls.controls(Webcam(WEBCAM[:1], broken_item=1))
    assert [dict(control.menu) for control in found.values()] == [{0: 'Item 0', 2: 'Item 2'}]


@pytest.mark.parametrize('settings', [{'broken': WEBCAM[2:3]}, {'broken_item': 1}])
def test_a_device_that_goes_while_it_tells_is_gone(settings):
    with pytest.raises(OSError, match='its text') as error:
        controls.controls(Webcam(WEBCAM, error=errno.ENODEV, **settings))
    assert error.value.errno == errno.ENODEV

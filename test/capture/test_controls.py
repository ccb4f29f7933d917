"""What a control may be; reading and setting run in test/vm on a real driver."""

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

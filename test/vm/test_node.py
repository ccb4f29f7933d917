"""The camera node on the real V4L2 driver: what guest_node.py wrote down."""

from __future__ import annotations

import json
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterType

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself
OWN = {'device', 'width', 'height', 'pixel_format', 'frame_rate', 'buffers', 'exposure_time',
       'readout_time', 'frame_id', 'camera_name', 'camera_info_url', 'field_of_view', 'channel',
       'line_time', 'rolling_shutter', 'fields'}


@pytest.fixture(scope='module')
def node(results) -> dict[str, Any]:
    """Give what guest_node.py found."""
    return json.loads((results / 'node.json').read_text())


@pytest.fixture
def parameters(node) -> dict[str, Any]:
    """Give what it found of the parameters."""
    return node['parameters']


def test_every_control_is_a_parameter_and_no_other(parameters):
    assert len(parameters['controls']) > 30
    others = {name for name in parameters['names'] if '.' not in name}
    others -= {'use_sim_time', 'start_type_description_service'}
    assert others == set(parameters['controls']) | OWN


def test_a_control_that_start_up_named_is_set_and_automatic_gain_is_off(parameters):
    # Both stood otherwise when the node started: contrast at 128, the automatic gain on.
    assert parameters['at_start'] == {
        'contrast': 99, 'gain_automatic': False, 'v4l2_ctl contrast': '99',
        'v4l2_ctl gain_automatic': '0'}


@pytest.mark.parametrize(('name', 'kind', 'words', 'ranges'), [
    ('brightness', ParameterType.PARAMETER_INTEGER,
     'Brightness: a whole number from 0 to 255; 128 by default.', [[0, 255, 1]]),
    ('menu', ParameterType.PARAMETER_INTEGER,
     'Menu: one of 1 (Menu Item 1), 3 (Menu Item 3), 4 (Menu Item 4); 3 by default.',
     [[1, 4, 1]]),
    ('string', ParameterType.PARAMETER_STRING, 'String: a text of 2 to 4 bytes', []),
    ('integer_64_bits', ParameterType.PARAMETER_INTEGER,
     'Integer 64 Bits: a whole number from -9223372036854775808 to 9223372036854775807; 0 by '
     'default.', [[-2**63, 2**63 - 1, 1]]),
    ('button', ParameterType.PARAMETER_BOOL, 'Button: true presses it.', []),
    ('boolean', ParameterType.PARAMETER_BOOL, 'Boolean: true or false; true by default.', []),
    ('bitmask', ParameterType.PARAMETER_INTEGER,
     'Bitmask: a whole number whose bits are among those of 0x80402010; 2147491840 by default.',
     [[0, 0x80402010, 1]]),
])
def test_a_parameter_has_the_type_the_range_and_the_words_of_its_control(
    parameters, name, kind, words, ranges
):
    assert parameters['described'][name] == [kind, words, ranges]


def test_a_read_only_control_says_so(parameters):
    assert 'Read-only.' in parameters['described']['read_only_integer_32_bits'][1]


@pytest.mark.parametrize(('name', 'value', 'reason'), [
    ('brightness', 200, ''),
    ('integer_64_bits', -2**40, ''),
    ('string', 'abc', ''),
    ('boolean', False, ''),
    ('menu', 4, ''),
    ('bitmask', 0x80000000, ''),
    ('button', True, ''),
    ('brightness', 256, 'out of range'),
    ('menu', 2, "control 'menu' is 2; it must be one of 1 (Menu Item 1), 3 (Menu Item 3), "),
    ('string', 'a', "control 'string' is 'a'; it must be a text of 2 to 4 bytes"),
    ('button', False, "control 'button' is False; it must be true, which presses it"),
    ('brightness', 'high', 'Wrong parameter type'),
    ('read_only_integer_32_bits', 1, 'is read-only: the driver alone changes it'),
])
def test_a_parameter_is_set_while_frames_come_or_refused_with_the_reason(
    parameters, name, value, reason
):
    refused = next(why for n, v, why in parameters['sets'] if (n, v) == (name, value))
    assert (refused == '') if not reason else (reason in refused)


def test_what_was_set_is_on_the_device(parameters):
    assert parameters['after'] == {
        'brightness': '200', 'integer_64_bits': str(-2**40), 'string': 'abc', 'boolean': '0',
        'menu': '4', 'bitmask': str(-2**31)}  # v4l2-ctl takes the top bit for a sign
    assert parameters['springs_back']


def test_several_are_set_together_or_not_at_all(parameters):
    assert "control 'menu' is 2" in parameters['all_or_none']
    assert parameters['none'] == '200'
    assert parameters['mode_and_governed'] == ''
    assert parameters['gain'] == '44'


def test_what_another_program_sets_is_followed_and_not_fought(parameters):
    assert parameters['followed']
    assert parameters['not_fought'] == '12'


def test_an_automatic_gain_is_warned_of_and_governs_the_gain(parameters):
    assert parameters['automatic'] == ''
    assert parameters['warned']
    assert 'inactive' in parameters['inactive']
    assert parameters['manual'] == ''


def test_a_calibration_of_another_size_is_refused(node):
    success, words = node['services']['other_size']
    assert not success
    # That of the frames, which are a crop.
    assert words == (
        'camera_info: the calibration is for 320 x 240 px and the sensor has 2560 x 1600 px; '
        'calibrate that size')
    assert node['services']['uncalibrated'] == [0.0] * 9


def test_a_calibration_is_stored_and_carried_by_the_next_frames(node):
    assert node['services']['calibrated'][0]
    assert node['services']['takes_effect']
    assert node['services']['stored']


def test_the_search_for_the_exposure_streams_on_and_leaves_the_parameters(node):
    services = node['services']
    # The gain of this driver changes nothing in its picture, so that no gain can be right.
    success, words = services['exposure']
    assert not success
    assert '% of full scale' in words
    assert services['frames_meanwhile'] > 10  # 12 frames and 3 for each setting
    assert services['gain'][0] == {'gain': int(services['gain'][1])}


def test_a_camera_that_returns_gets_its_parameters_again(node):
    found = node['unplugged']
    assert found['before'] == ''
    assert found['gone'] and found['waits'] and found['resumed']
    assert "'brightness' is a control of the camera, which is not there" in found['refused']
    assert found['exposure'][0] is False
    assert 'no signal' in found['exposure'][1]
    # contrast was given at the start, the others while running; nobody asked for automatic gain.
    assert found['restored'] == {
        'brightness': '77', 'contrast': '99', 'string': 'xyz', 'gain_automatic': '0'}
    assert found['shown']


def test_the_diagnostics_tell_of_the_stream(node):
    level, message, values = node['diagnostics']
    # An emulated processor may be too slow for all of the frames, and says so.
    assert (level, message) == (0, 'streaming') or 'of the last frames were lost' in message
    assert int(values['frames']) > 0
    for name in ('drops', 'overruns', 'error frames'):
        assert int(values[name]) >= 0
    assert values['exposure time'] == 'unknown'  # vivid has no control of it
    assert values['stamp'] == 'start of the exposure, whose length is unknown'
    assert values['automatic modes on'] == 'none'


def test_wrong_controls_end_the_node_once_the_camera_is_known(node, results):
    assert node['misspelt'] == 2
    log = (results / 'misspelt.log').read_text()
    assert "no parameter 'brigthness'; did you mean 'brightness'?" in log
    assert node['refused'] == 2
    log = (results / 'refused.log').read_text()
    assert "parameter 'brightness': control 'brightness' is 256; it must be a whole number " in log


def test_the_node_ends_without_a_trace(node, results):
    assert node['exit'] == 0
    for name in ('node', 'misspelt', 'refused'):
        assert 'Traceback' not in (results / f'{name}.log').read_text()

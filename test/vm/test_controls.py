"""Controls, mid-exposure stamps, the grabber and injected errors on the kernel's `vivid`."""

from __future__ import annotations

import json
from pathlib import Path
import re
from typing import Any

import numpy as np
import pytest
from vm.hdmi_loop import FRAME_RATE

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself

KINDS = {'int': 'integer', 'int64': 'integer64', 'bool': 'boolean', 'menu': 'menu',
         'intmenu': 'integer_menu', 'bitmask': 'bitmask', 'str': 'string', 'button': 'button'}


@pytest.fixture(scope='module')
def found(results: Path) -> dict[str, Any]:
    """Give what guest_controls.py found."""
    return json.loads((results / 'controls.json').read_text())


def listed(text: str) -> dict[str, dict[str, Any]]:
    """Return the controls that v4l2-ctl -L lists: name -> what it says, with the menu."""
    controls: dict[str, dict[str, Any]] = {}
    for line in text.splitlines():
        head = re.fullmatch(r'\s+(\w+) 0x([0-9a-f]{8}) \((\w+)\)\s*:\s*(.*)', line)
        item = re.fullmatch(r'\t+(\d+): (.*)', line)
        if head:
            name, number, kind, rest = head.groups()
            values, _, flags = rest.partition('flags=')
            current: dict[str, Any] = {
                'number': int(number, 16), 'kind': kind, 'menu': {},
                'flags': [flag.strip() for flag in flags.split(',')]}
            # A compound type has no value of this form.
            for key, value in re.findall(
                    r"\b(min|max|step|default|value)=('.*'|-?\w+)(?!\S)", values):
                is_number = re.fullmatch('-?[0-9]+|0x[0-9a-f]+', value)
                current[key] = int(value, 0) if is_number else value
            controls[name] = current
        elif item:
            current['menu'][item[1]] = item[2]
    return controls


def test_every_control_is_listed_as_v4l2_ctl_does(found):
    ours = found['listing']['controls']
    theirs = {name: control for name, control in listed(found['listing']['v4l2_ctl']).items()
              # Arrays and compound types have no kind that a parameter could be.
              if control['kind'] in KINDS and 'dims' not in control}
    assert len(theirs) > 50
    # In alphabetical order, as classes come in another one.
    assert sorted(ours) == sorted(theirs)
    for name, control in theirs.items():
        mine = ours[name]
        kind = KINDS[control['kind']]
        assert mine['number'] == control['number'], name
        assert mine['kind'] == kind, name
        for key, field in (('min', 'minimum'), ('max', 'maximum'), ('step', 'step'),
                           ('default', 'default')):
            if key in control:
                assert mine[field] == control[key], (name, field)
        if kind == 'integer_menu':  # '5 (0x5)'
            control['menu'] = {key: text.split()[0] for key, text in control['menu'].items()}
        assert mine['menu'] == control['menu'], name
        for flag, field in (('read-only', 'read_only'), ('inactive', 'inactive'),
                            ('volatile', 'volatile')):
            assert mine[field] == (flag in control['flags']), (name, flag)
        if kind == 'bitmask':
            assert mine['value'] == control['value'] & 0xffffffff, name
        elif kind == 'string':
            assert f"'{mine['value']}'" == control['value'], name
        elif kind != 'button' and not mine['volatile']:
            assert mine['value'] == control['value'], name


def test_each_kind_is_set_and_read_back(found):
    assert found['round_trips'] == {
        'brightness': [0, 255, 77],
        'integer_32_bits': [-2147483648, 2147483647],
        'integer_64_bits': [-9223372036854775808, 9223372036854775807, -3],
        'boolean': [0, 1, 0, 1],
        'menu': [1, 4, 3],
        'integer_menu': [2, 8, 8],
        'bitmask': [0, 0x80402010, 0x80000000, 0x400010],
        'string': ['ab', 'abcd', 'ä '],
    }


@pytest.mark.parametrize(('case', 'words'), [
    ('range', "'brightness' is 256; it must be a whole number from 0 to 255"),
    ('range_64', "'integer_64_bits' is 9223372036854775808; it must be a whole number from "
                 '-9223372036854775808 to 9223372036854775807'),
    ('fraction', "'brightness' is 1.5; it must be a whole number from 0 to 255"),
    ('nan', "'brightness' is nan; it must be a whole number from 0 to 255"),
    ('truth', "'brightness' is True; it must be a whole number from 0 to 255"),
    ('text', "'brightness' is 'bright'; it must be a whole number from 0 to 255"),
    ('hole', "'menu' is 2; it must be one of 1 (Menu Item 1), 3 (Menu Item 3), 4 (Menu Item 4)"),
    ('menu_text', "'menu' is 'Menu Item 2'; it must be one of 1 (Menu Item 1), 3 (Menu Item 3), "
                  '4 (Menu Item 4)'),
    ('integer_menu', "'integer_menu' is 1; it must be one of 2 (2), 3 (3), 4 (5), 5 (8), 6 (13), "
                     '7 (21), 8 (42)'),
    ('boolean', "'boolean' is 2; it must be true or false"),
    ('bitmask', "'bitmask' is 1; it must be a whole number whose bits are among those of "
                '0x80402010'),
    ('negative_bitmask', "'bitmask' is -1; it must be a whole number whose bits are among those "
                         'of 0x80402010'),
    ('short_string', "'string' is 'a'; it must be a text of 2 to 4 bytes"),
    ('string_number', "'string' is 12; it must be a text of 2 to 4 bytes"),
    ('button', "'button' is False; it must be true, which presses it"),
    ('read_only', "'read_only_integer_32_bits' is read-only: the driver alone changes it"),
])
def test_a_wrong_value_is_refused_with_what_is_right(found, case, words):
    assert found['refusals'][case] == f'ControlError: control {words}'


def test_an_unknown_control_is_told_with_those_that_there_are(found):
    text = found['refusals']['no_such']
    assert text.startswith("ControlError: there is no control 'exposure_time'; the controls of "
                           '/dev/video0 are ')
    assert text.split(' are ')[1].split(', ') == sorted(found['listing']['controls'])


def test_a_button_has_no_value(found):
    assert found['unreadable'] == ("ControlError: control 'button' cannot be read: it is a "
                                   'button, without a value')


def test_a_control_changes_the_flags_of_another(found):
    effects = found['effects']
    assert effects['True'] == {'inactive': True, 'volatile': True}
    assert effects['False'] == {'inactive': False, 'volatile': False}
    assert effects['gain'] == 33


def test_a_closed_camera_has_no_controls(found):
    assert found['closed'] == 'CaptureError: /dev/video0: the camera is closed; open it again'


# --- stamps ---


def test_a_change_of_the_exposure_holds_from_the_next_exposure_on(found):
    exposures = found['exposures']
    readout = round(exposures['readout_s'] * 1e9)
    units = np.array(exposures['units']) * 100_000
    began, ended = np.array(exposures['changes']).T
    which = []
    for stamp, middle, _ in exposures['seen']:
        # Which of the exposures was used: each puts the middle elsewhere.
        index = [stamp - readout - int(unit) + int(unit) // 2 for unit in units].index(middle)
        start = stamp - readout - int(units[index])
        # Made before the exposure began, and the next one not yet.
        assert index == 0 or start >= began[index]
        if index + 1 < len(units):
            assert stamp - readout - int(units[index + 1]) < ended[index + 1]
        which.append(index)
    assert which == sorted(which)
    assert set(which) == {0, 1, 2, 3}  # also that of another program


def test_stamps_are_in_order_over_changes_of_the_exposure(found):
    exposures = found['exposures']
    assert np.all(np.diff(exposures['frames']) > 0)
    middles = np.array(exposures['seen'])[:, 1]
    # The same in real time but for the clocks' rate: 500 ppm of 2 s.
    assert np.ptp(np.array(exposures['frames'])[-12:] - middles[-12:]) < 1_000_000


def test_the_place_of_the_stamp_is_told_in_words(found):
    exposures = found['exposures']
    assert exposures['place'] == 'middle of the exposure'
    assert exposures['start'] == 'start of the exposure, whose length is unknown'
    assert exposures['start_known'] == 'middle of the exposure'
    unknown = ', later by the time of the readout, which is unknown and taken as 0'
    assert exposures['end'] == f'end of the exposure, whose length is unknown{unknown}'
    assert exposures['end_exposure'] == f'middle of the exposure{unknown}'
    assert exposures['end_known'] == 'middle of the exposure'


# --- grabber ---


def test_a_slow_reader_gets_the_newest_frames_and_the_others_are_counted(found):
    grabbing = found['grabbing']
    # Ten times 0.1 s of sleep at 24 frames/s: one or two frames are replaced each time, fewer
    # only where the machine itself pauses.
    assert grabbing['slow_overruns'] >= 5
    assert np.median(np.diff(grabbing['slow_stamps'])) > 1.5e9 / FRAME_RATE


def test_after_a_stall_of_the_reader_the_frame_is_new(found):
    # Taken while the machine was busy at the worst; of a queue it would be 1 s old.
    assert found['grabbing']['older_than_wake_s'] < 4 / FRAME_RATE + 0.1


def test_after_a_stall_of_the_driver_no_old_frame_comes(found):
    assert found['grabbing']['quiet'].startswith('NoFrameError: /dev/video0: no frame for 0.')
    assert found['grabbing']['after_quiet'] == ''


def test_the_grabber_ends_and_leaves_the_camera(found):
    grabbing = found['grabbing']
    assert grabbing['ended'] is True
    assert grabbing['closed'] == 'CaptureError: /dev/video0: the grabber is closed'
    assert grabbing['camera_lives'] == ''


# --- injected errors ---


@pytest.mark.parametrize(('error', 'words'), [
    ('reqbufs', 'the driver does not give its buffers: Invalid argument; open it again, and if '
                "that does not help see what 'dmesg' says"),
    ('qbuf', 'the driver does not give its buffers: Invalid argument; open it again, and if that '
             "does not help see what 'dmesg' says"),
    ('streamon', 'the driver refuses to begin with these settings; raise buffers, or leave '
                 'width, height and pixel_format to the driver; if the sensor is behind a media '
                 "controller ('media-ctl -p' shows it) its format must be the same as here; "
                 "'dmesg' says more"),
    ('qbuf_running', 'the driver does not take a buffer back: Invalid argument; open it again'),
    ('fatal', 'the driver stopped streaming: Input/output error; open it again'),
    ('disconnect', 'the device is gone (unplugged?); connect it and open it again'),
])
def test_an_error_of_the_driver_is_one_sentence_and_the_device_opens_again(found, error, words):
    injected = found['injections'][error]
    assert injected['sentence'] == f'CaptureError: /dev/video0: {words}'
    assert injected['reopened'] == ''
    if 'again' in injected:  # met while a grabber was reading
        assert injected['again'] == injected['sentence']
        assert injected['ended'] is True


def test_controls_of_a_device_that_is_gone(found):
    assert found['injections']['disconnect']['controls'] == (
        'CaptureError: /dev/video0: the device is gone (unplugged?); connect it and open it again')


def test_spoilt_and_lost_frames_are_ridden_out_and_counted(found):
    # Ten marked as spoilt, of which two may fall on one; half of 30 and more lost.
    assert found['injections']['ridden_out']['drops'] >= 15


# --- exposure search ---


def test_the_search_ends_where_the_driver_shows_it(found):
    outcome = found['search']['found']
    assert outcome['found'] is True
    assert outcome['left'] == [outcome['exposure'], outcome['gain']]
    # White without noise: what was measured is what stays, within the search's own tolerance.
    assert outcome['seen'] == outcome['peak']
    assert outcome['peak'] == pytest.approx(0.7, abs=0.05)


@pytest.mark.parametrize(('case', 'left'), [('too bright', [0, -128]), ('too dark', [255, 128])])
def test_a_search_without_success_says_why(found, case, left):
    outcome = found['search'][case]
    assert outcome['found'] is False
    assert outcome['words'].startswith(f'{case}: the lit peak is at ')
    assert outcome['left'] == left


# --- soak ---


@pytest.fixture(scope='module')
def soak(results: Path) -> dict[str, Any]:
    """Give what guest_soak.py found."""
    return json.loads((results / 'soak.json').read_text())


def test_nothing_grows_while_streaming(soak):
    first, *others = soak['samples']
    assert len(others) > 10
    for sample in others:
        assert sample['fds'] == first['fds']
        assert sample['device_maps'] == first['device_maps'] == 4  # the ring
        # Pages of the interpreter's here and there, 1.3 MB at most so far; one leaked frame in
        # ten, of 77 kB each, would be 4 MB.
        assert sample['maps'] <= first['maps'] + 2
        assert sample['rss'] <= first['rss'] + 2_000_000


def test_nothing_is_left_by_opening_again(soak):
    before, after = soak['reopened']['before'], soak['reopened']['after']
    assert after['fds'] == before['fds']
    assert after['device_maps'] == before['device_maps'] == 0
    assert after['rss'] <= before['rss'] + 1_000_000


def test_every_frame_is_accounted_for_and_in_order(soak):
    assert soak['ordered'] is True
    # The first and the last may be counted at one side only.
    lost = soak['numbers'] - soak['frames'] - soak['overruns'] - soak['drops']
    assert abs(lost) <= 3
    assert soak['numbers'] == pytest.approx(soak['seconds'] * FRAME_RATE, rel=0.02)


def test_frames_never_fall_behind(soak):
    # An emulated processor is away for a second now and then; a backlog would stay. In each ten
    # seconds a frame comes within its interval, as it does when none waits before it.
    best = [sample['best_lag_ms'] for sample in soak['samples']]
    for begin in range(0, len(best) - 9, 10):
        assert min(best[begin:begin + 10]) < 1e3 / FRAME_RATE
    assert soak['median_lag_ms'] < 1e3 * soak['ring_s']

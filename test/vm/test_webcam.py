"""V4l2Camera on the kernel's `uvcvideo` and a webcam with faults: what guest_webcam.py saw."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from vm.webcam import FRAME_RATE

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself
INTERVAL = 1.0 / FRAME_RATE  # s
CONTROLS = {'brightness': 128, 'contrast': 32, 'gain': 10, 'auto_exposure': 3,
            'exposure_time_absolute': 156}


@pytest.fixture(scope='module')
def found(results) -> dict[str, Any]:
    """Give what guest_webcam.py found."""
    return json.loads((results / 'webcam.json').read_text())


def column(scenario: dict[str, Any], name: str) -> np.ndarray:
    """Return one value of all frames."""
    return np.array([frame[name] for frame in scenario['frames']])


@pytest.mark.parametrize('name', ['sound', 'bulk'])
def test_a_sound_webcam_is_read_whole(found, name):
    webcam = found[name]
    assert webcam['controls'] == CONTROLS
    assert webcam['frame_rate'] == FRAME_RATE
    number = column(webcam, 'number')
    assert (column(webcam, 'greys') == 1).all()  # no frame has parts of two
    assert (np.diff(number) > 0).all()
    # A busy machine may lose some, and knows it: but for the first, while an interval is unknown.
    lost = np.diff(number)[5:].sum() - len(number[6:])
    assert abs(column(webcam, 'drops')[-1] - lost) <= 2


def test_stamps_keep_the_frame_rate(found):
    webcam = found['sound']
    # On a busy machine single ones are late by more than an interval.
    interval = np.median(np.diff(column(webcam, 'stamp_ns'))) / 1e9
    assert interval == pytest.approx(INTERVAL, rel=0.15)
    assert webcam['place'] == (
        'end of the exposure, whose length is unknown, as far as the camera sends it at once')


def test_frames_that_are_lost_on_the_bus_are_counted(found):
    webcam = found['lost']
    # The driver's numbers tell nothing.
    number = column(webcam, 'number')
    assert np.ptp(column(webcam, 'sequence')) == len(number) - 1
    # Each lost frame takes the next along, whose mark is that of the one before.
    assert not {9, 10, 14, 15, 20, 21} & set(number.tolist())
    lost = number[-1] - number[0] + 1 - len(number)
    assert abs(column(webcam, 'drops')[-1] - lost) <= 2


def test_a_webcam_that_marks_no_end_loses_no_frames(found):
    webcam = found['endless']
    number = column(webcam, 'number')
    lost = number[-1] - number[0] + 1 - len(number)
    # One that was counted twice each time would have 25 more. Stamped as the next one begins, they
    # jitter by whole intervals on a busy machine.
    assert abs(column(webcam, 'drops')[-1] - lost) <= 5


def test_a_webcam_that_sends_headers_while_it_waits_has_no_sure_stamp(found):
    webcam = found['chatter']
    age = (column(webcam, 'read_ns') - column(webcam, 'stamp_ns')) / 1e9
    # Stamped as the frame before ended.
    assert np.median(age) > 0.8 * INTERVAL
    assert webcam['place'] == (
        'start of the transfer, or the end of that before, as the camera seems to send without a '
        'pause')


@pytest.mark.parametrize(('name', 'words'), [
    ('without its time', 'end of the exposure, whose length is unknown, as far as the camera '
     'sends it at once'),
    ('with its time', 'start of the exposure, whose length is unknown'),
])
def test_the_metadata_tell_whether_hwtimestamps_are(found, name, words):
    before, after = found[name]['places']
    assert before.endswith(
        'if the camera sends its own time, else near the start of the transfer')
    assert after == words


def test_stamps_in_real_time_are_taken_as_such(found):
    # Not cut at the reading, and no years: as old as the transfer is long, and what a busy machine
    # adds.
    assert np.median(found['in real time']) == pytest.approx(0.02, abs=0.5 * INTERVAL)


def test_a_webcam_that_is_unplugged(found):
    device = found['bulk']['device']
    assert found['unplugged'] == (
        f'{device}: the device is gone (unplugged?); connect it and open it again')


@pytest.mark.parametrize(('name', 'missing'), [
    ('stalled minimum', 'contrast'), ('silent', 'contrast'), ('no mode', 'auto_exposure')])
def test_a_control_that_does_not_answer_hides_no_other(found, name, missing):
    controls = dict(CONTROLS)
    del controls[missing]
    assert found[name]['controls'] == controls


def test_a_silent_control_costs_its_seconds_once(found):
    assert found['silent']['listing_s'] < 4.0  # the driver waits for 5 s


def test_an_exposure_that_cannot_be_read_or_is_governed_unseen_is_unknown(found):
    assert found['stalled value']['exposure_time'] is None
    assert found['no mode']['exposure_time'] is None

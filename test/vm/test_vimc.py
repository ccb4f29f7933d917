"""Cameras behind a media controller, on the kernel's `vimc`: what guest_vimc.py wrote down."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from vm.guest_vimc import COLOUR, DEBAYER, HEIGHT, INPUT, RAW, SCALER, SENSOR, WIDTH

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself
OF_SENSOR = {'brightness', 'contrast', 'saturation', 'hue', 'horizontal_flip', 'vertical_flip',
             'test_pattern', 'show_information'}
DO_NOT_FIT = (
    'the links or formats between its sensor and this device do not fit each other (media '
    "controller); 'media-ctl -p' shows them: set the format of each pad, up to this device, to "
    'the same size and to the code of pixel_format with media-ctl --set-v4l2, and do the same on '
    'every other enabled path from its sensor, up to the other video devices (v4l2-ctl '
    '--set-fmt-video)')


@pytest.fixture(scope='module')
def vimc(results: Path) -> dict[str, Any]:
    """Give what guest_vimc.py found."""
    return json.loads((results / 'vimc.json').read_text())


@pytest.mark.parametrize('case', ['as loaded', 'another size', 'another code', 'another way'])
def test_formats_that_do_not_fit_are_told_with_what_sets_them(vimc, case):
    assert vimc['refusals'][case] == f"{vimc['devices'][RAW]}: {DO_NOT_FIT}"


def test_formats_that_fit_are_taken(vimc):
    assert vimc['refusals']['all fit'] == ''


def test_a_link_that_is_off_is_told(vimc):
    assert vimc['ways']['off'] == f"{vimc['devices'][COLOUR]}: {DO_NOT_FIT}"


@pytest.mark.parametrize(('entity', 'feeds', 'words'), [
    (SENSOR, [RAW, COLOUR], 'its pictures come from {}: name that, its controls are found by '
                            'themselves'),
    ('Sensor B', ['Raw Capture 1'], 'its pictures come from {}: name that'),
    ('Debayer B', [], "its link to a video device is not enabled: see 'media-ctl -p', and "
                      'media-ctl --links'),
    ('Lens A', [], 'no pictures come from it, as from a lens or a flash: name the video device '
                   'of its camera'),
])
def test_a_subdevice_is_named_with_what_to_take_in_its_place(vimc, entity, feeds, words):
    devices = vimc['devices']
    come = words.format(' or '.join(devices[each] for each in feeds))
    assert vimc['subdevices'][entity].startswith(
        f'{devices[entity]}: this is a subdevice, {entity}; {come}')


def test_a_subdevice_whose_link_is_switched_off(vimc):
    assert 'its link to a video device is not enabled' in vimc['ways']['off, subdevice']


@pytest.mark.parametrize(('pixel_format', 'full', 'red'), [
    ('RGGB', 255, (0, 0)), ('GRBG', 255, (0, 1)), ('BG10', 1023, (1, 1))])
def test_a_mosaic_comes_through_as_it_is(vimc, pixel_format, full, red):
    found = vimc['mosaics'][pixel_format]
    assert found['shape'] == [HEIGHT, WIDTH]
    assert (found['layout'], found['saturation']) == (
        {'RGGB': 'rggb', 'GRBG': 'grbg', 'BG10': 'bggr'}[pixel_format], full)
    expected = np.zeros((2, 2), int)
    expected[red] = full
    assert found['flat']
    assert found['places'] == expected.tolist()


def test_its_frames_have_stamps_and_no_rate(vimc):
    for found in vimc['mosaics'].values():
        assert (np.diff(found['stamps']) > 0).all()
        assert found['frame_rate'] == 0.0  # the driver tells none


def test_the_controls_of_the_sensor_and_of_what_is_on_the_way_are_found(vimc):
    devices = vimc['devices']
    sensor, controls = vimc['ways']['linked']
    assert sensor == f'{SENSOR} ({devices[SENSOR]}, {devices[DEBAYER]}, {devices[SCALER]})'
    assert set(controls) == OF_SENSOR | {'debayer_mean_window_size'}


def test_the_sensor_is_the_one_whose_link_is_enabled(vimc):
    assert vimc['ways']['another'].startswith(f'{INPUT} (')


def test_they_are_parameters_of_the_node(vimc):
    node = vimc['node']
    assert node['starts']
    assert set(node['names']) > OF_SENSOR
    assert node['at the start'] == [{'brightness': 99}, 99]
    assert node['change'] == ''
    assert node['changed'] == 55
    assert 'out of range' in node['refused']
    assert node['followed']


def test_the_diagnostics_name_the_sensor(vimc):
    _, _, values = vimc['node']['diagnostics']
    assert values['sensor'] == f"{SENSOR} ({vimc['devices'][SENSOR]})"


def test_the_node_ends_without_a_trace(vimc, results):
    assert vimc['node']['exit'] == 0
    log = (results / 'vimc.log').read_text()
    assert f'streaming {WIDTH} x {HEIGHT} px at an unknown rate from' in log
    assert 'Traceback' not in log

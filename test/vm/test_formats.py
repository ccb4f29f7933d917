"""Pixel formats, sizes, multi-planar buffers and crops on the kernel's own driver, bit by bit."""

from __future__ import annotations

import json
from typing import Any

import pytest
from vm.hdmi_loop import SIGNAL

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself

BAYER = {'RGGB': 510, 'GB10': 2046, 'GR16': 65535}
SATURATION = {
    'Y10': 1023, 'Y16': 65535, 'Y16-BE': 65535,
    # vivid has the default quantisation, which is limited range for YUV
    'UYVY': 235, 'NV12': 235,
    'RGB3': 255, 'BGR4': 255, **BAYER,
}
SENSOR = list(SIGNAL)  # of which the frames are a part


@pytest.fixture(scope='module')
def formats(results) -> dict[str, Any]:
    """Give what guest_formats.py found."""
    return json.loads((results / 'formats.json').read_text())


def assert_seen(found: dict[str, Any]) -> None:
    """Every pixel of the frames is the one that was played."""
    assert found['shape'] == found['expected_shape']
    assert found['right'] == found['wanted']


@pytest.mark.parametrize('name', SATURATION)
def test_pixels_are_those_that_were_played(formats, name):
    found = formats['planar'][name]
    assert_seen(found)
    assert found['saturation'] == SATURATION[name]
    assert found['dtype'] == ('uint8' if SATURATION[name] <= 255 else 'uint16')
    assert found['binning'] == ([2, 2] if name in BAYER else [1, 1])
    # Without its scaler the driver takes the top left of the signal.
    assert found['place'] == [0, 0]
    assert found['sensor_size'] == SENSOR


def test_yuv_of_full_range_clips_at_its_end(formats):
    assert formats['full_range_saturation'] == 255


def test_several_sizes(formats):
    assert len({tuple(found['size']) for found in formats['planar'].values()}) >= 4


@pytest.mark.parametrize('name', ['Y16', 'NV12', 'NM12'])
def test_a_multi_planar_device(formats, name):
    assert_seen(formats['multi_planar'][name])


def test_padding_between_lines_is_left_out(formats):
    assert_seen(formats['padded'])


def test_a_crop_is_known(formats):
    found = formats['selections']['crop']
    assert_seen(found)
    assert (found['place'], found['binning']) == ([64, 40], [1, 1])
    assert found['sensor_size'] == SENSOR


def test_a_scaler_of_whole_pixels_is_binning(formats):
    found = formats['selections']['scaled']
    assert_seen(found)
    assert (found['place'], found['binning']) == ([64, 40], [2, 3])
    assert found['sensor_size'] == SENSOR


def test_a_scaled_bayer_frame_is_binned_by_both(formats):
    halved, bayer = formats['selections']['halved'], formats['selections']['halved_bayer']
    assert halved == {'place': [0, 0], 'binning': [2, 2], 'sensor_size': SENSOR}
    assert bayer == {'place': [0, 0], 'binning': [4, 4], 'sensor_size': SENSOR}


def test_a_crop_that_is_scaled_otherwise_is_refused(formats):
    assert formats['selections']['not_whole'] == (
        '/dev/video0: its crop of 320x360 is scaled to frames of 304x240, which is not a whole '
        "number of pixels each; choose frames of the crop's size, or another crop (v4l2-ctl "
        '--set-selection)')


def test_a_whole_sensor_that_is_scaled_otherwise_is_a_sensor_of_its_own(formats):
    assert formats['selections']['whole'] == {
        'place': [0, 0], 'binning': [1, 1], 'sensor_size': [400, 240]}

"""The camera and the whole tracker on a real V4L2 driver, the kernel's own `vivid`."""

from __future__ import annotations

import json
from typing import Any

from blob_tracker.capture import PIXEL_FORMATS
import numpy as np
import pytest
from vm.hdmi_loop import FRAME_RATE, HEIGHT, WIDTH
from vm.scene import CX, CY, FRAMES, FX, FY

# Per axis: six of the 0.013 px that the noise of the scene leaves to a fit at its bound. Lit
# places are 18 px apart and more: no other place can pass.
TOLERANCE = 0.08  # px
DEVICES = '/dev/video0 (vivid), /dev/video2 (vivid)'

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself


@pytest.fixture(scope='module')
def capture(results) -> dict[str, Any]:
    """Give what guest_capture.py found."""
    return json.loads((results / 'capture.json').read_text())


@pytest.fixture(scope='module')
def track(results) -> dict[str, Any]:
    """Give what guest_track.py found."""
    return json.loads((results / 'track.json').read_text())


# --- V4l2Camera ---


@pytest.fixture(params=['GREY', 'YUYV'])
def recording(request, capture) -> dict[str, Any]:
    """Give the frames that were read in one pixel format."""
    return capture[request.param]


def column(recording: dict[str, Any], name: str) -> np.ndarray:
    """Return one value of all frames."""
    return np.array([frame[name] for frame in recording['frames']])


def test_frames_are_those_of_the_scene_bit_by_bit(recording):
    index = column(recording, 'index')
    assert len(index) == recording['count']
    assert index.min() >= 0
    # The loop leaves frames out and repeats others, but not half of them.
    assert len(set(index)) > FRAMES / 2


def test_size_and_rate_are_the_drivers(recording):
    assert recording['size'] == [WIDTH, HEIGHT]
    assert recording['shape'] == [HEIGHT, WIDTH]
    assert recording['dtype'] == 'uint8'
    # vivid's levels of YUV are of limited range.
    assert recording['saturation'] == (255 if recording['pixel_format'] == 'GREY' else 235)
    assert recording['frame_rate'] == pytest.approx(FRAME_RATE, rel=1e-6)


def test_stamps_are_real_time_and_grow(recording):
    stamp, read = column(recording, 'stamp_ns'), column(recording, 'read_ns')
    assert np.all(np.diff(stamp) > 0)
    # Stamped at the start of a frame, which is before it is read: but for 1 ms of the clocks'
    # bracket on a machine that is emulated. A wrong clock is off by decades.
    lag = (read - stamp) / 1e9
    assert lag.min() > -1e-3
    assert lag.max() < 1.0


def test_stamps_run_at_the_frame_rate(recording):
    stamp, sequence = column(recording, 'stamp_ns'), column(recording, 'sequence')
    interval = (stamp[-1] - stamp[0]) / 1e9 / (sequence[-1] - sequence[0])
    # Both ends may be late by half a frame on a busy machine.
    assert interval * FRAME_RATE == pytest.approx(1.0, abs=1.0 / len(stamp))


def test_drops_are_the_holes_in_the_drivers_numbers(recording):
    sequence, drops = column(recording, 'sequence'), column(recording, 'drops')
    assert np.array_equal(np.diff(drops), np.diff(sequence) - 1)


def test_frames_that_the_driver_loses_are_counted(capture):
    losses = capture['losses']
    # Half of them are lost while 20 are read: as many again, and none at all once in a million.
    assert losses['half_lost'] > 0
    assert losses['lost'] == losses['numbers'] - losses['read_after_first']


def test_spoilt_pictures_are_left_out(capture):
    # One is marked before each of 20 readings; two marks fall on one picture where the reader is
    # late and a picture is waiting already.
    assert capture['losses']['spoilt'] >= 10


def test_the_first_frame_after_a_stall_is_a_new_one(capture):
    # Four frames wait in the driver's ring from 1.5 s before; such a frame would be 1.3 s old.
    # The longest wait that is not left out is the ring's own length.
    assert capture['losses']['older_than_wake_s'] < 4 / FRAME_RATE + 0.1


def test_silence_is_told_and_does_not_end_the_camera(capture):
    assert capture['losses']['quiet'] == '/dev/video0: no frame for 0.5 s'
    assert capture['losses']['after_quiet'] == ''


@pytest.mark.parametrize(('case', 'sentence'), [
    ('missing', '/dev/video7: there is no such device; capture devices here: ' + DEVICES),
    ('output', '/dev/video1: this is an output device, not a capture device; '
               'capture devices here: ' + DEVICES),
    ('media', '/dev/media0: this is not a V4L2 device; '
              'capture devices here: ' + DEVICES),
    ('format_unknown', "pixel_format 'GREI' cannot be decoded; choose one of "
                       + ', '.join(PIXEL_FORMATS)),
    ('size', '/dev/video0: 20000x240 is not offered; the driver gives 16384x240 instead'),
    ('busy', '/dev/video0: the device is busy: another program streams from it, or has chosen its '
             "format and keeps it open; end that program ('fuser -v /dev/video0' names it)"),
    ('permission', '/dev/video0: permission denied: it belongs to root:video with mode 0660; run '
                   "'sudo usermod -aG video nobody' and log in again"),
    ('no_signal', '/dev/video0: input HDMI 0 has no signal: connect the source and switch it on'),
    ('no_lock', '/dev/video0: input HDMI 0 has a signal it cannot lock to: check the cable and '
                'the source'),
    ('signal_lost', '/dev/video0: no frame for 0.5 s: input HDMI 0 has no signal: connect the '
                    'source and switch it on'),
    ('fatal', '/dev/video0: the driver stopped streaming: Input/output error; open it again'),
    ('unplugged', '/dev/video0: the device is gone (unplugged?); connect it and open it again'),
])
def test_a_device_that_cannot_be_used_is_named_with_the_remedy(capture, case, sentence):
    assert capture['sentences'][case] == sentence


def test_a_format_that_is_not_offered_is_refused_with_those_that_are(capture):
    sentence = capture['sentences']['format_not_offered']
    begin = ("/dev/video0: pixel_format 'MJPG' is not offered; of the formats that this device "
             'offers, ')
    assert sentence.startswith(begin)
    names = sentence.removeprefix(begin).removesuffix(' can be decoded').split(', ')
    assert {'GREY', 'YUYV', 'Y16-BE', 'NV12', 'RGB3', 'BYR2'} < set(names) < set(PIXEL_FORMATS)


@pytest.mark.parametrize('case', ['link', 'free_again', 'plugged_again'])
def test_a_device_that_can_be_used_is_opened(capture, case):
    assert capture['sentences'][case] == ''


# --- camera, segmenter and locator: three processes, then one ---


@pytest.fixture(params=['clean', 'lossy'])
def half(request, track) -> dict[str, Any]:
    """Give what came from the three processes, and from the one after it was unplugged."""
    return track[request.param]


def nearest(places: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return for each place the index of the nearest true one, and its (dx, dy)."""
    offsets = places[:, None, :] - truth[None, :, :]
    index = np.hypot(offsets[..., 0], offsets[..., 1]).argmin(axis=1)
    return index, offsets[np.arange(len(index)), index]


def test_every_bearing_is_that_of_a_lit_place(half, track, scene):
    assert len(half['bearings']) >= track['count']
    # Back onto the pinhole's image plane, px: azimuth = atan2(X, Z), elevation =
    # atan2(-Y, hypot(X, Z)).
    _, azimuth, elevation, zero, _ = np.array(half['bearings']).T / 1e3
    places = np.column_stack([
        CX + FX * np.tan(azimuth), CY - FY * np.tan(elevation) / np.cos(azimuth)])
    index, offset = nearest(places, scene.lit)
    assert np.abs(offset).max() < TOLERANCE
    # The light was seen all along its path. Where the machine is so busy that bearings come at
    # random, 30 of them leave two places in the average out, and six once in a thousand times.
    assert len(set(index)) > len(scene.lit) - 6
    assert np.all(zero == 0.0)


def test_every_centroid_is_a_lit_place(half, track, scene):
    # The last bearing ends the recording and may come before its centroid.
    assert len(half['centroids']) >= track['count'] - 1
    _, offset = nearest(np.array(half['centroids'])[:, 1:3], scene.lit)
    assert np.abs(offset).max() < TOLERANCE


def test_a_bearing_and_its_centroid_share_their_stamp(half):
    bearings = {message[0] for message in half['bearings']}
    centroids = {message[0] for message in half['centroids']}
    # The first and the last may be torn apart by the ends of the recording.
    assert len(bearings & centroids) >= len(bearings) - 2


def test_bearings_come_in_order_and_soon(half):
    stamp = np.array([message[0] for message in half['bearings']])
    received = np.array([message[-1] for message in half['bearings']])
    assert np.all(np.diff(stamp) > 0)
    # Emulated processors take their time; another clock would be off by years.
    lag = (received - stamp) / 1e9
    assert lag.min() > 0.0
    assert lag.max() < 60.0


def test_an_unplugged_camera_is_told_and_taken_up_again(track, results):
    gone = '/dev/video0: the device is gone (unplugged?); connect it and open it again'
    assert any(text.startswith('/camera') and gone in text for text in track['complaints'])
    assert (results / 'pipeline.log').read_text().count('streaming') == 2


def test_nodes_end_without_a_trace(track, results):
    for name, (code, _) in track['exits'].items():
        assert code == 0, name
        assert 'Traceback' not in (results / f'{name}.log').read_text()

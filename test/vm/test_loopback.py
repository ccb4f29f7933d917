"""V4l2Camera on v4l2loopback and the programs that write into it: what guest_loopback.py saw."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from blob_tracker.capture import videodev2
import numpy as np
import pytest
from vm.guest_loopback import ASKED_RATE, EXCLUSIVE, OPEN, OTHER_SIZE
from vm.machine import DEBIAN, LOOPBACKS

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself
DEVICES = {'exclusive': EXCLUSIVE, 'open': OPEN}
AGE = 0.5  # s: far below the seconds by which another clock is off


@pytest.fixture(scope='module')
def found(results: Path) -> dict[str, dict[str, Any]]:
    """Give what guest_loopback.py found, by version."""
    return json.loads((results / 'loopback.json').read_text())


@pytest.fixture(params=range(len(LOOPBACKS[DEBIAN])))
def loopback(request, found) -> dict[str, Any]:
    """Give what was found of one version, with its number."""
    name = sorted(found)[request.param]
    return found[name] | {'version': name.removeprefix('v4l2loopback-')}


@pytest.fixture(params=DEVICES)
def device(request, loopback) -> dict[str, Any]:
    """Give what was found of one device of it, with its path."""
    return loopback[request.param] | {
        'path': DEVICES[request.param],
        'locked': loopback['version'] < '0.13' and request.param == 'exclusive'}


def column(frames: list[dict[str, int]], name: str) -> np.ndarray:
    """Return one value of all frames."""
    return np.array([frame[name] for frame in frames])


def left_out(frames: list[dict[str, int]]) -> int:
    """Return how many numbers the driver gave to no picture."""
    number = column(frames, 'number')
    lost = np.ptp(number) + 1 - len(number)
    return int(np.ptp(column(frames, 'drops')) - lost)


def most_left_out(version: str) -> int:
    """Return how many they may be: one where the reader comes late, and in 0.12 one more."""
    return 2 if version < '0.13' else 1


def age(frames: list[dict[str, int]]) -> np.ndarray:
    """Return how old frames are when they are read, s."""
    return (column(frames, 'read_ns') - column(frames, 'stamp_ns')) / 1e9


def test_both_versions_of_the_driver_are_there(found):
    assert len(found) == len(LOOPBACKS[DEBIAN])


def test_a_device_without_a_writer_says_what_to_do(device):
    assert device['no writer'] == (
        f"{device['path']}: no program writes pictures into this v4l2loopback device yet; start "
        'the one that does, such as ffmpeg -f v4l2 or GStreamer with v4l2sink')


def test_what_is_written_is_read_whole_and_in_order(loopback, device):
    frames = device['frames']
    assert (column(frames, 'greys') == 1).all()  # no frame has parts of two
    number = column(frames, 'number')
    assert (np.diff(number) > 0).all()
    assert 0 <= left_out(frames) <= most_left_out(loopback['version'])


def test_stamps_are_monotonic_though_version_0_12_does_not_say_so(loopback, device):
    told = 0 if loopback['version'] < '0.13' else videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC
    assert set(device['clocks']) == {told}
    assert (age(device['frames']) > 0.0).all()
    assert np.median(age(device['frames'])) < AGE


def test_the_rate_is_that_of_the_writer_whatever_is_granted(loopback, device):
    # 0.12 keeps its own 30; later ones grant whatever is asked for.
    granted = 30.0 if loopback['version'] < '0.13' else ASKED_RATE
    assert device['frame_rate'] == granted
    # On a busy machine the writer keeps no pace: what it wrote meanwhile is counted.
    begin, *_, end = device['stamps_ns']
    begun = np.array(device['begun_ns'])
    written = np.count_nonzero((begin < begun) & (begun < end))
    numbers = round(1e-9 * (end - begin) * device['measured_rate'])
    assert 0 <= numbers - written <= most_left_out(loopback['version'])


def test_a_writer_that_has_ended_is_told(device):
    assert device['gone'] == (
        f"NoFrameError: {device['path']}: no frame for {device['patience']:.1f} s: the program "
        'that writes into this v4l2loopback device has stopped; start it again')


def test_another_writer_may_take_over_with_the_same_size(device):
    frames = device['taken over']
    assert (np.diff(column(frames, 'number')) > 0).all()
    assert column(frames, 'number')[0] < column(device['frames'], 'number')[-1]
    assert np.median(age(frames)) < AGE
    assert device['other size meanwhile'] == 'it is given 160x120'


def test_the_next_writer_may_have_another_size_or_it_is_said_why_not(device):
    if device['locked']:
        assert device['writer'] == 'Invalid argument'
        assert device['gone for long'].startswith(
            f"{device['path']}: the program that wrote into this v4l2loopback device has ended, "
            'and version 0.12 lets no other one write after it (exclusive_caps=1); load the '
            "module again ('sudo modprobe -r v4l2loopback'")
    else:
        assert 'no program writes pictures' in device['gone for long']
        assert device['other size'] == list(OTHER_SIZE)
        assert (np.diff(column(device['frames of it'], 'number')) > 0).all()


@pytest.mark.parametrize('stamps', ['left out', 'monotonic'])
def test_mapped_buffers_with_stamps_of_the_monotonic_clock_are_read(loopback, stamps):
    frames = loopback['queued'][stamps]
    assert (np.diff(column(frames, 'number')) > 0).all()
    assert (column(frames, 'greys') == 1).all()
    assert np.median(age(frames)) < AGE


def test_stamps_of_another_clock_are_refused(loopback):
    assert loopback['queued']['since the start'] == (
        f'{OPEN}: its frames are not stamped with the monotonic clock, so that their time is '
        'unknown; use a driver that does, and have a program that writes into v4l2loopback leave '
        'the stamps to it')

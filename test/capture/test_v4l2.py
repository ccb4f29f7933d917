"""What a camera says where there is none; streaming itself runs in test/vm on a real driver."""

import os
import tempfile

from blob_tracker.capture import CaptureError, V4l2Camera
from blob_tracker.capture.device import capture_devices
import pytest


def message(device, **settings):
    with pytest.raises(CaptureError) as error:
        V4l2Camera(device=str(device), **settings)
    text = str(error.value)
    assert '\n' not in text
    return text


def test_missing_device_lists_those_that_are_there(tmp_path):
    path = tmp_path / 'video7'
    text = message(path)
    assert text.startswith(f'{path}: there is no such device; ')
    devices = capture_devices()
    if devices:
        assert all(f'{device} ({name})' in text for device, name in devices.items())
    else:
        assert text.endswith('this machine has no capture device that can be opened')


def test_dangling_link_is_a_missing_device(tmp_path):
    link = tmp_path / 'usb-Camera-video-index0'
    link.symlink_to(tmp_path / 'video7')
    assert f'{link}: there is no such device' in message(link)


def test_regular_file_is_not_a_device(tmp_path):
    path = tmp_path / 'scene.raw'
    path.write_bytes(b'not a camera')
    assert f'{path}: this is not a V4L2 device' in message(path)


def test_other_character_device_is_not_a_v4l2_device():
    assert '/dev/null: this is not a V4L2 device' in message('/dev/null')


def test_folder_is_not_a_device(tmp_path):
    assert f'{tmp_path}: this is not a V4L2 device' in message(tmp_path)


@pytest.fixture
def locked():
    """Give a file that this user may not open."""
    # Not tmp_path, whose folders another user may not enter.
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o755)
        path = os.path.join(folder, 'video0')
        with open(path, 'wb'):
            pass
        os.chmod(path, 0o000)
        user = os.geteuid()
        if user == 0:  # whom no mode keeps out
            os.seteuid(65534)
        yield path
        os.seteuid(user)


def test_no_permission_names_the_owner_and_the_mode(locked):
    text = message(locked)
    assert text.startswith(f'{locked}: permission denied: it belongs to ')
    assert 'with mode 0000' in text


@pytest.mark.parametrize('buffers', [0, 1, 33])
def test_senseless_ring(buffers):
    assert f'buffers is {buffers}; it must be 2 to 32' == message('/dev/null', buffers=buffers)


def test_a_refused_device_is_not_left_open():
    before = os.listdir('/proc/self/fd')
    message('/dev/null')
    assert os.listdir('/proc/self/fd') == before

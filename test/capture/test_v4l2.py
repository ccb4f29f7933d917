"""What a camera says where there is none or a bad one; test/vm streams from a real driver."""

import errno
import mmap
import os
import select
import tempfile

from blob_tracker.capture import CaptureError, NoFrameError, V4l2Camera, videodev2
from blob_tracker.capture.clock import RealtimeClock
from blob_tracker.capture.device import capture_devices
from blob_tracker.capture.format import StreamFormat
from blob_tracker.capture.frame_count import FrameCount
from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.signal import Signal
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


class Spoiling(V4l2Camera):
    """A camera whose driver gives so many pictures, each marked as spoilt or cut short."""

    def __init__(self, spoilt, cut_short):
        self.device = '/dev/video0'
        self.error_frames = 0
        self._flags = [videodev2.BUF_FLAG_ERROR] * spoilt + [0] * cut_short
        self._memory = [mmap.mmap(-1, 64)]
        self._count, self._clock = FrameCount(numbered=True), RealtimeClock()
        self._format = StreamFormat(
            videodev2.BUF_TYPE_VIDEO_CAPTURE, 'GREY', 8, 8, 8, 255, PIXEL_FORMATS['GREY'].luma)
        self._signal = Signal(self._call)
        self._fd, self._into = os.pipe()  # nothing ever comes through it
        self._poll = select.poll()
        self._poll.register(self._fd, select.POLLIN)

    def _call(self, number, argument):
        if number == videodev2.DQBUF:
            if not self._flags:
                raise BlockingIOError
            argument.flags = self._flags.pop()
            argument.bytesused = 63
        elif number != videodev2.QBUF:
            raise OSError(errno.ENOTTY, 'Inappropriate ioctl for device')

    def close(self):
        os.close(self._fd)
        os.close(self._into)


@pytest.mark.parametrize(('spoilt', 'cut_short', 'words'), [
    (0, 0, 'no frame for 0.0 s'),
    (0, 1, '1 picture came, all spoilt or cut short'),
    (2, 3, '5 pictures came, all spoilt or cut short'),
])
def test_pictures_that_are_all_spoilt_are_told(spoilt, cut_short, words):
    with Spoiling(spoilt, cut_short) as camera:
        with pytest.raises(NoFrameError) as error:
            camera.read(0.01)
        assert str(error.value) == f'/dev/video0: {words}'
        # Those were of that wait.
        with pytest.raises(NoFrameError, match='/dev/video0: no frame for 0.0 s'):
            camera.read(0.01)

"""What a camera says where there is none or a bad one; test/vm streams from a real driver."""

import errno
import mmap
import os
import tempfile
import time

from blob_tracker.capture import CaptureError, NoFrameError, V4l2Camera, videodev2
from blob_tracker.capture.clock import RealtimeClock
from blob_tracker.capture.device import capture_devices
from blob_tracker.capture.device_controls import DeviceControls
from blob_tracker.capture.field_dealer import FieldDealer
from blob_tracker.capture.format import StreamFormat
from blob_tracker.capture.frame_count import FrameCount
from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.ring import Ring
from blob_tracker.capture.signal import Signal
import numpy as np
import pytest
from support.v4l2_driver import Driver


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
        self._controls = DeviceControls(self.device, self._call)
        self._count, self._clock = FrameCount(numbered=True), RealtimeClock()
        self._format = StreamFormat(
            videodev2.BUF_TYPE_VIDEO_CAPTURE, 'GREY', 8, 8, 8, 255, PIXEL_FORMATS['GREY'].luma)
        self._signal = Signal(self._call)
        self._dealer = FieldDealer(self.fields, stamps_end=True)
        self._fd, self._into = os.pipe()  # nothing ever comes through it
        self._ring = Ring(self._call, self._fd, self.device, self._trouble)
        self._ring.memory.append(mmap.mmap(-1, 64))

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


def test_words_of_a_sensor_of_fewer_bits_clip_below_full_scale(tmp_path, monkeypatch):
    # 12 bits in the upper ones of Y16.
    driver = Driver(formats=['Y16'])
    image = (np.arange(64, dtype='<u2').reshape(8, 8) * 65) << 4
    image[0, 0] = 4095 << 4
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(device) as camera:
        driver.filled = [(time.monotonic_ns(), 0, 'none', image.tobytes())]
        frame = camera.read()
    assert frame.saturation == camera.saturation == 65520
    np.testing.assert_array_equal(frame.image, image)  # DN as they come


# --- interlaced pictures ---

LINES_625, LINES_525 = 0xff, 0xb000  # PAL and NTSC
FIELD_NS = {LINES_625: 20_000_000, LINES_525: 1001 * 1_000_000_000 // 60_000}
READOUT_NS = {  # of the lines of a field, by ITU-R BT.601
    LINES_625: round(288 * 64e3), LINES_525: round(240 * 1001e9 / 30000 / 525)}
WHOLE = np.repeat(np.arange(8, dtype=np.uint8)[:, None], 8, axis=1)  # lines of their numbers
START = videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC | videodev2.BUF_FLAG_TSTAMP_SRC_SOE


def woven_stream(driver, count=3):
    """Fill so many pictures from a while ago on; return their stamps."""
    begin = time.monotonic_ns() // 1000 * 1000 - 10**8
    stamps = [begin + 2 * each * FIELD_NS[driver.standard] // 1000 * 1000 for each in range(count)]
    driver.filled = [
        (stamp, 5 + each, driver.field, WHOLE.tobytes()) for each, stamp in enumerate(stamps)]
    return stamps


@pytest.mark.parametrize(('standard', 'first'), [(LINES_625, 0), (LINES_525, 1)])
@pytest.mark.parametrize('flags', [START, videodev2.BUF_FLAG_TIMESTAMP_MONOTONIC])
def test_the_fields_of_a_picture_are_frames(tmp_path, monkeypatch, standard, first, flags):
    # NTSC begins at the bottom. A driver that stamps the end has stamped that of the second field.
    driver = Driver(field='interlaced', standard=standard, flags=flags)
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(
            device, buffers=32) as camera:
        stamps = woven_stream(driver)
        frames = [camera.read() for _ in range(6)]
    field_ns = FIELD_NS[standard]
    assert camera.frame_rate == pytest.approx(1e9 / field_ns)
    assert camera.sensor_size == (8, 8)
    offset = frames[0].stamp_ns - stamps[0]
    for index, frame in enumerate(frames):
        kind = first if index % 2 == 0 else 1 - first
        np.testing.assert_array_equal(frame.image, WHOLE[kind::2][:3])
        assert (frame.y0, frame.binning) == (kind, (1, 2))
        wanted = stamps[index // 2] + index % 2 * field_ns + offset
        assert frame.stamp_ns == pytest.approx(wanted, abs=1e6)  # the clocks' bracket
    before = time.time_ns() - time.monotonic_ns() - offset  # of the stamp
    wanted = 0 if flags == START else field_ns + READOUT_NS[standard]
    assert before == pytest.approx(wanted, abs=5e6)


@pytest.mark.parametrize('counts_pictures', [True, False])
def test_fields_that_come_one_by_one(tmp_path, monkeypatch, counts_pictures):
    # Each buffer says which it holds. Drivers count pictures, and some fields.
    driver = Driver(field='alternate', size=(8, 4), standard=LINES_625, flags=START)
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(
            device, buffers=32) as camera:
        begin = time.monotonic_ns() // 1000 * 1000 - 3 * 10**8
        driver.filled = [
            (begin + index * FIELD_NS[LINES_625], index // 2 if counts_pictures else index,
             ('top', 'bottom')[index % 2], WHOLE[index % 2::2].tobytes())
            for index in range(12) if index != 7]
        frames = [camera.read() for _ in range(11)]
    assert camera.frame_rate == 50.0
    assert camera.drops == 1
    assert camera.sensor_size == (8, 8)
    assert [frame.y0 for frame in frames] == [0, 1, 0, 1, 0, 1, 0, 0, 1, 0, 1]
    assert all(frame.binning == (1, 2) and frame.image.shape == (3, 8) for frame in frames)
    assert frames[-1].stamp_ns - frames[0].stamp_ns == pytest.approx(
        11 * FIELD_NS[LINES_625], abs=1e6)


def test_a_field_without_a_name_ends_the_stream(tmp_path, monkeypatch):
    driver = Driver(field='alternate', size=(8, 4), standard=LINES_625)
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(device) as camera:
        driver.filled = [(time.monotonic_ns(), 0, 'alternate', WHOLE[::2].tobytes())]
        with pytest.raises(CaptureError, match="the driver calls a field 'alternate', not top or"):
            camera.read()


def test_a_lost_picture_is_two_fields(tmp_path, monkeypatch):
    driver = Driver(field='seq_tb', standard=LINES_625)
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(device) as camera:
        woven_stream(driver, 4)
        del driver.filled[2]
        frames = [camera.read() for _ in range(6)]
    assert camera.drops == 2
    assert np.all(np.diff([frame.stamp_ns for frame in frames]) > 0)


def test_what_v4l2loopback_stamps_anew_is_left_out(tmp_path, monkeypatch):
    # Of a program that has long been writing; version 0.12 gave that picture a number and a stamp
    # as the camera asked for buffers.
    driver = Driver(name='v4l2 loopback', size=(8, 8))
    stale = time.monotonic_ns()
    with driver.at(tmp_path / 'video0', monkeypatch) as device, V4l2Camera(device) as camera:
        begin = time.monotonic_ns()
        driver.filled = [(stale, 0, 'none', bytes([1]) * 64)] + [
            (begin + 10**7 * index, 72_000 + index, 'none', bytes([2 + index]) * 64)
            for index in range(3)]
        frames = [camera.read() for _ in range(3)]
    assert [frame.image.max() for frame in frames] == [2, 3, 4]
    assert camera.drops == 0

"""Cameras that are missing, taken, not allowed or of no use, and one that streams."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import blob_tracker
from blob_tracker.capture import videodev2
from blob_tracker.capture.fields import FieldStream
from blob_tracker.capture.topology import Sensor
from blob_tracker.commands.doctor import cameras
from blob_tracker.commands.doctor.finding import Level, ok
from blob_tracker.types import Frame
import numpy as np
import pytest
from support.findings import one, told


class Webcam:
    """A driver that answers what the doctor asks."""

    def __init__(
        self, capabilities: int, formats: dict[str, list[tuple[int, int]]],
        driver: bytes = b'uvcvideo',
    ) -> None:
        self.capabilities, self.driver = capabilities, driver
        self.formats = formats

    def __call__(self, fd: int, number: int, argument: Any) -> None:
        if number == videodev2.QUERYCAP:
            argument.driver, argument.card = self.driver, b'HD Webcam'
            argument.bus_info, argument.capabilities = b'usb-0000:00:14.0-1', self.capabilities
            return
        assert number in (videodev2.ENUM_FMT, videodev2.ENUM_FRAMESIZES)  # nothing that changes it
        if number == videodev2.ENUM_FMT:
            names = list(self.formats)
            if argument.index < len(names):
                argument.pixelformat = videodev2.fourcc(names[argument.index])
                return
        else:
            sizes = self.formats[videodev2.fourcc_name(argument.pixel_format)]
            if argument.index < len(sizes):
                argument.type = videodev2.FRMSIZE_TYPE_DISCRETE
                # width and height, where v4l2_frmsizeenum has them for this type
                argument.min_width, argument.max_width = sizes[argument.index]
                return
        raise OSError(errno.EINVAL, 'Invalid argument')


STREAMS = videodev2.CAP_VIDEO_CAPTURE | videodev2.CAP_STREAMING
FORMATS = {'YUYV': [(640, 480), (320, 240)], 'H264': [(1920, 1080)]}


def devices(folder: Path) -> Path:
    """Make /dev with a camera in it, and a link by its name."""
    (folder / 'v4l' / 'by-id').mkdir(parents=True)
    (folder / 'video2').touch()
    (folder / 'v4l' / 'by-id' / 'usb-HD_Webcam').symlink_to(folder / 'video2')
    return folder


def test_no_camera(tmp_path: Path) -> None:
    """It is said where one would be."""
    told(cameras.check_cameras(tmp_path, tmp_path), Level.WARN, f'no {tmp_path}/video*', 'dmesg')
    told(cameras.check_camera('/dev/no_such_camera'), Level.ERROR, 'there is no such device')
    told(cameras.check_camera('/dev/null'), Level.ERROR, 'not a V4L2 device')
    told(cameras.check_stream('/dev/null'), Level.ERROR, 'not a V4L2 device')


def test_camera_with_its_formats(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Name, driver, bus, the link that stays, and what can be read of it."""
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS))
    found = one(cameras.check_cameras(devices(tmp_path), tmp_path / 'proc'))
    assert found == ok(
        'camera',
        f'{tmp_path}/video2: HD Webcam (uvcvideo, usb-0000:00:14.0-1), '
        f'{tmp_path}/v4l/by-id/usb-HD_Webcam: YUYV 640x480, 320x240',
    )


def test_a_sensor_behind_a_media_controller_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the subdevice that has its controls."""
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS, b'unicam'))
    monkeypatch.setattr(
        'blob_tracker.capture.sensor.of_video_device',
        lambda fd: (Sensor('imx219 10-0010', ((81, 5),)), ['/dev/v4l-subdev0']))
    found = one(cameras.check_cameras(devices(tmp_path), tmp_path / 'proc'))
    assert ', sensor imx219 10-0010 (/dev/v4l-subdev0): YUYV' in found.message


def test_cameras_that_cannot_be_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No format that can be read; no camera at all, which many have beside them."""
    folder = devices(tmp_path)
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, {'H264': [(640, 480)]}))
    told(cameras.check_cameras(folder, tmp_path), Level.ERROR, '(H264) can be read; one of ',
         '--list-formats-ext')
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(videodev2.CAP_META_CAPTURE, {}))
    told(cameras.check_cameras(folder, tmp_path), Level.OK, 'a metadata device, no pictures')
    loopback = Webcam(videodev2.CAP_VIDEO_OUTPUT, {}, b'v4l2 loopback')
    monkeypatch.setattr(videodev2, 'ioctl', loopback)
    told(cameras.check_cameras(folder, tmp_path), Level.WARN, 'no program writes pictures')
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(0, {}, b'v4l2 loopback'))
    told(cameras.check_cameras(folder, tmp_path), Level.WARN, 'lets no other one write')


def test_camera_that_another_program_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the name and number of the process."""
    folder = devices(tmp_path)
    (tmp_path / 'proc' / '4711' / 'fd').mkdir(parents=True)
    (tmp_path / 'proc' / '4711' / 'comm').write_text('guvcview\n')
    (tmp_path / 'proc' / '4711' / 'fd' / '7').symlink_to(folder / 'video2')
    (tmp_path / 'proc' / '4712').mkdir()  # one that may not be looked into
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS))
    told(cameras.check_cameras(folder, tmp_path / 'proc'), Level.WARN, 'open in guvcview (4711)',
         'fuser -v')


def test_camera_that_may_not_be_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The group to join is named."""
    folder = devices(tmp_path)
    os.chmod(folder / 'video2', 0o660)
    stat = os.stat  # making it root's takes root

    def refuse(path: str, flags: int) -> int:
        raise PermissionError(errno.EACCES, 'Permission denied')

    def of_root_and_video(path: str, **options: Any) -> os.stat_result:
        status = stat(path, **options)
        if str(path) != f'{folder}/video2':
            return status
        return os.stat_result((*status[:4], 0, 44, *status[6:]))

    monkeypatch.setattr('blob_tracker.capture.device.os.open', refuse)
    monkeypatch.setattr('blob_tracker.capture.device.os.stat', of_root_and_video)
    told(cameras.check_cameras(folder, tmp_path), Level.ERROR, 'permission denied',
         'sudo usermod -aG video')


@pytest.mark.parametrize('drops, level, order, words', [
    (0, Level.OK, 'none', ''), (3, Level.WARN, 'none', ''),
    (0, Level.OK, 'seq_tb', ', fields top before bottom, one above the other'),
])
def test_frames_of_a_camera(
    drops: int, level: Level, order: str, words: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Their size, rate and brightness, after what the device says of itself."""

    class Stream:
        width, height, pixel_format, saturation = 640, 480, 'YUYV', 235
        fields = FieldStream(order, 480)
        stamp_ns = 0

        def __init__(self, path: str) -> None:
            self.drops = drops

        def __enter__(self) -> Stream:
            return self

        def __exit__(self, *error: object) -> None:
            pass

        def read(self, timeout: float) -> Frame:
            Stream.stamp_ns += 40_000_000
            return Frame(np.full((480, 640), 99, np.uint8), Stream.stamp_ns, 235)

    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS))
    monkeypatch.setattr(blob_tracker.capture, 'V4l2Camera', Stream)
    device, stream = cameras.check_stream(f'{devices(tmp_path)}/video2')
    assert device.level is Level.OK
    assert stream.level is level
    assert f'640x480 YUYV{words} at 25.0 frames/s, {drops} lost' in stream.message
    assert 'the brightest pixel 99 of 235 DN' in stream.message

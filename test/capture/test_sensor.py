"""The controls of a sensor's subdevice beside those of the video device that it feeds."""

from __future__ import annotations

import errno
import os
import time
from typing import Any

from blob_tracker.capture import CaptureError, device_controls, V4l2Camera, videodev2
from blob_tracker.capture.control_events import ControlEvents
from blob_tracker.capture.controls import controls, get_control, set_control
from blob_tracker.capture.device import open_capture_device
from blob_tracker.capture.sensor import ControlRoute
from blob_tracker.capture.topology import Sensor
import pytest
from support.v4l2_driver import Driver

# An OV9281 at 1280 x 800 px, 10 bits on two lanes: 60 Hz
HBLANK, VBLANK, PIXEL_RATE = 176, 1022, 160_000_000
SENSOR = {
    videodev2.CID_EXPOSURE: ('Exposure', 800), videodev2.CID_VBLANK: ('Vertical Blanking', VBLANK),
    videodev2.CID_HBLANK: ('Horizontal Blanking', HBLANK),
    videodev2.CID_ANALOGUE_GAIN: ('Analogue Gain', 16),
    videodev2.CID_PIXEL_RATE: ('Pixel Rate', PIXEL_RATE),
}


class Part:
    """A device with integer controls: number -> (text, value)."""

    def __init__(self, known: dict[int, tuple[str, int]]) -> None:
        self.texts = {number: text for number, (text, _) in known.items()}
        self.values = {number: value for number, (_, value) in known.items()}
        self.events: list[int] = []

    def __call__(self, number: int, argument: Any) -> None:
        if number == videodev2.QUERY_EXT_CTRL:
            last = argument.id & ~videodev2.CTRL_FLAG_NEXT_CTRL
            later = sorted(each for each in self.texts if each > last)
            if not later:
                raise OSError(errno.EINVAL if self.texts else errno.ENOTTY, 'no more')
            argument.id = later[0]
            argument.name = self.texts[later[0]].encode()
            argument.type, argument.maximum, argument.step = 1, 10**9, 1
        elif number in (videodev2.G_EXT_CTRLS, videodev2.S_EXT_CTRLS):
            control = argument.controls[0]
            if number == videodev2.S_EXT_CTRLS:
                self.values[control.id] = control.value.value
            control.value.value = self.values[control.id]
        elif number == videodev2.SUBSCRIBE_EVENT:
            assert argument.id in self.texts
        elif number == videodev2.DQEVENT:
            if not self.events:
                raise OSError(errno.ENOENT, 'no event')
            argument.id = self.events.pop(0)
        else:
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))


def test_two_devices_have_their_controls_as_one():
    video, sensor = Part({videodev2.CID_GAIN: ('Gain', 3)}), Part(SENSOR)
    route = ControlRoute([video, sensor])
    found = controls(route)
    assert set(found) == {
        'gain', 'exposure', 'vertical_blanking', 'horizontal_blanking', 'analogue_gain',
        'pixel_rate'}
    assert get_control(route, found['gain']) == 3
    assert get_control(route, found['vertical_blanking']) == VBLANK
    set_control(route, found['exposure'], 100)
    assert sensor.values[videodev2.CID_EXPOSURE] == 100


def test_the_control_of_the_video_device_counts():
    # A driver that hands its sensor's on.
    video = Part({videodev2.CID_EXPOSURE: ('Exposure', 1)})
    sensor = Part(SENSOR)
    route = ControlRoute([video, sensor])
    found = controls(route)
    assert len(found) == len(SENSOR)
    set_control(route, found['exposure'], 7)
    assert video.values[videodev2.CID_EXPOSURE] == 7
    assert sensor.values[videodev2.CID_EXPOSURE] == 800


def test_events_of_either_are_taken():
    video, sensor = Part({}), Part(SENSOR)
    route = ControlRoute([video, sensor])
    events = ControlEvents(route, controls(route).values())
    assert events.told
    sensor.events = [videodev2.CID_EXPOSURE, videodev2.CID_HBLANK]
    assert set(events.take()) == {videodev2.CID_EXPOSURE, videodev2.CID_HBLANK}


@pytest.fixture
def behind_a_controller(tmp_path, monkeypatch):
    """Give a camera whose sensor is another device, and that sensor."""
    driver, sensor = Driver(size=(1280, 800), errors={'G_PARM': errno.ENOTTY}), Part(SENSOR)
    subdevice = tmp_path / 'v4l-subdev0'
    subdevice.touch()
    # Undone before the driver's own.
    with driver.at(tmp_path / 'video0', monkeypatch) as device, monkeypatch.context() as patch:
        patch.setattr(
            device_controls, 'of_video_device',
            lambda fd: (Sensor('ov9281 10-0060', ((81, 5),)), [str(subdevice)]))

        def kernel(fd: int, number: int, argument: Any) -> None:
            if os.readlink(f'/proc/self/fd/{fd}') == str(subdevice):
                sensor(number, argument)
            else:
                driver(fd, number, argument)

        patch.setattr(videodev2, 'ioctl', kernel)
        before = os.listdir('/proc/self/fd')
        with V4l2Camera(device, line_time=None) as camera:
            yield camera, driver, sensor
        assert os.listdir('/proc/self/fd') == before


def test_line_time_exposure_and_rate_are_those_of_the_sensor(behind_a_controller):
    camera, driver, sensor = behind_a_controller
    line = (1280 + HBLANK) / PIXEL_RATE
    assert camera.sensor.startswith('ov9281 10-0060 (')
    assert camera.line_time == pytest.approx(line)
    assert camera.exposure_time == pytest.approx(800 * line, rel=1e-6)
    assert camera.exposure_unit == pytest.approx(line)
    assert camera.frame_rate == pytest.approx(60.3, abs=0.1)
    camera.set_control('exposure', 400)
    assert sensor.values[videodev2.CID_EXPOSURE] == 400
    camera.set_control('vertical_blanking', VBLANK + 1822)  # twice as many lines
    assert camera.frame_rate == pytest.approx(30.15, abs=0.1)
    driver.filled = [(time.monotonic_ns(), 0, 'none', bytes(1280 * 800))]
    frame = camera.read()
    assert frame.line_time_ns == pytest.approx(1e9 * line)


def test_a_subdevice_that_is_given_as_the_device_is_told(tmp_path, monkeypatch):
    path = tmp_path / 'v4l-subdev0'
    path.touch()
    for videos, words in (
        (['/dev/video0'], 'its pictures come from /dev/video0: name that'),
        ([], "its link to a video device is not enabled: see 'media-ctl -p'"),
        (None, 'no pictures come from it, as from a lens or a flash: name the video device'),
    ):
        monkeypatch.setattr(
            'blob_tracker.capture.device.of_subdevice', lambda path: ('imx219 10-0010', videos))
        with pytest.raises(CaptureError, match='this is a subdevice, imx219 10-0010; ' + words):
            open_capture_device(str(path))

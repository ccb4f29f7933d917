"""The camera node without a usable camera: it says why, publishes nothing, and lives on."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from math import nan
from pathlib import Path
import time
from types import SimpleNamespace
from typing import Any

from blob_tracker.camera import CameraModel
from blob_tracker.capture import CaptureError, NoFrameError
from blob_tracker.nodes import camera as nodes_camera
from blob_tracker.ros.endpoints.frame_topics import FrameTopics
from blob_tracker.types import Frame
import cv2
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
import pytest
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo, Image
from sensor_msgs.srv import SetCameraInfo
from support.processes import PATIENCE, Probe, probe, start
from support.slowness import slowness


@pytest.mark.parametrize(
    'device, sentence',
    [
        ('/dev/no_such_camera', '/dev/no_such_camera: there is no such device'),
        ('/dev/null', '/dev/null: '),
        (str(Path(__file__)), 'test_camera.py: '),
    ],
)
def test_no_camera_is_a_diagnostic_and_not_the_end(
    device: str, sentence: str, domain: int
) -> None:
    """ERROR with the device's name, again and again, while the node tries again."""
    with probe(domain) as node:
        images = node.record(Image, 'camera/image_raw')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with start('camera', domain, device=device) as process:
            node.spin_until(
                lambda: sum(
                    a.status[0].level == DiagnosticStatus.ERROR
                    and sentence in a.status[0].message
                    for a in diagnostics
                )
                >= 2
            )
            assert process.running
    assert not images
    assert process.output.count(sentence) <= 3  # throttled: once in 5 s
    assert 'Traceback' not in process.output


def camera_info(**changes: object) -> CameraInfo:
    """Return the camera_info of a calibrated camera with something changed."""
    info = CameraInfo(
        width=640, height=480, distortion_model='plumb_bob', d=[0.1, -0.02, 0.001, 0.002, 0.0],
        k=[601.0, 0.0, 312.5, 0.0, 603.0, 245.5, 0.0, 0.0, 1.0],
    )
    for name, value in changes.items():
        setattr(info, name, value)
    return info


@pytest.fixture
def ros_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give an empty folder where the nodes of this test keep calibrations."""
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    return tmp_path


def set_camera_info(node: Probe, info: CameraInfo) -> SetCameraInfo.Response:
    """Call the service and return its answer."""
    request = SetCameraInfo.Request(camera_info=info)
    return node.call(SetCameraInfo, 'camera/set_camera_info', request)


def test_a_calibration_is_stored_where_the_next_start_finds_it(
    domain: int, ros_home: Path
) -> None:
    """In ROS' usual place and form, under the camera's name; the device need not be there."""
    path = ros_home / 'camera_info' / 'left.yaml'
    with probe(domain) as node, start(
        'camera', domain, device='/dev/no_such_camera', camera_name='left'
    ):
        answer = set_camera_info(node, camera_info())
        assert (answer.success, answer.status_message) == (True, f'stored in {path} and in use')
        assert list(ros_home.rglob('*.yaml')) == [path]
    model = CameraModel.from_file(path)
    assert model.name == 'left'
    assert (model.width, model.height) == (640, 480)
    assert model.matrix.ravel().tolist() == camera_info().k.tolist()
    assert model.distortion.tolist() == list(camera_info().d)


def test_impossible_calibrations_are_refused_and_not_stored(domain: int, ros_home: Path) -> None:
    """The answer says what is wrong, and what was stored before stays."""
    with probe(domain) as node, start('camera', domain, device='/dev/no_such_camera'):
        assert set_camera_info(node, camera_info()).success
        before = (ros_home / 'camera_info' / 'camera.yaml').read_bytes()
        for changes, sentence in (
            ({'k': [0.0] * 9}, 'the focal lengths are 0 and 0 px; both must be above 0'),
            ({'k': [nan] * 9}, 'K must be 3 x 3 finite numbers'),
            ({'width': 0}, 'the calibrated size is 0 x 480 px; it must be positive'),
            ({'distortion_model': 'magic'}, "no distortion model 'magic'"),
            ({'d': [0.1]}, "distortion model 'plumb_bob' has "),
        ):
            answer = set_camera_info(node, camera_info(**changes))
            assert not answer.success
            assert answer.status_message.startswith(f'camera_info: {sentence}')
        assert (ros_home / 'camera_info' / 'camera.yaml').read_bytes() == before


def test_a_calibration_that_cannot_be_stored_is_refused(domain: int, ros_home: Path) -> None:
    """A file stands where the folder must be."""
    (ros_home / 'camera_info').write_text('')
    with probe(domain) as node, start('camera', domain, device='/dev/no_such_camera'):
        answer = set_camera_info(node, camera_info())
    assert not answer.success
    assert answer.status_message.startswith(
        f'cannot write the calibration {ros_home}/camera_info/camera.yaml: '
    )


def test_a_parameter_that_is_not_the_nodes_waits_for_the_camera(domain: int) -> None:
    """Only the camera knows whether that is one of its controls; a list is none of any."""
    with probe(domain) as node:
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with start('camera', domain, device='/dev/no_such_camera', gain=5) as process:
            node.spin_until(lambda: diagnostics)
            assert process.end() == 0
    assert '/dev/no_such_camera: there is no such device' in process.output
    with start('camera', domain, device='/dev/no_such_camera', gain='[1, 2]') as process:
        assert process.wait() == 2
    assert "parameter 'gain' is [1, 2]; a control of the camera has one number" in process.output


def test_another_device_is_opened_at_once_and_a_wrong_calibration_refused(domain: int) -> None:
    """The diagnostics name the new device; what is refused leaves the node as it was."""
    with probe(domain) as node, start('camera', domain, device='/dev/no_such_camera') as camera:
        diagnostics = node.record(DiagnosticArray, '/diagnostics')

        def put(name: str, value: object) -> SetParametersResult:
            request = SetParameters.Request(
                parameters=[Parameter(name, value=value).to_parameter_msg()]
            )
            return node.call(SetParameters, 'camera/set_parameters', request).results[0]

        def says(words: str) -> bool:
            return any(words in each.status[0].message for each in diagnostics)

        node.spin_until(lambda: says('/dev/no_such_camera: there is no such device'))
        refused = put('camera_info_url', 'file:///no/such/file.yaml')
        assert not refused.successful
        assert refused.reason.startswith("parameter 'camera_info_url': ")
        assert put('device', '/dev/another_camera').successful
        node.spin_until(lambda: says('/dev/another_camera: there is no such device'))
        assert camera.running


class FakeStream:
    """Stands for the camera and its grabber: gives frames until there are none, then fails."""

    width, height, frame_rate, device = 8, 6, 29.97, '/dev/fake'
    stamp_place, pixel_format, saturation, sensor_size = 'somewhere', 'GREY', 255, (8, 6)
    drops, error_frames, overruns, exposure_time = 3, 5, 0, None
    control_changes, tells_changes, pixel_aspect = 0, True, 1.0
    fields: object = 'none, whole pictures'
    line_time: float | None = 0.0
    measured_rate = 0.0
    sensor = ''
    read_time: float | None = 1.25e-5
    frames = 0
    kinds: tuple[tuple[int, tuple[int, int]], ...] = ((0, (1, 1)),)  # y0 and binning, in turn
    error: Exception = OSError(5, 'Input/output error')
    opened: list[float] = []

    def __init__(self, *args: object, **settings: object) -> None:
        if settings:
            self.opened.append(time.monotonic())
        self.controls: dict[str, object] = {}

    def __enter__(self) -> FakeStream:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def newest(self, timeout: float) -> Frame:
        """Return a frame or raise."""
        if self.frames:
            self.frames -= 1
            y0, binning = self.kinds[self.frames % len(self.kinds)]
            image = np.zeros(((7 - binning[1]) // binning[1], 8), np.uint8)
            return Frame(image, time.time_ns(), 255, y0=y0, binning=binning)
        raise self.error


@pytest.fixture
def told(
    domain: int, ros_home: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., Any]:
    """Give a function that runs the node on a fake stream until something is reported."""
    def run(until: Callable[[Any], bool], *arguments: str, **changes: object) -> Any:
        stream: Any = type('Stream', (FakeStream,), {'opened': [], **changes})
        monkeypatch.setattr(nodes_camera, 'V4l2Camera', stream)
        monkeypatch.setattr(nodes_camera, 'Grabber', stream)
        rclpy.init(args=['--ros-args', *arguments], domain_id=domain)
        node = nodes_camera.CameraNode()
        try:
            deadline = time.monotonic() + PATIENCE * slowness()
            while not until(found := SimpleNamespace(
                opened=len(stream.opened), words=list(node._health._messages.values()),
                values=dict(node._health._values), pause=node._pause,
                alive=node._thread.is_alive(),
            )):
                assert time.monotonic() < deadline, found
                time.sleep(0.01)
        finally:
            node.destroy_node()
            rclpy.shutdown()
        return found

    return run


@pytest.mark.parametrize('error', [
    OSError(5, 'Input/output error'), BufferError('exported pointers'), cv2.error('resize'),
    RuntimeError('odd'), CaptureError('stopped'),
])
def test_whatever_fails_is_told_and_the_device_is_opened_again(
    told: Callable[..., Any], error: Exception
) -> None:
    """The node is never left alive and silent; without a frame it waits longer each time."""
    found = told(lambda now: now.opened > 1 and now.words, error=error)
    assert found.alive
    assert str(error) in found.words[0]
    assert found.pause > nodes_camera.FIRST_PAUSE_S


def test_the_first_frame_ends_the_backing_off(told: Callable[..., Any]) -> None:
    """Each opening gives a frame here, so that the pause never grows beyond the second."""
    found = told(lambda now: now.opened > 2, frames=1)
    assert found.pause <= 2.0 * nodes_camera.FIRST_PAUSE_S  # just before or after a frame


def test_losses_are_told_while_no_frame_comes(told: Callable[..., Any]) -> None:
    """Spoilt pictures alone come from a bad cable."""
    found = told(lambda now: 'drops' in now.values, error=NoFrameError('no frame'))
    assert (found.values['drops'], found.values['error frames']) == (3, 5)


@pytest.mark.parametrize('asked, warned', [('60.0', True), ('30.0', False), ('0.0', False)])
def test_another_frame_rate_than_asked_for_is_told(
    told: Callable[..., Any], asked: str, warned: bool
) -> None:
    """29.97 Hz is what drivers call 30."""
    sentence = 'frame_rate is 60 Hz and the driver gives 29.97 Hz'
    found = told(lambda now: any('not calibrated' in each for each in now.words)
                 and (now.values.get('frames', 0) > 3),
                 '-p', f'frame_rate:={asked}', frames=10**6)
    assert any(sentence in each for each in found.words) == warned


@pytest.mark.parametrize('asked, measured, warned', [
    ('0.0', 29.97, False), ('0.0', 28.7, False), ('0.0', 15.0, True), ('0.0', 0.0, False),
    ('15.0', 15.0, False),  # who set it knows; that the driver says otherwise is told by itself
])
def test_another_rate_than_was_granted_is_told(
    told: Callable[..., Any], asked: str, measured: float, warned: bool
) -> None:
    """By more than 5 %, as a long exposure does, or the writer of v4l2loopback."""
    found = told(lambda now: any('not calibrated' in each for each in now.words)
                 and (now.values.get('frames', 0) > 3),
                 '-p', f'frame_rate:={asked}', frames=10**6, measured_rate=measured)
    assert any('frames come at 15 Hz by their stamps' in each for each in found.words) == warned


@pytest.mark.parametrize(('arguments', 'line_time', 'shown', 'warned'), [
    ((), 0.0, '0, a global shutter; the device reads a line in 12.5000 us', False),
    (('-p', 'line_time:=3.0e-05'), 3e-5, '30.0000 us, as line_time is set', False),
    (('-p', 'rolling_shutter:=true'), 1.25e-5, '12.5000 us, by hblank and pixel_rate', False),
    (('-p', 'rolling_shutter:=true'), None, 'unknown, taken as 0', True),
])
def test_the_line_time_is_told_and_where_it_is_from(
    told: Callable[..., Any], arguments: tuple[str, ...], line_time: float | None, shown: str,
    warned: bool,
) -> None:
    """As set, as the device tells, or none."""
    found = told(lambda now: now.values.get('frames', 0) > 1 and now.words, *arguments,
                 frames=10**6, line_time=line_time)
    assert found.values['line time'].startswith(shown)
    assert any('rolling_shutter is on' in each for each in found.words) == warned


def test_each_field_has_a_camera_info_of_its_own(
    told: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Top and bottom take turns; pixels of an analogue camera are not square."""
    published: list[tuple[Frame, CameraInfo]] = []
    monkeypatch.setattr(
        FrameTopics, 'publish',
        lambda self, frame, info, frame_id: published.append((frame, copy(info)))
    )
    found = told(lambda now: len(published) > 4, '-p', 'field_of_view:=40.0', frames=10**6,
                 kinds=((0, (1, 2)), (1, (1, 2))), pixel_aspect=0.5, fields='top before bottom')
    assert found.values['fields'] == 'top before bottom'
    for frame, info in published:
        assert (info.roi.y_offset, info.binning_x, info.binning_y) == (frame.y0, 1, 2)
        assert info.roi.height == 2 * len(frame.image)
        assert info.k[4] == 2.0 * info.k[0]

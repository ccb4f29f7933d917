"""The camera node without a usable camera: it says why, publishes nothing, and lives on."""

from __future__ import annotations

from math import nan
from pathlib import Path

from blob_tracker.camera import CameraModel
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from processes import Probe, probe, start
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo, Image
from sensor_msgs.srv import SetCameraInfo


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
    model = CameraModel.from_yaml(path)
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
            ({'d': [0.1]}, 'plumb_bob has '),
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


def test_the_nodes_own_parameters_stay_as_they_were_read(domain: int) -> None:
    """Another device or size takes effect at the next start only."""
    with probe(domain) as node, start('camera', domain, device='/dev/no_such_camera'):
        request = SetParameters.Request(
            parameters=[Parameter('device', value='/dev/video1').to_parameter_msg()]
        )
        answer = node.call(SetParameters, 'camera/set_parameters', request)
    assert not answer.results[0].successful
    assert 'read-only' in answer.results[0].reason

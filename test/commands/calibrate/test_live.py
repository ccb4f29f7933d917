"""Measuring live: centroids and joints on real topics, stations typed in or led through."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event, Thread

from blob_tracker.__main__ import main
from blob_tracker.calibration.turn import project
from blob_tracker.camera import CameraModel, pinhole_matrix
from geometry_msgs.msg import PointStamped
import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from sensor_msgs.msg import JointState

CAMERA = CameraModel(640, 480, pinhole_matrix(612.0, 640, 480))


class Rig:
    """A servo with a camera and a light, which says where it sees the light."""

    def __init__(self) -> None:
        self.pan, self.tilt = 0.0, 0.0  # rad
        self.lit = True

    def centroid(self, random: np.random.Generator) -> tuple[float, float]:
        """Return x, y, px."""
        pixels = project(CAMERA, np.array([self.pan]), np.array([self.tilt]), target=(0.0, 0.0))
        x, y = pixels[0] + 0.05 * random.standard_normal(2)
        return float(x), float(y)


@pytest.fixture
def rig(domain: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    """Publish the rig's centroids and joints until the test ends."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
    made, ended = Rig(), Event()
    thread = Thread(target=publish, args=(made, ended, domain))
    thread.start()
    yield made
    ended.set()
    thread.join()


def publish(rig: Rig, ended: Event, domain: int) -> None:
    """Publish at 200 Hz, in a context beside that of the command."""
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node('rig', context=context)
    centroids = node.create_publisher(PointStamped, 'target/centroid', 10)
    joints = node.create_publisher(JointState, 'joint_states', 10)
    random = np.random.default_rng(1)
    while not ended.wait(0.005):
        if rig.lit:
            message = PointStamped()
            message.point.x, message.point.y = rig.centroid(random)
            centroids.publish(message)
        joints.publish(JointState(name=['tilt', 'pan'], position=[rig.tilt, rig.pan]))
    node.destroy_node()
    context.try_shutdown()


def answers(
    monkeypatch: pytest.MonkeyPatch, words: list[str], moved: Callable[[int], None]
) -> list[str]:
    """Answer the questions in turn, after moving the rig; return the questions."""
    asked: list[str] = []

    def answer(question: str) -> str:
        index = len(asked)
        asked.append(question)
        if index >= len(words):
            raise EOFError
        moved(index)
        return words[index]

    monkeypatch.setattr('builtins.input', answer)
    return asked


def test_joints_give_the_angles(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The servo's own angles go into the file, and out comes the camera."""
    grid = [(pan, tilt) for pan in np.linspace(-0.4, 0.4, 4) for tilt in (-0.25, 0.0, 0.25)]

    def moved(index: int) -> None:
        rig.pan, rig.tilt = grid[index]

    answers(monkeypatch, [''] * len(grid), moved)
    file, out = tmp_path / 'turn.csv', tmp_path / 'camera_info.yaml'
    words = ['calibrate', 'turn', str(file), '--live', '--joints', 'pan,tilt', '--count', '10']
    assert main([*words, '--size', '640x480', '--one-f', '--out', str(out)]) == 0
    lines = file.read_text().splitlines()
    assert lines[0] == 'pan_mrad,tilt_mrad,x,y,sigma_x,sigma_y'
    assert len(lines) == 1 + len(grid)
    pan, tilt, *_, sigma = (float(word) for word in lines[1].split(','))
    assert (pan, tilt) == pytest.approx((-400.0, -250.0), abs=1e-3)
    assert 0.003 < sigma < 0.05  # 0.05 px over ten: 0.016, and its own scatter
    # 12 stations of 0.016 px over 400 px of reach: 612 px to better than 0.1 px.
    assert CameraModel.from_file(out).matrix[0, 0] == pytest.approx(612.0, abs=0.5)


def test_led_through_stopped_and_gone_on_with(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The next station is named; what was measured stays when it is stopped, and is gone on."""
    file = tmp_path / 'slide.csv'
    steps = np.linspace(0.0, 40.0, 5)
    words = ['calibrate', 'slide', str(file), '--live', '--slide', '0:40:5', '--count', '10']

    def moved(index: int) -> None:
        rig.pan = steps[index] / 1e3

    asked = answers(monkeypatch, ['', '', 'q'], moved)
    assert main(words) == 1
    assert asked[0].startswith('station 1 of 5: slide to 0 mm; Enter')
    assert 'read at 2 positions; 4 or more' in capsys.readouterr().err
    assert len(file.read_text().splitlines()) == 3
    asked = answers(monkeypatch, [''] * 3, lambda index: moved(index + 2))
    assert main(words) == 0
    assert asked[0].startswith('station 3 of 5: slide to 20 mm')
    captured = capsys.readouterr()
    assert 'going on after the 2 stations' in captured.err
    assert [float(line.split(',')[0]) for line in file.read_text().splitlines()[1:]] == [*steps]
    # tan: 612 px per rad, a thousandth of it per mm.
    assert '0.61' in captured.out


def test_a_file_with_nothing_but_its_header_is_gone_on_with(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Which is left where the first station was never finished; here without its last newline."""
    file = tmp_path / 'slide.csv'
    file.write_text('slide_mm,x,y,sigma_x,sigma_y')
    answers(monkeypatch, ['0', ''], lambda index: None)
    assert main(['calibrate', 'slide', str(file), '--live', '--count', '10']) == 1
    assert 'going on after the 0 stations' in capsys.readouterr().err
    assert len(file.read_text().splitlines()) == 2


def test_joints_of_other_names_are_told(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """While centroids flow: it does not wait for ever."""
    monkeypatch.setattr('blob_tracker.ros.endpoints.live_centroids.PATIENCE_S', 0.5)
    answers(monkeypatch, ['', 'q'], lambda index: None)
    words = ['turn', str(tmp_path / 'turn.csv'), '--size', '640x480', '--count', '10', '--live']
    assert main(['calibrate', *words, '--joints', 'pann,tilt']) == 1
    assert 'no joints pann, tilt came' in ' '.join(capsys.readouterr().err.split())


def test_typed_in_and_nothing_in_view(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Wrong words are asked again; without a target there is a sentence, and nothing is lost."""
    monkeypatch.setattr('blob_tracker.ros.endpoints.live_centroids.PATIENCE_S', 0.5)
    file = tmp_path / 'turn.csv'

    def moved(index: int) -> None:
        rig.lit = index < 3

    asked = answers(monkeypatch, ['12', '-100 50', '100, 50', '0 0', 'q'], moved)
    words = ['calibrate', 'turn', str(file), '--live', '--size', '640x480', '--count', '10']
    assert main(words) == 1
    captured = capsys.readouterr()
    assert "'12' is not 2 number(s)" in captured.out
    assert 'is the locator running' in captured.err.replace('\n', ' ')
    assert asked[4].startswith('Enter tries this station again')
    assert len(file.read_text().splitlines()) == 3


def test_a_file_of_another_form_is_not_added_to(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file in degrees is left as it is."""
    file = tmp_path / 'turn.csv'
    file.write_text('pan_deg,tilt_deg,x,y\n1,2,3,4\n')
    assert main(['calibrate', 'turn', str(file), '--live', '--size', '640x480']) == 1
    assert 'cannot be continued' in capsys.readouterr().err
    assert file.read_text() == 'pan_deg,tilt_deg,x,y\n1,2,3,4\n'

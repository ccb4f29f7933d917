"""`calibrate board` as a user runs it: a folder, bags of both storages, a topic, and mistakes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import signal
import sys
import time
from typing import Any

from blob_tracker.__main__ import main
from blob_tracker.calibration.board import BoardCalibration, calibrate_board
from blob_tracker.calibration.boards import Board
from blob_tracker.camera import CameraModel
from blob_tracker.commands.calibrate import board as board_command
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.simulation.board import BoardScene
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import Pixels
import cv2
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores
from sensor_msgs.msg import Image
from support.boards import camera, CHARUCO, CHESSBOARD, poses, printed
from support.processes import probe, Process
from support.slowness import slowness

VIEWS = 14
CHESS = ['--kind', 'chessboard', '--columns', '9', '--rows', '6', '--square', '25']


def pictures(board: Board = CHESSBOARD, **scene: Any) -> tuple[CameraModel, list[Pixels]]:
    """Return a camera and images of a board that it took."""
    random = np.random.default_rng(60)
    model = camera(random, width=320 if board is CHESSBOARD else 640)
    seen = BoardScene(printed(board), model, **scene)
    return model, [seen.frame(pose, random) for pose in poses(random, board, model, count=VIEWS)]


@pytest.fixture(scope='module')
def chess() -> tuple[CameraModel, list[Pixels]]:
    """Return a camera and its images of a chessboard, made once."""
    return pictures()


def save(folder: Path, images: Sequence[Pixels], suffix: str = 'png') -> Path:
    """Write images into a new folder."""
    folder.mkdir()
    for index, image in enumerate(images):
        assert cv2.imwrite(str(folder / f'view{index}.{suffix}'), image)
    return folder


def calibrate(source: object, out: Path, *options: str) -> int:
    """Run the command in this process."""
    where = ['--out', str(out / 'camera_info.yaml'), '--picture', str(out / 'picture.png')]
    return main(['calibrate', 'board', str(source), *where, *options])


def assert_found(out: Path, true: CameraModel) -> None:
    """Hold the written calibration against the truth: 1 px, ten sigmas and more."""
    found = CameraModel.from_file(out / 'camera_info.yaml')
    assert (found.width, found.height) == (true.width, true.height)
    assert found.distortion_model == true.distortion_model
    assert np.abs(found.matrix - true.matrix).max() < 1.0
    picture = cv2.imread(str(out / 'picture.png'))
    assert picture.shape[1] >= 1000


def test_a_folder_becomes_a_camera_info(
    chess, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Tables with sigmas, comments on top of the file, and a word when it is replaced."""
    true, images = chess
    folder = save(tmp_path / 'images', images)
    assert calibrate(folder, tmp_path, *CHESS, '--name', 'front') == 0
    assert_found(tmp_path, true)
    text = capsys.readouterr().out
    for word in ('fx (px)', 'sigma', 'worst corner', 'view13.png', 'rms', 'calibration written'):
        assert word in text
    written = (tmp_path / 'camera_info.yaml').read_text()
    assert '# standard deviations: fx ' in written
    assert '# sigma of a bearing at the centre, mrad' in written
    assert 'camera_name: front' in written
    assert calibrate(folder, tmp_path, *CHESS) == 0
    assert 'calibration replaced' in capsys.readouterr().out


def test_sixteen_bits_of_a_charuco_board(tmp_path: Path) -> None:
    """TIFF files of 12 bits of signal, another kind, another distortion model."""
    true, images = pictures(CHARUCO, black=300.0, white=3000.0, surroundings=900.0,
                            sensor=Sensor(bits=12))
    folder = save(tmp_path / 'images', images, 'tif')
    board = ['--kind', 'charuco', '--columns', '8', '--rows', '6', '--square', '30']
    assert calibrate(folder, tmp_path, *board, '--marker', '22') == 0
    assert_found(tmp_path, true)


@pytest.mark.parametrize('storage', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_a_bag_becomes_a_camera_info(chess, tmp_path: Path, storage: StoragePlugin) -> None:
    """Of each pose two images: only those that differ are taken."""
    true, images = chess
    typestore = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / 'bag', version=9, storage_plugin=storage) as writer:
        kind = 'sensor_msgs/msg/Image'
        connection = writer.add_connection('/front/image', kind, typestore=typestore)
        for index, image in enumerate(np.repeat(np.array(images), 2, axis=0)):
            stamp_ns = 10**18 + index * 10**8
            writer.write(connection, stamp_ns, serialize_message(from_pixels(image, stamp_ns, '')))
    assert calibrate(tmp_path / 'bag', tmp_path, *CHESS, '--topic', 'front/image') == 0
    assert_found(tmp_path, true)
    assert f'{VIEWS} views' in (tmp_path / 'camera_info.yaml').read_text()


def live(
    domain: int, images: Sequence[Pixels], out: Path, *options: str, interrupt: float = 0.0
) -> tuple[int, str]:
    """Publish images one after the other, again and again; return exit code and output."""
    command = [sys.executable, '-m', 'blob_tracker', 'calibrate', 'board', 'front/image', *CHESS]
    command += ['--out', str(out / 'camera_info.yaml'), '--picture', str(out / 'picture.png')]
    with probe(domain) as node, Process([*command, *options], domain) as process:
        publisher = node.create_publisher(Image, 'front/image', IMAGE_OUT)
        node.spin_until(lambda: publisher.get_subscription_count() or not process.running)
        began = time.monotonic()
        while process.running and time.monotonic() - began < 60.0 * slowness():
            for image in images:
                for _ in range(3):  # the board rests for a while in each pose
                    publisher.publish(from_pixels(image, time.time_ns(), 'camera'))
                    node.spin(0.06)
                if not process.running:
                    break
                if interrupt and time.monotonic() - began > interrupt * slowness():
                    code = process.end(signal.SIGINT, timeout=20.0)
                    return code, process.output
        return process.wait(), process.output


def test_a_topic_is_followed_until_there_are_enough_views(
    chess, tmp_path: Path, domain: int
) -> None:
    """It ends by itself, and says what it wants meanwhile."""
    true, images = chess
    code, output = live(domain, images, tmp_path, '--views', '12')
    assert code == 0, output
    assert 'Move the chessboard of 9 x 6 inner corners about' in output
    assert_found(tmp_path, true)


def test_ctrl_c_calibrates_with_what_is_there(chess, tmp_path: Path, domain: int) -> None:
    """The first Ctrl-C ends the listening, not the command."""
    true, images = chess
    code, output = live(domain, images, tmp_path, '--views', '99', interrupt=8.0)
    assert code == 0, output
    assert 'Traceback' not in output
    assert_found(tmp_path, true)


def test_ctrl_c_without_a_view_says_so(tmp_path: Path, domain: int) -> None:
    """Images came, none with a board: one of them is kept to look at."""
    image = np.full((120, 160), 90, dtype=np.uint8)
    code, output = live(domain, [image], tmp_path, interrupt=2.0)
    assert code == 1
    assert 'no chessboard of 9 x 6 inner corners in any image' in output
    assert cv2.imread(str(tmp_path / 'no_board.png')) is not None


def test_a_topic_without_images_says_what_there_is(tmp_path: Path, domain: int) -> None:
    """Neither folder nor topic: the topics on which images are published are named."""
    command = [sys.executable, '-m', 'blob_tracker', 'calibrate', 'board', 'nowhere', *CHESS]
    with probe(domain) as node, Process(command, domain) as process:
        node.create_publisher(Image, 'elsewhere/image', IMAGE_OUT)
        node.spin_until(lambda: not process.running, timeout=40.0)
        assert process.wait() == 1
    assert "there is no folder 'nowhere'" in process.output
    assert 'images are published on /elsewhere/image' in process.output
    assert 'Traceback' not in process.output


def test_an_image_of_another_size_is_left_out_with_a_word(
    chess, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One that someone cropped does not shut the folder."""
    true, images = chess
    folder = save(tmp_path / 'images', images)
    wider = cv2.copyMakeBorder(images[5], 0, 0, 20, 20, cv2.BORDER_REPLICATE)
    cv2.imwrite(str(folder / 'wider.png'), wider)
    assert calibrate(folder, tmp_path, *CHESS) == 0
    errors = capsys.readouterr().err
    assert 'left out, as their size is not 320 x 240 px: wider.png (360 x 240)' in errors
    assert_found(tmp_path, true)


@pytest.mark.parametrize('columns, rows', [(4, 3), (5, 4)])
def test_a_board_that_was_counted_wrong_is_refused(
    chess, tmp_path: Path, capsys: pytest.CaptureFixture[str], columns: int, rows: int
) -> None:
    """The detector makes a grid of whatever corners it finds; no camera comes of it."""
    options = ['--kind', 'chessboard', '--columns', str(columns), '--rows', str(rows),
               '--square', '25']
    assert calibrate(save(tmp_path / 'images', chess[1][:6]), tmp_path, *options) == 1
    assert 'are --columns and --rows its own' in capsys.readouterr().err
    assert not (tmp_path / 'camera_info.yaml').exists()


def test_bent_boards_are_doubted(
    chess, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sigmas that had to grow, and a scatter that no sharp picture of a flat board has."""
    def doubtful(*arguments) -> BoardCalibration:
        return replace(calibrate_board(*arguments), growth=9.0, rms=0.8)

    monkeypatch.setattr(board_command, 'calibrate_board', doubtful)
    assert calibrate(save(tmp_path / 'images', chess[1]), tmp_path, *CHESS) == 0
    words = ' '.join(capsys.readouterr().out.split())
    assert 'the sigmas are 3.0 times what independent points would give' in words
    assert '0.80 px is much' in words


def unreadable(folder: Path, images: list[Pixels]) -> None:
    """Write a file that is no image."""
    save(folder, images[:3])
    (folder / 'view1.png').write_text('no image')


@pytest.mark.parametrize(
    'prepare, options, code, sentence',
    [
        (unreadable, CHESS, 1, 'view1.png is not an image that can be read'),
        (lambda folder, _: folder.mkdir(), CHESS, 1, 'holds no images'),
        (lambda folder, images: save(folder, images[:2]), CHESS, 1, 'it takes 3 at the very'),
        (lambda folder, images: save(folder, images[:2]),
         ['--kind', 'dots', '--columns', '7', '--rows', '5', '--square', '25'], 1,
         'no symmetric grid of 7 x 5 dots in any image'),
        (lambda folder, images: save(folder, images[:1]),
         ['--kind', 'chessboard', '--columns', '10', '--rows', '7', '--square', '25'], 1,
         'has a chessboard of 9 x 6 inner corners: give --columns 9 --rows 6 (one less than'),
        (lambda folder, images: save(folder, images[:2]), [*CHESS, '--asymmetric'], 2,
         '--asymmetric is for dots'),
        (lambda folder, images: save(folder, images[:2]), [*CHESS[:-1], '0'], 2,
         'it must be above 0'),
        (lambda folder, images: save(folder, images[:2]), [*CHESS, '--picture', 'x.bmp'], 2,
         '--picture is x.bmp; it must end in one of'),
    ],
)
def test_mistakes_are_one_sentence(
    chess, tmp_path: Path, capsys: pytest.CaptureFixture[str], prepare, options, code, sentence
) -> None:
    """What is wrong and what would be right; nothing is written."""
    prepare(tmp_path / 'images', chess[1])
    assert calibrate(tmp_path / 'images', tmp_path, *options) == code
    errors = capsys.readouterr().err
    assert sentence in errors
    assert 'Traceback' not in errors
    assert not (tmp_path / 'camera_info.yaml').exists()


def test_a_wild_fit_without_a_bearing_at_the_centre_is_refused(
    chess, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lens that folds before the centre, known badly: said in words, not by a traceback."""
    def wild(*arguments) -> BoardCalibration:
        found = calibrate_board(*arguments)
        matrix = found.model.matrix.copy()
        matrix[0, 2] = 2000.0
        model = replace(found.model, matrix=matrix, distortion=np.array([-0.5, 0, 0, 0, 0]))
        return replace(found, model=model, covariance=np.eye(9) * 1e4)

    monkeypatch.setattr(board_command, 'calibrate_board', wild)
    assert calibrate(save(tmp_path / 'images', chess[1]), tmp_path, *CHESS) == 1
    streams = capsys.readouterr()
    assert 'not known: centre: no ray leads to the pixel' in streams.out
    assert 'the focal length is known to' in streams.err
    assert not (tmp_path / 'camera_info.yaml').exists()


def test_a_place_that_cannot_be_written_is_named(
    chess, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The calibration is not lost without a word."""
    folder = save(tmp_path / 'images', chess[1])
    (tmp_path / 'file').write_text('')
    assert calibrate(folder, tmp_path / 'file', *CHESS) == 1
    assert 'cannot write the calibration' in capsys.readouterr().err

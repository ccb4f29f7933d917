"""`track` from end to end: its numbers are those of `Pipeline`; what is wrong is a sentence."""

from __future__ import annotations

import csv
from pathlib import Path
from signal import raise_signal, SIGINT
import subprocess
import sys
from typing import Any

from blob_tracker import CameraModel, Pipeline, SensorNoise
from blob_tracker.__main__ import main
from blob_tracker.camera import write_calibration
from blob_tracker.commands.track.chain import Chain
from blob_tracker.commands.track.table import COLUMNS
from blob_tracker.resources import config_path
from blob_tracker.ros.bags import opened
from blob_tracker.ros.endpoints.recording import recorded_frames, recorded_info
from blob_tracker.ros.messages.camera_info import to_camera_model
from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.types import Bearing, Frame
import cv2
import numpy as np
import pytest
from support.written_sources import folder, HEIGHT, light_frames, RATE, tiff, WIDTH
import yaml

BAGS = Path(__file__).parents[2] / 'bags'
TOPIC = 'camera/image_raw'
CODES = {'port': '1101000', 'starboard': '1110100'}
CODED = (
    '--flash.mode', 'coded', '--flash.codes', 'port:1101000,starboard:1110100',
    '--flash.bits_per_second', '45',
)
COUNT = 12
FRAMES = light_frames(COUNT)
Row = dict[str, str]


def run(*words: object) -> int:
    """Run the command."""
    return main(['track', *map(str, words)])


def rows(path: Path) -> list[Row]:
    """Return the rows of a table."""
    with path.open(newline='') as file:
        return list(csv.DictReader(file))


def placed(path: Path) -> list[Row]:
    """Return those of its rows that have a place."""
    return [row for row in rows(path) if not row['reason']]


def numbers(light: str, bearing: Bearing) -> tuple[Any, ...]:
    """Return a bearing as a row has it."""
    sigmas = np.sqrt(bearing.covariance.diagonal()).tolist()
    return (
        light, bearing.stamp_ns, bearing.azimuth, bearing.elevation, *sigmas,
        bearing.covariance[0, 1],
    )


def of_row(row: Row) -> tuple[Any, ...]:
    """Return the same of a row."""
    stamp_ns = int(row['stamp_s'].replace('.', ''))
    return (row['light'], stamp_ns, *(float(row[name]) for name in COLUMNS[3:8]))


@pytest.mark.parametrize(('bag', 'words', 'flash'), [
    ('flash_mcap', (), {'mode': 'alternate'}),
    ('coded_mcap', CODED, {'mode': 'coded', 'codes': CODES, 'bits_per_second': 45.0}),
])
def test_a_bag_gives_what_the_pipeline_gives(
    tmp_path: Path, bag: str, words: tuple[str, ...], flash: dict[str, Any]
) -> None:
    """To the last bit; test_coded_bag.py and test_time.py hold the nodes to the same."""
    pairs = list(recorded_frames(BAGS / bag, TOPIC, paired=True))
    pipeline = Pipeline(
        to_camera_model(pairs[0][1]), noise=SensorNoise(40.0, 0.7),
        segmenter=Segmenter(flash=flash_by_name(**flash)),
    )
    expected = [numbers(*named) for named in pipeline.named(frame for frame, _ in pairs)]
    assert run(BAGS / bag, '--out', tmp_path / 't.csv', *words) == 0
    assert [of_row(row) for row in placed(tmp_path / 't.csv')] == expected
    assert len(expected) > 25
    assert len({row['frame'] for row in rows(tmp_path / 't.csv')}) == len(pairs)
    assert cv2.imread(str(tmp_path / 't.png')) is not None


def test_without_a_calibration_there_are_places_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a stack of pages; a word says why, and each frame without a place has its reason."""
    stack = tiff(tmp_path / 's.tif', FRAMES)
    out = tmp_path / 't.csv'
    assert run(stack, '--frame-rate', RATE, '--out', out) == 0
    every, found = rows(out), placed(out)
    assert len(every) == COUNT and [row['frame'] for row in every][-1] == 's.tif page 12'
    assert len(found) == COUNT // 2 - 1
    pipeline = Pipeline(
        CameraModel.from_field_of_view(WIDTH, HEIGHT, 40.0), noise=SensorNoise(40.0, 0.7)
    )
    frames = [Frame(frame, round(1e9 * k / RATE), 255) for k, frame in enumerate(FRAMES)]
    locations = [each.location for frame in frames for each in pipeline.placed(frame)]
    assert [(float(row['x_px']), float(row['y_px'])) for row in found] == [
        (each.x, each.y) for each in locations
    ]
    assert all(row['azimuth_mrad'] == '' and row['snr'] for row in found)
    assert all(row['reason'] for row in every if not row['x_px'])
    said = capsys.readouterr().out
    assert 'stamps: by --frame-rate 30' in said and 'no angles: give the calibration' in said


def test_a_calibration_and_parameters_by_file_and_by_option(tmp_path: Path) -> None:
    """The nodes' own file gives what the options give; an option wins over it."""
    source = folder(tmp_path / 'f', FRAMES)
    camera = tmp_path / 'camera.yaml'
    write_calibration(camera, CameraModel.from_field_of_view(WIDTH, HEIGHT, 40.0))
    parameters = tmp_path / 'mine.yaml'
    parameters.write_text(yaml.safe_dump({
        '/**/segmenter': {'ros__parameters': {'min_snr': 9.0, 'threshold': {'sigmas': 2.8}}},
        'locator': {'ros__parameters': {'method': 'gaussian_linear', 'noise.gain': 20.0}},
        'camera': {'ros__parameters': {'camera_info_url': f'file://{camera}', 'gain': 3}},
        '/**': {'ros__parameters': {'use_sim_time': True}},
    }))
    rate = '--frame-rate', RATE
    outs = [tmp_path / f'{name}.csv' for name in ('file', 'options', 'both')]
    assert run(source, *rate, '--out', outs[0], '--params-file', parameters) == 0
    assert run(
        source, *rate, '--out', outs[1], '--camera-info', camera, '--min_snr', 9, '--noise.gain',
        '20', '--threshold.sigmas', '2.8', '--method', 'gaussian_linear',
    ) == 0
    assert run(
        source, *rate, '--out', outs[2], '--params-file', parameters, '--method', 'centroid'
    ) == 0
    file, options, both = (placed(out) for out in outs)
    assert file == options and len(file) == COUNT // 2 - 1 and file[0]['azimuth_mrad']
    assert [row['x_px'] for row in both] != [row['x_px'] for row in file]


def test_the_default_parameter_file_is_understood(tmp_path: Path) -> None:
    """All that the nodes have by default gives what no file gives."""
    source = folder(tmp_path / 'f', FRAMES)
    words = source, '--frame-rate', RATE
    for out, more in (('a', ()), ('b', ('--params-file', config_path('tracker.yaml')))):
        assert run(*words, '--out', tmp_path / f'{out}.csv', *more) == 0
    assert (tmp_path / 'a.csv').read_text() == (tmp_path / 'b.csv').read_text()


def test_a_bag_of_bearings_and_a_video_of_what_was_seen(tmp_path: Path) -> None:
    """The messages are those of the locator; each frame is in the video, with its marks."""
    from rosbags.highlevel import AnyReader

    out = tmp_path / 'track'
    bag = BAGS / 'flash_mcap'
    assert run(bag, '--to', 'bag', '--out', out, '--annotate', '--count', 20) == 0
    assert run(bag, '--out', tmp_path / 't.csv', '--count', 20) == 0
    expected = [of_row(row) for row in placed(tmp_path / 't.csv')]
    with AnyReader([out]) as reader:
        assert set(reader.topics) == {'/target/bearing', '/target/centroid', '/target/ray'}
        said: list[Any] = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages(
                [each for each in reader.connections if each.topic == '/target/bearing']
            )
        ]
    found = [
        (each.header.stamp.sec * 10**9 + each.header.stamp.nanosec, each.vector.x, each.vector.y)
        for each in said
    ]
    assert found == [row[1:4] for row in expected] and len(found) == 9
    video = cv2.VideoCapture(str(out.with_suffix('.mp4')))
    pictures = []
    while (read := video.read())[0]:
        pictures.append(read[1])
    assert len(pictures) == 20 and video.get(cv2.CAP_PROP_FPS) == pytest.approx(30.0)
    blue, green, red = (pictures[2][..., channel].astype(int) for channel in range(3))
    assert np.count_nonzero((green > 150) & (red < 140) & (blue < 140)) > 20  # the ring


def test_ctrl_c_keeps_what_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The table has the rows until then, and there is a picture of them."""
    outcomes = Chain.outcomes

    def interrupted(self: Chain, name: str, frame: Frame) -> Any:
        if name == '8.png':
            raise_signal(SIGINT)
        return outcomes(self, name, frame)

    monkeypatch.setattr(Chain, 'outcomes', interrupted)
    out = tmp_path / 't.csv'
    assert run(folder(tmp_path / 'f', FRAMES), '--frame-rate', RATE, '--out', out) == 130
    assert [row['frame'] for row in rows(out)] == [f'{index}.png' for index in range(9)]
    assert out.with_suffix('.png').is_file()
    assert 'ended after 9 frames; they are kept' in capsys.readouterr().err


def test_a_source_that_breaks_off_keeps_what_came_before(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 1, and the frame that could not be read."""
    source = folder(tmp_path / 'f', FRAMES)
    (source / '7.png').write_text('no image')
    out = tmp_path / 't.csv'
    assert run(source, '--frame-rate', RATE, '--out', out) == 1
    assert len(rows(out)) == 7 and len(placed(out)) == 3
    assert '7.png is not an image that can be read' in capsys.readouterr().err


def test_no_light_is_said_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """And with what finds out how the light flashes."""
    source = folder(tmp_path / 'f', FRAMES[1:2] * 4)
    assert run(source, '--frame-rate', RATE, '--out', tmp_path / 't.csv') == 1
    said = capsys.readouterr().err
    assert 'no light was placed in 4 frames. Is flash.mode right?' in said
    assert 'calibrate flash' in said and 'waiting for a second frame (once)' in said


@pytest.mark.parametrize(('words', 'code', 'sentence'), [
    ((), 2, 'have no stamps: give their rate, --frame-rate 60'),
    (('--frame-rate', '30', '--out', 'no/t.csv'), 2, 'no is not a folder; make it first'),
    (('--frame-rate', '30', '--out', 't.png'), 2, 'is the name of the picture beside it'),
    (('--frame-rate', '30', '--flash.mode', 'coded'), 2, "parameter 'flash': "),
    (('--frame-rate', '30', '--method', 'centroid', '--elliptical', 'true'), 2,
     "the method 'centroid' has no such form"),
    (('--frame-rate', '30', '--camera-info', 'other.yaml'), 1,
     'the calibration is for 640 x 480 px and the frames are of 112 x 88 px'),
    (('--frame-rate', '30', '--camera-info', 'none.yaml'), 1, 'none.yaml'),
    (('--params-file', 'wrong.yaml'), 2, "no parameter 'min_sn'; did you mean 'min_snr'?"),
    (('--params-file', 'text.yaml'), 2, 'text.yaml is not a ROS parameter file'),
    (('--params-file', 'range.yaml'), 2,
     "range.yaml: parameter 'min_snr' is 9; it must be a number with a point from 3 to 1000; "
     'write 9.0'),
])
def test_wrong_use(
    tmp_path: Path, words: tuple[str, ...], code: int, sentence: str,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A sentence each, and an exit code that tells whose fault it is."""
    monkeypatch.chdir(tmp_path)
    source = folder(tmp_path / 'f', FRAMES[:3])
    other = CameraModel.from_field_of_view(640, 480, 40.0)
    write_calibration(tmp_path / 'other.yaml', other)
    for name, content in (
        ('wrong', 'segmenter: {ros__parameters: {min_sn: 9.0}}'), ('text', 'segmenter'),
        ('range', '/**: {ros__parameters: {min_snr: 9}}'),
    ):
        (tmp_path / f'{name}.yaml').write_text(content)
    assert run(source, *words) == code
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(('words', 'sentence'), [
    (('--min_snr', '2'), 'it must be a number from 3 to 1000'),
    (('--min_snr', 'two'), 'it must be a number from 3 to 1000'),
    (('--method', 'magic'), 'it must be one of centroid'),
    (('--elliptical', 'perhaps'), 'it must be a boolean'),
    (('--size', '640'), '640 is not a size; write 640x480'),
    (('--frame-rate', '0'), "'0' is not a number above 0"),
    (('--frame-rate', 'inf'), "'inf' is not a number above 0"),
    (('--frame-rate', 'fast'), "'fast' is not a number above 0"),
    (('--count', '1.5'), "'1.5' is not a whole number above 0"),
])
def test_wrong_words(
    words: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything is opened."""
    with pytest.raises(SystemExit) as ended:
        run('f', *words)
    assert ended.value.code == 2
    assert sentence in capsys.readouterr().err


def test_what_is_not_there_is_no_topic(capsys: pytest.CaptureFixture[str]) -> None:
    """Live topics are the nodes'; the name of a file is none of a topic."""
    assert run('no_such_file.mp4') == 2
    assert capsys.readouterr().err == 'there is no file no_such_file.mp4\n'
    assert run('camera/image_raw') == 2
    assert 'there is no file camera/image_raw; a topic is tracked by the nodes' in (
        capsys.readouterr().err
    )


def test_it_needs_no_ros(tmp_path: Path) -> None:
    """A bag is tracked, and what needs ROS is named, where none of it can be imported."""
    script = (
        'import sys\n'
        'for name in ("ament_index_python", "builtin_interfaces", "geometry_msgs", "rclpy",'
        ' "sensor_msgs", "std_msgs"):\n'
        '    sys.modules[name] = None\n'
        'from blob_tracker.__main__ import main\n'
        f'bag, out = {str(BAGS / "flash_mcap")!r}, {str(tmp_path / "t.csv")!r}\n'
        'assert main(["track", bag, "--count", "8", "--out", out]) == 0\n'
        'assert main(["track", bag, "--to", "bag", "--out", out[:-4]]) == 2\n'
        'assert main(["demo"]) == 1\n'
        'for each in ("board", "body", "flash", "rig"):\n'
        '    try:\n'
        '        main(["calibrate", each, "--help"])\n'
        '    except SystemExit as end:\n'
        '        assert end.code == 0\n'
    )
    # Elsewhere, so that the package is the one whose kernels are compiled.
    done = subprocess.run(
        [sys.executable, '-c', script], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert len(placed(tmp_path / 't.csv')) == 3
    assert '--to bag writes messages of ROS, which are not installed' in done.stderr
    assert 'demo needs ROS 2' in done.stderr
    assert 'calibrate needs ROS 2' not in done.stderr


def test_a_bag_without_a_calibration_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another topic has none, nor any image."""
    with opened(BAGS / 'flash_mcap') as recording:
        assert recorded_info(recording, TOPIC) is not None
    assert run(BAGS / 'flash_mcap', '--topic', 'other/image_raw', '--out', tmp_path / 't') == 1
    assert 'set --topic to one of /camera/image_raw' in capsys.readouterr().err

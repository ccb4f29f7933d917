"""`calibrate noise` from end to end: folders, a scene, and what is wrong with a source."""

from __future__ import annotations

import csv
from pathlib import Path
import re
from signal import SIGINT
import sys
import time

from blob_tracker.__main__ import main
from blob_tracker.commands.calibrate.noise_pairs import _steps
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.simulation import FlatField, Scene, Sensor
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise
import cv2
import numpy as np
import pytest
from sensor_msgs.msg import Image
from support.processes import probe, Process
import yaml

FIELD = FlatField(
    Sensor(SensorNoise(3.6, 3.0, 20.0), bits=12, prnu=0.005, dsnu=0.3), width=200, height=150,
)
SIGNALS = (0, 200, 600, 1200, 2400, 5000)  # DN above black; the last is clipped


def write(folder: Path, name: str, image: np.ndarray) -> None:
    """Write an image."""
    folder.mkdir(exist_ok=True)
    assert cv2.imwrite(str(folder / name), image)


def indexed(folder: Path, signals=SIGNALS, shots: int = 2) -> Path:
    """Write a folder with an index; return it."""
    random = np.random.default_rng(1)
    rows = []
    for signal in signals:
        for shot in range(shots):
            rows.append((f's{signal}_{shot}.png', 'bright' if signal else 'dark', 10 * signal))
            write(folder, rows[-1][0], FIELD.frame(signal, random))
    with (folder / 'index.csv').open('w', newline='') as file:
        csv.writer(file).writerows([('file', 'kind', 'exposure_ns'), *rows])
    return folder


def run(*words: object) -> int:
    """Run the command."""
    return main(['calibrate', 'noise', *map(str, words)])


def parameters(path: Path, node: str) -> dict[str, float]:
    """Return what a parameter file has for a node."""
    return yaml.safe_load(path.read_text())[f'/**/{node}']['ros__parameters']


def test_a_folder_with_an_index(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Table, parameter file, picture, command; a file that was there is said to be overwritten."""
    out = tmp_path / 'noise.yaml'
    assert run(indexed(tmp_path / 'frames'), '--out', out) == 0
    text = capsys.readouterr().out
    assert 'PRNU' in text and 'linearity error' in text and '--params-file' in text
    locator = parameters(out, 'locator')
    # 30,000 pixels at four levels tell the gain to 0.5 %, the dark noise to 0.6 % and the black
    # level to 0.3 / sqrt(30,000) of a pixel's own and as little noise.
    assert locator['noise.gain'] == pytest.approx(3.6, rel=0.02)
    assert locator['noise.read_noise'] == pytest.approx(3.0, rel=0.03)
    assert locator['noise.black_level'] == pytest.approx(20.0, abs=0.1)
    assert locator['saturation'] == parameters(out, 'segmenter')['saturation'] == 4095
    assert cv2.imread(str(tmp_path / 'noise.png')).shape[0] > 600
    assert run(tmp_path / 'frames', '--out', out) == 0
    assert 'overwritten' in capsys.readouterr().out


def test_frames_that_hang_together_in_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A camera's noise reduction is refused, flat and in a scene; two frames tell nothing."""
    random = np.random.default_rng(14)
    scene = Scene(width=320, height=240, background=90.0, sensor=Sensor(SensorNoise(8.0, 1.2)))
    held: dict[str, np.ndarray] = {}

    def reduced(name: str, image: np.ndarray) -> np.ndarray:
        """Return 0.75 of a frame and 0.25 of what was returned before."""
        held[name] = 0.25 * held[name] + 0.75 * image if name in held else image.astype(float)
        return np.rint(held[name]).astype(image.dtype)

    for index in range(12):
        write(tmp_path / 'scene', f'{index:02d}.png', reduced('scene', scene.frame(index)))
        for signal in (0, 400, 1200, 2400):
            name = f'{signal:04d}_{index:02d}.png'
            folder = tmp_path / ('bright' if signal else 'dark')
            write(folder, name, reduced(str(signal), FIELD.frame(signal, random)))
    out = tmp_path / 'noise.yaml'
    for words in (
        (tmp_path / 'scene', '--scene'), (tmp_path / 'bright', '--dark', tmp_path / 'dark'),
    ):
        assert run(*words, '--out', out) == 1
        told = capsys.readouterr().err
        assert 'hang together in time' in told and 'off and record again' in told
        assert 0.2 < float(re.findall(r'correlation (\S+)', told)[0]) < 0.35
    assert not out.exists()
    assert run(indexed(tmp_path / 'frames'), '--out', out) == 0
    assert 'is unknown. Take three' in ' '.join(capsys.readouterr().out.split())
    assert run(indexed(tmp_path / 'four', shots=4), '--out', out) == 0
    assert 'in a row' not in capsys.readouterr().out


def test_folders_of_bright_and_dark(tmp_path: Path) -> None:
    """Names sorted in pairs."""
    random = np.random.default_rng(2)
    for index, signal in enumerate((300, 300, 1200, 1200, 2400, 2400)):
        write(tmp_path / 'bright', f'{index}.png', FIELD.frame(signal, random))
        write(tmp_path / 'dark', f'{index}.png', FIELD.frame(0.0, random))
    out = tmp_path / 'noise.yaml'
    assert run(tmp_path / 'bright', '--dark', tmp_path / 'dark', '--out', out) == 0
    assert parameters(out, 'locator')['noise.gain'] == pytest.approx(3.6, rel=0.03)


def test_a_still_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No flat light, no dark frames."""
    scene = Scene(width=320, height=240, background=90.0, sensor=Sensor(SensorNoise(8.0, 1.2)))
    for index in range(12):
        write(tmp_path / 'scene', f'{index:02d}.png', scene.frame(index))
    out = tmp_path / 'noise.yaml'
    assert run(tmp_path / 'scene', '--scene', '--out', out) == 0
    assert parameters(out, 'locator')['noise.gain'] == pytest.approx(8.0, rel=0.1)  # 3 sigma
    assert 'Noise level function' in capsys.readouterr().out


def test_a_scene_that_brightens(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """12 bits in 16, the first pair below 10: what is brighter counts; no bits are guessed."""
    random = np.random.default_rng(12)
    ramp = np.tile(np.linspace(60.0, 700.0, 320), (240, 1))
    for index, light in enumerate((1, 1, 1, 1, 3, 3, 3, 3)):
        image = expose(light * ramp, FIELD.sensor.noise, random, saturation=4095)
        write(tmp_path / 'scene', f'{index:02d}.png', image)
    out = tmp_path / 'noise.yaml'
    assert run(tmp_path / 'scene', '--scene', '--out', out) == 0
    assert parameters(out, 'locator')['saturation'] == 0
    assert parameters(out, 'segmenter')['saturation'] == 0
    text = capsys.readouterr().out
    assert 'give --saturation' in ' '.join(text.split())
    # 3 sigma of 300,000 differences.
    assert parameters(out, 'locator')['noise.gain'] == pytest.approx(3.6, rel=0.03)
    assert run(tmp_path / 'scene', '--scene', '--saturation', '4095', '--out', out) == 0
    assert parameters(out, 'locator')['saturation'] == 4095
    told = capsys.readouterr().out
    assert 'give --saturation' not in ' '.join(told.split())
    # The same tiles: half of those of the bright pairs are above 1023 DN.
    tiles = [re.findall(r'tiles used\D+(\d+), (\d+)', each) for each in (text, told)]
    assert tiles[0] and tiles[0] == tiles[1]


def test_ctrl_c_measures_what_came_on_a_topic(tmp_path: Path, domain: int) -> None:
    """It says so at the start, and that it ends after a minute by itself."""
    random = np.random.default_rng(13)
    out = tmp_path / 'noise.yaml'
    command = [sys.executable, '-m', 'blob_tracker', 'calibrate', 'noise', 'flat/image']
    with probe(domain) as node, Process([*command, '--out', str(out)], domain) as process:
        publisher = node.create_publisher(Image, 'flat/image', IMAGE_OUT)
        node.spin_until(lambda: publisher.get_subscription_count() or not process.running)
        for signal in (0.0, 400.0, 1200.0, 2400.0):
            for _ in range(12):
                image = FIELD.frame(signal, random)
                publisher.publish(from_pixels(image, time.time_ns(), 'camera'))
                node.spin(0.1)
        code = process.end(SIGINT, timeout=20.0)
        output = process.output
    assert code == 0, output
    assert 'Listening to flat/image for 60 s; Ctrl-C ends it earlier' in output
    # A pair of each level at least: 30,000 pixels each tell the gain to 1 %.
    assert parameters(out, 'locator')['noise.gain'] == pytest.approx(3.6, rel=0.05)


def test_an_index_out_of_a_spreadsheet(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A byte order mark is none of the header; UTF-16 is refused in a sentence."""
    out = tmp_path / 'noise.yaml'
    index = indexed(tmp_path / 'frames') / 'index.csv'
    text = index.read_text()
    index.write_text(text, encoding='utf-8-sig')
    assert run(tmp_path / 'frames', '--out', out) == 0
    out.unlink()
    index.write_text(text, encoding='utf-16')
    assert run(tmp_path / 'frames', '--out', out) == 1
    assert 'in UTF-8' in capsys.readouterr().err
    index.write_text(text + '"' + 200_000 * 'x' + '"\n')  # csv.Error: a field too large
    assert run(tmp_path / 'frames', '--out', out) == 1
    assert 'save it as CSV in UTF-8' in capsys.readouterr().err
    assert not out.exists()


def test_the_picture_is_no_parameter_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One would overwrite the other."""
    assert run(tmp_path, '--out', tmp_path / 'noise.png') == 2
    assert 'noise.yaml' in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_steps_of_the_light_in_a_stream() -> None:
    """The frame in which the light changed is in no pair; the darkest step is dark."""
    random = np.random.default_rng(3)
    images = []
    for signal in (0.0, 400.0, 900.0):
        images += [FIELD.frame(signal, random) for _ in range(5)]
        images.append(FIELD.frame(signal + 200.0, random))
    pairs = _steps(images)
    assert [each.dark for each in pairs] == [True, True, False, False, False, False]
    assert [round(each.mean, -1) for each in pairs] == [20, 20, 420, 420, 920, 920]
    # A quarter of a per cent of the signal would show if a changing frame were in one.
    assert all(each.variance < 9.0 + each.mean / 3.6 + 5.0 for each in pairs)


def test_what_is_wrong_is_said_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """On stderr, with exit code 1, and no file is written."""
    out = tmp_path / 'noise.yaml'
    plain = tmp_path / 'plain'
    write(plain, 'a.png', FIELD.frame(500, np.random.default_rng(1)))
    for source, words, says in (
        (indexed(tmp_path / 'odd', shots=1), (), 'each light needs two'),
        (indexed(tmp_path / 'clipped', (0, 5000, 6000)), (), 'every bright pair is clipped'),
        (indexed(tmp_path / 'dark', (0,)), (), 'no bright frames'),
        (plain, (), 'has no index.csv; write one'),
        (plain, ('--dark', plain), 'the number of frames, 1, is odd'),
        (plain, ('--scene',), 'fewer than two frames'),
    ):
        assert run(source, *words, '--out', out) == 1
        assert says in capsys.readouterr().err
    (tmp_path / 'dark' / 'index.csv').write_text('name,kind\na.png,dark\n')
    assert run(tmp_path / 'dark', '--out', out) == 1
    assert 'it must have file and kind' in capsys.readouterr().err
    (tmp_path / 'dark' / 'index.csv').write_text('file,kind\na.png,flat\n')
    assert run(tmp_path / 'dark', '--out', out) == 1
    assert "the kind of a.png is 'flat'; it must be bright or dark" in capsys.readouterr().err
    assert run(plain, '--scene', '--dark', plain) == 2
    assert not out.exists()

"""`calibrate response` from end to end, and what is made linear by its file."""

from __future__ import annotations

import csv
from pathlib import Path

from blob_tracker.__main__ import main
from blob_tracker.camera.response import Response
from blob_tracker.commands.calibrate.exposures import _runs
from blob_tracker.commands.sources import GreyFrame
import cv2
import numpy as np
import pytest
from support.gamma import NOISE, rec709, seen, still_scene
import yaml

TIMES = (0, 1, 2, 4, 7, 11, 17, 26)
HEIGHT, WIDTH = 120, 160


def written(folder: Path, name: str, image: np.ndarray) -> str:
    """Write an image; return its name."""
    folder.mkdir(exist_ok=True)
    assert cv2.imwrite(str(folder / name), image)
    return name


@pytest.fixture(scope='module')
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of two frames of each exposure, with an index."""
    path = tmp_path_factory.mktemp('series')
    random = np.random.default_rng(8)
    scene = still_scene(HEIGHT, WIDTH)
    rows = [
        (written(path, f'{time:02d}_{shot}.png', seen('rec709', time * scene, random)), time)
        for time in TIMES for shot in range(2)
    ]
    with (path / 'index.csv').open('w', newline='') as file:
        csv.writer(file).writerows([('file', 'exposure'), *rows])
    return path


def run(*words: object) -> int:
    """Run the command."""
    return main(['calibrate', *map(str, words)])


@pytest.fixture(scope='module')
def response(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file that the command makes of the folder."""
    out = tmp_path_factory.mktemp('out') / 'response.yaml'
    names = ('--camera', 'front', '--pixel-format', 'YUYV')
    assert run('response', folder, *names, '--out', out) == 0
    return out


def test_file_and_picture_are_written(response: Path) -> None:
    """The file has the curve and whose it is; the picture is beside it."""
    read = Response.from_yaml(response)
    assert (read.camera, read.pixel_format) == ('front', 'YUYV')
    assert (read.width, read.height, read.saturation) == (WIDTH, HEIGHT, 255)
    raw = np.array([60, 120, 180])
    light = 255.0 * read.table[raw] / read.table[-1]
    # Exposures are taken to be true to 1 %: 2 raw DN.
    np.testing.assert_allclose(rec709(light), raw, atol=2.0)
    assert response.with_suffix('.png').stat().st_size > 10_000


def test_what_to_copy_is_printed(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same from --exposures as from an index; the noise is that of linear pixels."""
    out = tmp_path / 'response.yaml'
    times = ','.join(map(str, TIMES))
    assert run('response', folder, '--exposures', times, '--out', out) == 0
    words = capsys.readouterr().out.split()
    told = dict(word.split(':=') for word in words if ':=' in word)
    assert told['response_url'] == out.as_uri()
    assert float(told['noise.gain']) * 16.0 == pytest.approx(NOISE.gain, rel=0.15)
    assert 'exponent' in words


def test_other_calibrations_take_it(response: Path, folder: Path, tmp_path: Path) -> None:
    """`calibrate noise` measures linear pixels, and writes parameters in raw DN."""
    out = tmp_path / 'noise.yaml'
    assert run('noise', folder, '--scene', '--response', response, '--out', out) == 0
    for node in ('locator', 'segmenter'):
        parameters = yaml.safe_load(out.read_text())[f'/**/{node}']['ros__parameters']
        assert parameters['saturation'] == 255
        assert parameters['response_url'] == response.as_uri()
    locator = yaml.safe_load(out.read_text())['/**/locator']['ros__parameters']
    assert locator['noise.gain'] * 16.0 == pytest.approx(NOISE.gain, rel=0.2)


def test_without_it_the_noise_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With gamma and what to do about it named."""
    assert run('noise', folder, '--scene', '--out', tmp_path / 'noise.yaml') == 1
    told = ' '.join(capsys.readouterr().err.split())
    assert 'applies a gamma curve' in told and 'calibrate response' in told


def test_flats(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two frames of each light, dark ones in another folder."""
    random = np.random.default_rng(9)
    for light in (2, 5, 10, 20, 35, 55, 80, 110, 150, 200, 240, 300):
        for shot in range(2):
            field = np.full((HEIGHT, WIDTH), float(light))
            written(tmp_path / 'flats', f'{light:03d}_{shot}.png', seen('rec709', field, random))
    for shot in range(2):
        image = seen('rec709', np.zeros((HEIGHT, WIDTH)), random)
        written(tmp_path / 'dark', f'{shot}.png', image)
    out = tmp_path / 'response.yaml'
    words = ('response', tmp_path / 'flats', '--flats', '--dark', tmp_path / 'dark')
    assert run(*words, '--read-noise', 6.0, '--out', out) == 0
    assert '12 pairs of flat frames' in capsys.readouterr().out
    light = 255.0 * Response.from_yaml(out).table[120] / 4080.0
    assert rec709(light) == pytest.approx(120.0, abs=4.0)


def test_a_stream_goes_in_steps() -> None:
    """The frame in which the exposure changes, and a run of one, are left out."""
    stream = (
        GreyFrame('', None, np.full((8, 8), level, np.uint8), (16, 24))
        for level in (10, 10, 10, 14, 20, 20, 20, 20, 40, 40, 40)
    )
    runs = _runs(stream)
    assert [(each.count, each.frames[0][0, 0]) for each in runs] == [(2, 10), (3, 20), (2, 40)]
    assert runs[0].shot().sensor == (16, 24)


@pytest.mark.parametrize(('words', 'code', 'reason'), [
    (['--exposures', '1,2,4'], 1, '16 frames do not divide evenly among 3'),
    (['--exposures', '1,2,two,4'], 2, 'must be numbers with commas'),
    (['--exposures', '4,4,4,4'], 1, 'all exposures are equal'),
    (['--flats', '--exposures', '1,2'], 2, 'leave out --exposures'),
    (['--dark', 'there'], 2, '--dark is for --flats'),
    (['--out', 'picture.png'], 2, 'name of the picture'),
])
def test_what_is_wrong_is_said(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str], words: list[str], code: int, reason: str,
) -> None:
    """In one sentence, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    try:
        assert run('response', folder, *words) == code
    except SystemExit as end:
        assert end.code == code
    assert reason in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_file_of_another_camera_is_refused(
    response: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By calibrations as well."""
    for shot in range(2):
        written(tmp_path / 'frames', f'{shot}.png', np.zeros((60, 80), np.uint8))
    out = tmp_path / 'noise.yaml'
    words = ('noise', tmp_path / 'frames', '--scene', '--response', response, '--out', out)
    assert run(*words) == 1
    assert 'of a camera with 160 x 120 px' in capsys.readouterr().err

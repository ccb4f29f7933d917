"""calibrate turn, slide and jitter from the command line: files in, files and words out."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.__main__ import main
from blob_tracker.calibration.turn import project
from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.resources import config_path
from blob_tracker.simulation import expose
from blob_tracker.simulation.line_jitter import draw_edge, line_offsets
from blob_tracker.types import SensorNoise
import cv2
import numpy as np
import pytest

CAMERA = CameraModel(640, 480, pinhole_matrix(612.0, 640, 480))
TURN_HEADER = 'pan_mrad,tilt_mrad,x,y,sigma_x,sigma_y'


def turn_rows(unit: float = 1e-3) -> list[str]:
    """Return the lines of stations five by five, angles in units of so many rad."""
    random = np.random.default_rng(1)
    pan, tilt = (a.ravel() for a in np.meshgrid(np.linspace(-0.4, 0.4, 5), [-0.2, 0.0, 0.2]))
    pixels = project(CAMERA, pan, tilt, target=(0.02, 0.01), misalignment=(0.01, 0.0, 0.02))
    pixels += 0.02 * random.standard_normal(pixels.shape)
    return [
        f'{p / unit:.6f},{t / unit:.6f},{x:.4f},{y:.4f},0.02,0.02'
        for p, t, (x, y) in zip(pan, tilt, pixels)
    ]


@pytest.mark.parametrize('column, unit', [('mrad', 1e-3), ('deg', np.pi / 180.0), ('rad', 1.0)])
def test_turn_writes_a_camera(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], column: str, unit: float
) -> None:
    """The camera_info is that of the simulator, with its sigmas in words; a picture beside it."""
    file, out = tmp_path / 'turn.csv', tmp_path / 'camera_info.yaml'
    header = f'pan_{column}, tilt_{column}, x, y, sigma_x, sigma_y'
    file.write_text('\n'.join(['# a comment', header, *turn_rows(unit), '']))
    words = ['calibrate', 'turn', str(file), '--size', '640x480', '--out', str(out)]
    assert main(words) == 0
    model = CameraModel.from_file(out)
    np.testing.assert_allclose(model.matrix[[0, 1], [0, 1]], 612.0, rtol=1e-3)
    assert (model.width, model.height) == (640, 480)
    assert 'standard deviations (px, k1 without unit): fx 0.0' in out.read_text()
    assert (tmp_path / 'camera_info_residuals.png').stat().st_size > 10_000
    text = capsys.readouterr().out
    assert 'the target is taken as far' in text
    assert '(replaced)' not in text
    assert main([*words, '--range', '5000', '--offset', '50', '--one-f']) == 0
    text = capsys.readouterr().out
    assert '(replaced)' in text
    assert 'taken as far' not in text


def test_turn_starts_from_a_camera_info(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its name and model stay; a focal length that it cannot be is asked about."""
    file, out = tmp_path / 'turn.csv', tmp_path / 'out.yaml'
    file.write_text('\n'.join([TURN_HEADER, *turn_rows(), '']))
    guess = ['--camera-info', str(config_path('camera_info.yaml')), '--out', str(out)]
    assert main(['calibrate', 'turn', str(file), *guess, '--fit-distortion']) == 0
    assert CameraModel.from_file(out).name == 'simulated'
    assert abs(CameraModel.from_file(out).distortion[0]) < 0.01
    file.write_text('\n'.join([TURN_HEADER, *turn_rows(np.pi / 180.0), '']))
    capsys.readouterr()
    before = out.read_text()
    assert main(['calibrate', 'turn', str(file), *guess]) == 1
    told = capsys.readouterr()
    assert 'is the unit of the angles right?' in ' '.join(told.out.split())
    assert 'only: nothing is written' in told.err
    assert out.read_text() == before


@pytest.mark.parametrize('lost', ['measurements', 'guess'])
def test_what_is_read_is_not_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], lost: str
) -> None:
    """--out is neither the measurements nor the first guess."""
    file, guess = tmp_path / 'turn.csv', tmp_path / 'camera_info.yaml'
    out = {'measurements': file, 'guess': guess}[lost]
    words = ['turn', str(file), '--camera-info', str(guess), '--out', str(out)]
    assert main(['calibrate', *words]) == 2
    assert 'is what is read' in capsys.readouterr().err


@pytest.mark.parametrize(
    'content, sentence',
    [
        (None, 'turn.csv: No such file or directory\n'),
        ('', 'is empty; its first line is pan_mrad,tilt_mrad,x,y'),
        (TURN_HEADER, 'a header and no measurements'),
        ('pan,tilt,x,y\n1,2,3,4', 'there must be one of pan_mrad or pan_deg or pan_rad'),
        ('pan_mrad,tilt_mrad,x\n1,2,3', 'has no column y'),
        ('pan_mrad,tilt_mrad,x,y,sigma_x\n1,2,3,4,5', 'one of sigma_x and sigma_y'),
        (f'{TURN_HEADER}\n1,2,nan,4,1,1', "line 2: x is 'nan'; it must be a number"),
        (f'{TURN_HEADER}\n\n1,2,left,4,1,1', "line 3: x is 'left'"),
        (f'{TURN_HEADER}\n1,2,3', 'line 2: 3 values for 6 columns'),
        (f'{TURN_HEADER}\n1,2,3,4,0,1', 'sigma_x is 0 px; it must be above 0'),
        ('\n'.join([TURN_HEADER, *turn_rows()[:2]]), 'stood at 2 different angles'),
        ('\n'.join([TURN_HEADER, *turn_rows(1.0)]), 'too little. Is the unit right?'),
    ],
)
def test_bad_measurements_have_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str | None, sentence: str
) -> None:
    """On the standard error, with exit code 1, and nothing is written."""
    file, out = tmp_path / 'turn.csv', tmp_path / 'camera_info.yaml'
    if content is not None:
        file.write_text(content)
    words = ['calibrate', 'turn', str(file), '--size', '640x480', '--out', str(out)]
    assert main(words) == 1
    assert sentence in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    'words, sentence',
    [
        (['turn', 'a.csv'], 'give --camera-info FILE or --size 640x480'),
        (['turn', 'a.csv', '--size', '640x480', '--offset', '5'], 'give the range'),
        (['turn', 'a.csv', '--size', '640x480', '--range', '-1'], 'must be above 0'),
        (['slide', 'a.csv', '--range', '0'], '--range must be above 0'),
        (['slide', 'a.csv', '--range-sigma', '2'], 'counts with --range only'),
    ],
)
def test_wrong_use(
    capsys: pytest.CaptureFixture[str], words: list[str], sentence: str
) -> None:
    """Exit code 2 and what would be right."""
    assert main(['calibrate', *words]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize('option', [['--size', 'big'], ['--pan', '1:2'], ['--count', '1']])
def test_wrong_option(capsys: pytest.CaptureFixture[str], option: list[str]) -> None:
    """The parser says how it must look."""
    with pytest.raises(SystemExit) as ended:
        main(['calibrate', 'turn', 'a.csv', *option])
    assert ended.value.code == 2
    assert 'usage' in capsys.readouterr().err


def test_slide_prints_the_thesis_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Scale, the displacements of Table 5.1, the focal length, and a level camera."""
    random = np.random.default_rng(2)
    file = tmp_path / 'slide.csv'
    rows = [
        f'{inch:.3f},{200 + inch / 0.1694 + e[0]:.4f},{240 - 0.3 * inch + e[1]:.4f}'
        for inch, e in zip(0.1694 * np.arange(11), 0.01 * random.standard_normal((11, 2)))
    ]
    file.write_text('\n'.join(['slide_in,x,y', *rows]))
    words = ['calibrate', 'slide', str(file), '--range', '2438', '--range-sigma', '5']
    assert main([*words, '--slide-sigma', '0.0073']) == 0
    text = capsys.readouterr().out
    # 0.1694 inch is 4.303 mm; 2438 mm of range over it are 566.6 px.
    cells = [[cell.strip() for cell in line.split('│')] for line in text.splitlines()]
    values = {row[1]: float(row[2]) for row in cells if len(row) > 4}
    assert abs(values['slide for 1.00 px'] - 4.303) < 0.01
    assert abs(values['slide for 0.05 px'] - 0.2151) < 0.0005
    assert abs(values['focal length'] - 566.6) < 4.0
    assert 'level with the slide after a turn counter-clockwise' in text
    assert (tmp_path / 'slide.png').stat().st_size > 10_000


def test_jitter_writes_what_the_locator_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From a folder of pictures to line_jitter.yaml and a picture."""
    random = np.random.default_rng(3)
    height, width = 96, 80
    offsets = line_offsets(height)
    folder, out = tmp_path / 'edge', tmp_path / 'line_jitter.yaml'
    folder.mkdir()
    for index in range(8):
        places = 40.0 + 0.03 * np.arange(height) + offsets
        places = places + 0.03 * random.standard_normal(height)
        mean = draw_edge((height, width), places, 1.0, 30.0, 200.0)
        cv2.imwrite(
            str(folder / f'{index}.png'), expose(mean, SensorNoise(40.0, 0.7), random)
        )
    assert main(['calibrate', 'jitter', str(folder), '--out', str(out)]) == 0
    jitter = LineJitter.from_yaml(out)
    lines = np.arange(height)
    true = offsets - np.polyval(np.polyfit(lines, offsets, 1), lines)
    assert np.abs(jitter.offsets - true).max() < 0.06  # 4.5 of its sigmas
    assert jitter.sigma_from_frame_to_frame == pytest.approx(0.03, rel=0.2)
    assert (tmp_path / 'line_jitter.png').stat().st_size > 10_000
    assert 'from frame to frame' in capsys.readouterr().out


def test_jitter_says_what_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No edge in the pictures: a sentence, and no file."""
    for index in range(4):
        cv2.imwrite(str(tmp_path / f'{index}.png'), np.full((96, 80), 90, np.uint8))
    out = tmp_path / 'line_jitter.yaml'
    assert main(['calibrate', 'jitter', str(tmp_path), '--out', str(out)]) == 1
    assert 'flat: it shows no edge' in capsys.readouterr().err
    assert not out.exists()

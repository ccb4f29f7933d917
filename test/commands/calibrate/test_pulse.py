"""`calibrate pulse` from end to end: a folder of frames, and what is wrong with a source."""

from __future__ import annotations

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from blob_tracker import CameraModel, Frame, Pipeline, SensorNoise
from blob_tracker.__main__ import main
from blob_tracker.calibration.pulse_file import PulseFile
from blob_tracker.camera import CalibrationError
from blob_tracker.simulation import pixel_integrated_gaussian
import cv2
import numpy as np
import pytest
from rosbags.rosbag2 import Writer
import yaml

NOISE = SensorNoise(10.0, 1.0)
WIDTH, HEIGHT = 96, 80


def frames(count: int, moving: bool = True) -> list[np.ndarray]:
    """Return frames of a light with a halo, in every other one, that goes round a circle."""
    random = np.random.default_rng(1)
    shown = []
    for index in range(count):
        turn = 0.07 * index if moving else 0.0
        x, y = WIDTH / 2 + 15.3 * np.cos(turn), HEIGHT / 2 + 14.1 * np.sin(turn)
        mean = np.full((HEIGHT, WIDTH), 30.0)
        if index % 2:
            mean += 80.0 * pixel_integrated_gaussian((HEIGHT, WIDTH), x, y, 1.0)
            mean += 40.0 * pixel_integrated_gaussian((HEIGHT, WIDTH), x, y, 2.5)
        electrons = random.poisson(mean * NOISE.gain)
        noisy = electrons / NOISE.gain + random.normal(0.0, NOISE.read_noise, mean.shape)
        shown.append(np.clip(np.round(noisy), 0, 255).astype(np.uint8))
    return shown


def folder(path: Path, count: int, moving: bool = True) -> Path:
    """Write frames as pictures; return their folder."""
    path.mkdir()
    for index, frame in enumerate(frames(count, moving)):
        assert cv2.imwrite(str(path / f'{index}.png'), frame)
    return path


def run(*words: object) -> int:
    """Run the command with the noise of the frames."""
    noise = ['--gain', str(NOISE.gain), '--read-noise', str(NOISE.read_noise)]
    return main(['calibrate', 'pulse', *map(str, words), *noise])


@pytest.fixture(scope='module')
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a pulse that was learned, what was printed beside it as .txt."""
    place = tmp_path_factory.mktemp('pulse')
    source = folder(place / 'frames', 360)
    with redirect_stdout(StringIO()) as printed:
        assert run(source, '--out', place / 'pulse.yaml', '--light', '850 nm, mono') == 0
    (place / 'pulse.txt').write_text(printed.getvalue())
    return place / 'pulse.yaml'


def test_a_pulse_is_learned_written_drawn_and_read(written: Path) -> None:
    """The halo is in it, which a Gaussian has not; the numbers survive the file."""
    picture = cv2.imread(str(written.with_suffix('.png')))
    assert picture is not None and picture.std() > 10.0
    printed = written.with_suffix('.txt').read_text()
    assert f'-p pulse_url:=file://{written}' in printed.replace('\n', '')
    file = PulseFile.from_yaml(written)
    assert (file.width, file.height, file.light) == (WIDTH, HEIGHT, '850 nm, mono')
    learned, pulse = file.learned, file.learned.pulse
    assert learned.windows > 120
    assert learned.noise == NOISE
    # Half-way out the two Gaussians and the pixel give 0.304 of the peak, one of them 0.19.
    true = pixel_integrated_gaussian((1, 9), 4.0, 0.0, 1.0) * 80.0
    true = true + 40.0 * pixel_integrated_gaussian((1, 9), 4.0, 0.0, 2.5)
    assert pulse.value(2.0, 0.0) == pytest.approx(true[0, 6] / true[0, 4], abs=0.02)
    file.to_yaml(written.with_name('again.yaml'))
    again = PulseFile.from_yaml(written.with_name('again.yaml'))
    assert (again.learned.pulse.coefficients == pulse.coefficients).all()


def test_the_pipeline_fits_it(written: Path) -> None:
    """With the pulse the bearings of other flashes are no fewer than with the Gaussian."""
    model = CameraModel.from_field_of_view(WIDTH, HEIGHT, 20.0)
    shown = [Frame(image, k * 10**7, 255) for k, image in enumerate(frames(40))]
    pulse = PulseFile.from_yaml(written).learned.pulse
    bearings = [
        list(Pipeline(model, noise=NOISE, pulse=each).run(shown)) for each in (None, pulse)
    ]
    assert len(bearings[1]) == len(bearings[0]) > 10
    apart = [one.azimuth - other.azimuth for one, other in zip(*bearings)]
    sigma = np.sqrt(bearings[0][0].covariance[0, 0])
    # One and the same light: they differ by less than its noise, but they do differ.
    assert 0.0 < np.std(apart) < sigma


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        ({'windows': 30}, '30 windows; it takes 100'),
        ({'gap': 0.6}, 'leave 0.60 px of the pixel empty'),
        ({'coefficients': []}, 'n odd and 7 or more'),
        ({'sigma': -1.0}, 'sigma is -1.0 px'),
        ({'step': None}, 'value of the wrong form'),
        ({'noise.gain': 0.0}, 'gain is 0.0'),
    ],
)
def test_a_file_that_cannot_be_used_says_why(
    written: Path, tmp_path: Path, changes: dict[str, object], sentence: str
) -> None:
    """Too little learned from, an empty surface, impossible values."""
    path = tmp_path / 'pulse.yaml'
    path.write_text(yaml.safe_dump({**yaml.safe_load(written.read_text()), **changes}))
    with pytest.raises(CalibrationError, match=sentence):
        PulseFile.from_yaml(path)


def test_an_empty_file_and_another_camera_are_refused(written: Path, tmp_path: Path) -> None:
    """Each with a sentence."""
    (tmp_path / 'empty.yaml').write_text('')
    with pytest.raises(CalibrationError, match='holds no named values'):
        PulseFile.from_yaml(tmp_path / 'empty.yaml')
    with pytest.raises(CalibrationError, match='has 640 x 480; measure it with this camera'):
        PulseFile.from_yaml(written).check_size(640, 480)


def test_a_source_without_enough_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No flash, one frame, no images, too few flashes, a light at rest, a wrong name."""
    (tmp_path / 'dark').mkdir()
    for index in range(6):
        cv2.imwrite(str(tmp_path / 'dark' / f'{index}.png'), np.full((80, 96), 30, np.uint8))
    assert run(tmp_path / 'dark', '--out', tmp_path / 'a.yaml') == 1
    assert 'no flash was found' in capsys.readouterr().err
    assert run(folder(tmp_path / 'one', 1), '--out', tmp_path / 'a.yaml') == 1
    assert 'waiting for a second frame' in capsys.readouterr().err
    (tmp_path / 'notes').mkdir()
    assert run(tmp_path / 'notes', '--out', tmp_path / 'a.yaml') == 1
    assert 'holds no images' in capsys.readouterr().err
    (tmp_path / 'notes' / 'a.png').write_text('none')
    assert run(tmp_path / 'notes', '--out', tmp_path / 'a.yaml') == 1
    assert 'a.png is not an image that can be read' in capsys.readouterr().err
    with Writer(tmp_path / 'bag', version=9):
        pass
    assert run(tmp_path / 'bag', '--out', tmp_path / 'a.yaml') == 1
    assert 'has no images' in capsys.readouterr().err
    assert run(folder(tmp_path / 'few', 60), '--out', tmp_path / 'a.yaml') == 1
    assert 'are too few to learn a pulse from; it takes 100' in ' '.join(
        capsys.readouterr().err.split()
    )
    assert run(folder(tmp_path / 'still', 300, moving=False), '--out', tmp_path / 'a.yaml') == 1
    assert 'let the target move over many pixels' in ' '.join(capsys.readouterr().err.split())
    assert run(tmp_path / 'few', '--out', tmp_path / 'a.png') == 2
    assert not (tmp_path / 'a.yaml').exists()

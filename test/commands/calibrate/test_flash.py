"""`calibrate flash` from end to end: folder, video and bag, and what is wrong with a source."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import re

from blob_tracker.__main__ import main
from blob_tracker.commands.sources import Source, SourceFrame
from blob_tracker.simulation import always, coded, Light, periodic, Scene
from blob_tracker.types import Frame
import cv2
import numpy as np
import pytest
import yaml

RATE = 60.0
BAG = Path(__file__).parents[2] / 'bags' / 'flash_mcap'


def frames(count: int, *lights: Light) -> Iterator[np.ndarray]:
    """Yield frames of lights."""
    scene = Scene(elements=lights, width=128, height=96, rate=RATE, exposure=0.5, texture=0.0)
    for index in range(count):
        yield scene.frame(index)


TWO = (
    Light(30.2, 30.7, 2.0, 120.0, periodic(10.0, 0.5)),
    Light(90.6, 60.1, 2.0, 120.0, coded('1101000', 1.0 / 59.7)),
)


def folder(path: Path, count: int, *lights: Light) -> Path:
    """Write frames as pictures; return their folder."""
    path.mkdir()
    for index, frame in enumerate(frames(count, *lights)):
        assert cv2.imwrite(str(path / f'{index}.png'), frame)
    return path


def run(*words: object) -> int:
    """Run the command."""
    return main(['calibrate', 'flash', *map(str, words)])


def parameters(path: Path, node: str = 'segmenter') -> dict[str, object]:
    """Return what was written for a node."""
    return yaml.safe_load(path.read_text())[f'/**/{node}']['ros__parameters']


def test_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Both lights are listed, drawn, and written with what tracks them; codes stay text."""
    source = folder(tmp_path / 'frames', 120, *TWO)
    out = tmp_path / 'flash.yaml'
    assert run(source, '--frame-rate', RATE, '--exposure', 0.5 / RATE, '--out', out) == 0
    found = parameters(out)
    assert found['flash.mode'] == 'coded'
    assert found['flash.codes'] in ('light_1:1101000', 'light_2:1101000')
    assert str(found['flash.frequencies']).partition(':')[2] == '10'
    assert found['flash.bits_per_second'] == pytest.approx(59.7, abs=0.1)
    for node in ('locator', 'tracker'):
        assert parameters(out, node) == {'lights': 'light_1,light_2'}
    printed = capsys.readouterr().out.replace('\n', ' ')
    assert re.search('wave of (9.99|10.00)', printed) and 'code 1101000, free-running' in printed
    assert '-p flash.mode:=coded -p flash.codes:=' in printed
    picture = cv2.imread(str(out.with_suffix('.png')))
    assert picture is not None and picture.std() > 10.0


def test_a_video(tmp_path: Path) -> None:
    """Its own stamps tell the rate."""
    source = tmp_path / 'light.avi'
    video = cv2.VideoWriter(
        str(source), cv2.VideoWriter.fourcc(*'MJPG'), RATE, (128, 96), isColor=False
    )
    for frame in frames(100, TWO[0]):
        video.write(frame)
    video.release()
    assert run(source, '--out', tmp_path / 'flash.yaml') == 0
    found = parameters(tmp_path / 'flash.yaml')
    assert found['flash.mode'] == 'periodic'
    assert found['flash.frequency'] == pytest.approx(10.0, abs=0.02)


def test_a_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The test bag's light is on in every other frame; one frame is missing."""
    assert run(BAG, '--out', tmp_path / 'flash.yaml') == 0
    assert parameters(tmp_path / 'flash.yaml') == {'flash.mode': 'alternate'}
    assert 'on in every other frame' in capsys.readouterr().out


def test_gaps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The longest series between them is taken, however late a single frame is; both are said."""
    stamps = np.arange(150) / RATE
    stamps[100:] += 2.0
    stamps[60] = stamps[58]

    source = Source([
        SourceFrame('', Frame(frame, round(1e9 * stamp), 255), True)
        for stamp, frame in zip(stamps, frames(150, TWO[0]))
    ])
    monkeypatch.setattr(
        'blob_tracker.commands.sources.shown_frames.open_source', lambda *_, **__: source
    )
    assert run(tmp_path / 'light.mp4', '--out', tmp_path / 'flash.yaml') == 0
    told = capsys.readouterr()
    words = ' '.join(told.out.split())
    assert '2 series: the longest is taken, of 1.6 s; 0.8 s of others are left out' in words
    assert 'frame left out' in told.err
    assert parameters(tmp_path / 'flash.yaml')['flash.frequency'] == pytest.approx(10.0, abs=0.05)


def test_nothing_blinks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A lamp that is always on is no light; how long to record is said."""
    source = folder(tmp_path / 'frames', 30, Light(30.2, 30.7, 2.0, 120.0, always))
    assert run(source, '--frame-rate', RATE, '--out', tmp_path / 'flash.yaml') == 1
    assert 'nothing blinks in 0.5 s; record 3 s' in capsys.readouterr().err
    assert not (tmp_path / 'flash.yaml').exists()


def test_too_short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is listed, with the length that would do; nothing is written."""
    source = folder(tmp_path / 'frames', 12, TWO[1])
    assert run(source, '--frame-rate', RATE, '--out', tmp_path / 'flash.yaml') == 0
    printed = ' '.join(capsys.readouterr().out.split())
    assert 'its pattern did not come twice: record' in printed
    assert 'none of these can be tracked' in printed
    assert not (tmp_path / 'flash.yaml').exists()


@pytest.mark.parametrize('words, sentence', [
    (('--exposure', '8'), '--exposure is 8 s; it must be 0 to 1 s'),
    (('--out', 'flash.png'), 'is the name of the picture beside it'),
])
def test_wrong_options(
    tmp_path: Path, words: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything is read."""
    assert run(tmp_path, *words) == 2
    assert sentence in capsys.readouterr().err


def test_no_stamps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Images have none; what gives them some is said."""
    source = folder(tmp_path / 'frames', 1, TWO[0])
    assert run(source, '--out', tmp_path / 'flash.yaml') == 1
    assert 'have no stamps: give their rate, --frame-rate 60' in capsys.readouterr().err


def test_a_video_that_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Said in a sentence."""
    (tmp_path / 'light.mp4').write_text('no video')
    assert run(tmp_path / 'light.mp4', '--out', tmp_path / 'flash.yaml') == 1
    assert 'is not a video that OpenCV can read' in capsys.readouterr().err

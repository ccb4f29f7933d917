"""`calibrate rig` from end to end: a bag of rays to parameters, and what is wrong with a bag."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.__main__ import main
from blob_tracker.simulation.waved_light import RigCamera
import numpy as np
import pytest
from support.bags_of_rays import recorded_rays
import yaml

CAMERAS = {
    'left': RigCamera((-1.0, 0.0, 0.0)), 'right': RigCamera((1.0, 0.0, 0.0), offset=0.012),
}


def run(*words: object) -> int:
    """Run the command."""
    return main(['calibrate', 'rig', *map(str, words)])


def test_a_wand(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Poses, clocks and sigmas go into the file that the triangulator takes, and a picture."""
    bag = recorded_rays(tmp_path / 'bag', 0.5, ('red', 'blue'), CAMERAS)
    out = tmp_path / 'rig.yaml'
    assert run(
        bag, '--cameras', 'left', '/right', '--wand', 'red', 'blue', 0.5, 0.0001, '--out', out
    ) == 0
    text = out.read_text()
    found = yaml.safe_load(text)['/**/triangulator']['ros__parameters']
    assert found['cameras'] == ['left', 'right']
    left, right = (
        {key: found[f'poses.{name}.{key}'] for key in ('x', 'y', 'z', 'yaw')}
        for name in ('left', 'right')
    )
    covariance = np.zeros((12, 12))
    covariance[np.tril_indices(12)] = found['pose_covariance']
    assert not covariance[:6].any()
    assert left['x'] == 0.0
    # The cameras look at a point 3 m ahead from 1 m aside each: 2 m apart, turned towards it.
    apart = np.hypot(right['x'], right['y'])
    sigma = np.sqrt(covariance.diagonal()[9:].max())
    assert 0.0 < sigma < 0.002
    assert abs(apart - 2.0) < 5.0 * sigma
    assert abs(right['z']) < 5.0 * sigma
    assert abs((right['yaw'] - left['yaw']) - 2.0 * np.arctan(1.0 / 3.0)) < 1e-3
    assert max(map(len, text.splitlines()[-10:])) <= 99
    assert 'right +12.0' in text or 'right +11.9' in text  # 16 us is its sigma
    assert '--child-frame-id right/optical' in text
    assert out.with_suffix('.png').read_bytes().startswith(b'\x89PNG')
    assert 'right clock ahead' in capsys.readouterr().out


def test_without_a_scale_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The picture is there, and the exit code tells."""
    bag = recorded_rays(tmp_path / 'bag', 0.0, ('',), CAMERAS)
    out = tmp_path / 'rig.yaml'
    assert run(bag, '--cameras', 'left', 'right', '--out', out) == 1
    assert not out.exists()
    assert out.with_suffix('.png').exists()
    assert 'give --wand or --baseline' in capsys.readouterr().err
    assert run(bag, '--cameras', 'left', 'top', '--out', out) == 1
    said = capsys.readouterr().err
    assert 'no rays on /top/target/ray' in said
    assert '/right/target/ray' in said


@pytest.mark.parametrize('words, sentence', [
    (('--wand', 'red', 'blue'), 'LIGHT LIGHT M'),
    (('--wand', 'red', 'blue', 'half'), 'LIGHT LIGHT M'),
    (('--baseline', 'left', 'right', 'nan'), 'CAMERA CAMERA M'),
    (('--wand', 'red', 'blue', '0.5', '--light', 'red'), 'named with it'),
    (('--most-offset', '-1'), '0 to 10 s'),
    (('--wand', 'red', 'red', '0.5'), 'a wand has two lights'),
    (('--frame-id', 'a"b'), 'the name of a frame'),
])
def test_options_that_are_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], sentence: str
) -> None:
    """They are refused before the bag is opened."""
    assert run(tmp_path / 'none', '--cameras', 'left', 'right', *words) == 2
    assert sentence in capsys.readouterr().err

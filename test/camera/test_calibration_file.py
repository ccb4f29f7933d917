"""Calibration files: each way in which one can be wrong has its sentence."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.resources import config_path
import pytest


@pytest.mark.parametrize(
    'text, sentence',
    [
        ('{', 'is not YAML'),
        ('', 'holds no named values'),
        ('[1, 2]', 'holds no named values'),
        ('image_width: 640', 'has no image_height'),
        (None, 'value of the wrong form'),
    ],
)
def test_broken_file_says_what_is_wrong(text: str | None, sentence: str, tmp_path: Path) -> None:
    """Not YAML, not a calibration, a value missing, a value of the wrong form."""
    path = tmp_path / 'camera.yaml'
    good = config_path('camera_info.yaml').read_text()
    if text is None:
        text = good.replace('[600.0, 0.0, 319.5,', '[600.0, 319.5,')
    path.write_text(text)
    with pytest.raises(CalibrationError, match=sentence) as caught:
        CameraModel.from_yaml(path)
    assert str(path) in str(caught.value)


def test_missing_file_is_named() -> None:
    """The path that was tried is in the sentence."""
    with pytest.raises(CalibrationError, match='cannot read the calibration /no/such.yaml'):
        CameraModel.from_yaml('/no/such.yaml')


def test_impossible_value_names_the_file(tmp_path: Path) -> None:
    """A focal length of 0 in a file is found in that file."""
    path = tmp_path / 'camera.yaml'
    good = config_path('camera_info.yaml').read_text()
    path.write_text(good.replace('[600.0, 0.0, 319.5,', '[0.0, 0.0, 319.5,'))
    with pytest.raises(CalibrationError, match='camera.yaml: the focal lengths are 0 and 600'):
        CameraModel.from_yaml(path)

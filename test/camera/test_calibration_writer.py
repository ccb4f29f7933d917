"""Calibration files that are written: whole, to the last digit, or not at all."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

from blob_tracker.camera import CalibrationError, CameraModel, write_calibration
from blob_tracker.camera.calibration_reader import read_calibration
from hypothesis import given, settings, strategies
import numpy as np
import pytest
from support.calibration_files import OF_ROS
from support.camera_models import EQUIDISTANT, MODELS, PINHOLE
import yaml


def check_same(one: CameraModel, other: CameraModel) -> None:
    """Assert that two calibrations are the same to the last digit."""
    for field in dataclasses.fields(CameraModel):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


def explicit(model: CameraModel) -> CameraModel:
    """Return a camera with its R and P written out, as a file has them."""
    return dataclasses.replace(
        model, rectification=model.rectification_matrix, projection=model.projection_matrix
    )


@pytest.mark.parametrize('name', MODELS)
def test_written_file_is_read_back(name: str, tmp_path: Path) -> None:
    """Every model, every number, the comments on top, into folders that were not there."""
    model = explicit(dataclasses.replace(MODELS[name], name='north_mast'))
    path = tmp_path / 'a' / 'b' / 'camera.yaml'
    write_calibration(path, model, ['focal length 600.1 +- 0.2 px', 'two\nlines', ''])
    check_same(CameraModel.from_file(path), model)
    lines = path.read_text().splitlines()
    assert lines[:5] == ['# focal length 600.1 +- 0.2 px', '# two', '# lines', '#',
                         'image_width: 640']
    assert list(yaml.safe_load(path.read_text())) == list(yaml.safe_load(OF_ROS))
    assert os.listdir(path.parent) == ['camera.yaml']  # nothing half done is left beside it


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    values=strategies.lists(
        strategies.floats(allow_nan=False, allow_infinity=False), min_size=16, max_size=16
    ),
    name=strategies.text(
        strategies.characters(codec='utf-8', exclude_categories=['Cc', 'Cs']), min_size=1
    ),
)
def test_every_digit_is_kept(
    values: list[float], name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Whatever the doubles are, subnormal or huge, and the name."""
    model = dataclasses.replace(
        EQUIDISTANT, distortion=np.array(values[:4]), projection=np.reshape(values[4:], (3, 4)),
        rectification=np.eye(3), name=name,
    )
    path = tmp_path_factory.mktemp('digits') / 'camera.yaml'
    write_calibration(path, model)
    # No camera has such a lens: `from_file` would look for its rays.
    check_same(CameraModel(**read_calibration(path).arguments), model)
    # Plain numbers for every YAML reader: PyYAML takes 1e-05, without a point, for a word.
    data = yaml.safe_load(path.read_text())['distortion_coefficients']['data']
    assert all(isinstance(value, float) for value in data)


def test_file_is_replaced_and_its_link_kept(tmp_path: Path) -> None:
    """What a link leads to is written, not over the link; the mode is as of any new file."""
    path, link = tmp_path / 'camera.yaml', tmp_path / 'link.yaml'
    path.write_text('old')
    link.symlink_to(path)
    write_calibration(link, PINHOLE)
    assert link.is_symlink()
    check_same(CameraModel.from_file(path), explicit(PINHOLE))
    (tmp_path / 'new').touch()
    assert path.stat().st_mode == (tmp_path / 'new').stat().st_mode


def test_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    """A folder below a file, and a folder instead of a file; nothing is left behind."""
    (tmp_path / 'file').touch()
    with pytest.raises(CalibrationError, match='cannot write the calibration .*file/camera.yaml'):
        write_calibration(tmp_path / 'file' / 'camera.yaml', PINHOLE)
    (tmp_path / 'folder').mkdir()
    with pytest.raises(CalibrationError, match='cannot write the calibration .*directory'):
        write_calibration(tmp_path / 'folder', PINHOLE)
    assert sorted(os.listdir(tmp_path)) == ['file', 'folder']


def test_failure_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A full disk, found when the content is to be kept: the calibration before it is whole."""
    path = tmp_path / 'camera.yaml'
    write_calibration(path, PINHOLE)
    before = path.read_text()

    def full(_: int) -> None:
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(os, 'fsync', full)
    with pytest.raises(CalibrationError, match='No space left on device'):
        write_calibration(path, EQUIDISTANT)
    assert path.read_text() == before
    assert os.listdir(tmp_path) == ['camera.yaml']

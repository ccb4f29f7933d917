"""Calibration files: each way in which one can be wrong has its sentence."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

from blob_tracker.camera import CalibrationError, CameraModel, write_calibration
from blob_tracker.resources import config_path
from hypothesis import given, settings, strategies
import numpy as np
import pytest
from support.camera_models import EQUIDISTANT, MODELS, PINHOLE
import yaml

# As the cameracalibrator of ROS' image_pipeline writes it: numbers padded to columns, zeros
# without digits after the point, exponents without a point before.
OF_ROS = """image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [504.10382,   0.     , 321.80917,
           0.     , 505.91447, 240.34672,
           0.     ,   0.     ,   1.     ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.176832, -0.313041, 1e-05, -0.000812, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1., 0., 0.,
         0., 1., 0.,
         0., 0., 1.]
projection_matrix:
  rows: 3
  cols: 4
  data: [517.82166,   0.     , 320.93245,   0.     ,
           0.     , 521.45001, 240.00123,   0.     ,
           0.     ,   0.     ,   1.     ,   0.     ]
"""


def check_same(one: CameraModel, other: CameraModel) -> None:
    """Assert that two calibrations are the same to the last digit."""
    for field in dataclasses.fields(CameraModel):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


def explicit(model: CameraModel) -> CameraModel:
    """Return a camera with its R and P written out, as a file has them."""
    return dataclasses.replace(
        model, rectification=model.rectification_matrix, projection=model.projection_matrix
    )


@pytest.mark.parametrize(
    'text, sentence',
    [
        ('{', 'is not YAML'),
        ('', 'holds no named values'),
        ('[1, 2]', 'holds no named values'),
        ('image_width: 640', 'has no image_height'),
        (None, 'value of the wrong form'),
        ('image_width: 640.5\nimage_height: 480', 'a size of 640.5 px'),
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


def test_a_device_is_not_read() -> None:
    """It may never end."""
    with pytest.raises(CalibrationError, match='/dev/zero: it is no regular file'):
        CameraModel.from_yaml('/dev/zero')


def test_impossible_value_names_the_file(tmp_path: Path) -> None:
    """A focal length of 0 in a file is found in that file."""
    path = tmp_path / 'camera.yaml'
    good = config_path('camera_info.yaml').read_text()
    path.write_text(good.replace('[600.0, 0.0, 319.5,', '[0.0, 0.0, 319.5,'))
    with pytest.raises(CalibrationError, match='camera.yaml: the focal lengths are 0 and 600'):
        CameraModel.from_yaml(path)


# What camera_calibration_parsers may put at the end; it says nothing of K.
OF_THE_MESSAGE = """binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: false
"""


@pytest.mark.parametrize('more', ['', OF_THE_MESSAGE])
def test_file_of_the_ros_calibrator_is_read(more: str, tmp_path: Path) -> None:
    """Every number of it, R and P included."""
    path = tmp_path / 'ost.yaml'
    path.write_text(OF_ROS + more)
    model = CameraModel.from_yaml(path)
    assert (model.width, model.height, model.name) == (640, 480, 'narrow_stereo')
    assert model.matrix.tolist() == [
        [504.10382, 0.0, 321.80917], [0.0, 505.91447, 240.34672], [0.0, 0.0, 1.0]
    ]
    assert model.distortion.tolist() == [0.176832, -0.313041, 1e-5, -0.000812, 0.0]
    assert model.rectification is not None and (model.rectification == np.eye(3)).all()
    assert model.projection is not None and model.projection[1, 1] == 521.45001


@pytest.mark.parametrize('name', ['camera_name', 'distortion_model', 'rectification_matrix',
                                  'projection_matrix'])
def test_what_ros_can_do_without_may_be_missing(name: str, tmp_path: Path) -> None:
    """The camera is then `camera`, the model plumb_bob, R identity and P K."""
    content = yaml.safe_load(OF_ROS)
    del content[name]
    path = tmp_path / 'camera.yaml'
    path.write_text(yaml.safe_dump(content))
    model = CameraModel.from_yaml(path)
    if name == 'camera_name':
        assert model.name == 'camera'
    assert model.distortion_model == 'plumb_bob'
    if name == 'projection_matrix':
        np.testing.assert_array_equal(model.projection_matrix[:, :3], model.matrix)
    np.testing.assert_array_equal(model.rectification_matrix, np.eye(3))


@pytest.mark.parametrize(
    'model, count',
    [('plumb_bob', 4), ('plumb_bob', 5), ('rational_polynomial', 8), ('rational_polynomial', 12),
     ('rational_polynomial', 14), ('equidistant', 4), ('fisheye', 4)],
)
@pytest.mark.parametrize('upright', [True, False])
def test_coefficients_of_each_number(
    model: str, count: int, upright: bool, tmp_path: Path
) -> None:
    """In one row as ROS writes them, or in one column as OpenCV does."""
    content = yaml.safe_load(OF_ROS)
    values = [0.01 * (index + 1) for index in range(count)]
    rows, columns = (count, 1) if upright else (1, count)
    content['distortion_model'] = model
    content['distortion_coefficients'] = {'rows': rows, 'cols': columns, 'data': values}
    path = tmp_path / 'camera.yaml'
    path.write_text(yaml.safe_dump(content))
    read = CameraModel.from_yaml(path)
    assert read.distortion.tolist() == values
    # Some releases of ROS' calibrator call it fisheye; nothing else in ROS does.
    assert read.distortion_model == model.replace('fisheye', 'equidistant')


@pytest.mark.parametrize('name', MODELS)
def test_written_file_is_read_back(name: str, tmp_path: Path) -> None:
    """Every model, every number, the comments on top, into folders that were not there."""
    model = explicit(dataclasses.replace(MODELS[name], name='north_mast'))
    path = tmp_path / 'a' / 'b' / 'camera.yaml'
    write_calibration(path, model, ['focal length 600.1 +- 0.2 px', 'two\nlines', ''])
    check_same(CameraModel.from_yaml(path), model)
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
    check_same(CameraModel.from_yaml(path), model)
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
    check_same(CameraModel.from_yaml(path), explicit(PINHOLE))
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

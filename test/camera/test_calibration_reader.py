"""Calibration files that are read: each way in which one can be wrong has its sentence."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.resources import config_path
import numpy as np
import pytest
from support.calibration_files import OF_ROS
import yaml


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
        CameraModel.from_file(path)
    assert str(path) in str(caught.value)


def test_missing_file_is_named() -> None:
    """The path that was tried is in the sentence."""
    with pytest.raises(CalibrationError, match='cannot read the calibration /no/such.yaml'):
        CameraModel.from_file('/no/such.yaml')


def test_a_device_is_not_read() -> None:
    """It may never end."""
    with pytest.raises(CalibrationError, match='/dev/zero: it is not a regular file'):
        CameraModel.from_file('/dev/zero')


def test_impossible_value_names_the_file(tmp_path: Path) -> None:
    """A focal length of 0 in a file is found in that file."""
    path = tmp_path / 'camera.yaml'
    good = config_path('camera_info.yaml').read_text()
    path.write_text(good.replace('[600.0, 0.0, 319.5,', '[0.0, 0.0, 319.5,'))
    with pytest.raises(CalibrationError, match='camera.yaml: the focal lengths are 0 and 600'):
        CameraModel.from_file(path)


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
    model = CameraModel.from_file(path)
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
    model = CameraModel.from_file(path)
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
    read = CameraModel.from_file(path)
    assert read.distortion.tolist() == values
    # Some releases of ROS' calibrator call it fisheye; nothing else in ROS does.
    assert read.distortion_model == model.replace('fisheye', 'equidistant')

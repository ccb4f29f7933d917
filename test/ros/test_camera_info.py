"""camera_info to the camera model and back."""

from __future__ import annotations

from math import nan

from blob_tracker.camera import CalibrationError, CameraModel, pinhole_matrix
from blob_tracker.ros.camera_info import from_camera_model, of_window, stamped, to_camera_model
from blob_tracker.ros.errors import MessageError
from blob_tracker.types import Window
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo

MODEL = CameraModel(
    640, 480, pinhole_matrix(600.0, 640, 480), np.array([-0.2, 0.1, 0.0, 0.0, 0.01])
)


def test_round_trip_keeps_every_number() -> None:
    """K, D, model and size survive."""
    back = to_camera_model(from_camera_model(MODEL, 640, 480))
    np.testing.assert_array_equal(back.matrix, MODEL.matrix)
    np.testing.assert_array_equal(back.distortion, MODEL.distortion)
    assert (back.width, back.height, back.distortion_model) == (640, 480, 'plumb_bob')


def test_another_size_is_an_error_not_a_scale() -> None:
    """The sentence has both sizes."""
    with pytest.raises(CalibrationError, match='for 640 x 480 px and the camera gives 320 x 240'):
        from_camera_model(MODEL, 320, 240)


def test_no_calibration_is_k_of_zero() -> None:
    """ROS' sign of a camera that is not calibrated, which no bearing can be made with."""
    info = from_camera_model(None, 320, 240)
    assert (info.width, info.height, info.k[0]) == (320, 240, 0.0)
    with pytest.raises(MessageError, match='not calibrated has 0: set camera_info_url'):
        to_camera_model(info)


@pytest.mark.parametrize('value', [nan, 0.0, -600.0])
def test_impossible_focal_length_is_refused(value: float) -> None:
    """NaN, zero and negative."""
    info = from_camera_model(MODEL, 640, 480)
    info.k[0] = value
    with pytest.raises(MessageError, match='camera_info: '):
        to_camera_model(info)


def test_window_is_written_as_a_region_of_the_sensor() -> None:
    """REP 104: offset and size in full-resolution, unbinned pixels."""
    window = Window(np.zeros((5, 7), np.uint8), x0=12, y0=34, binning=(2, 4))
    info = of_window(stamped(CameraInfo(), 3_000_000_001, 'optical'), window)
    roi = info.roi
    assert (roi.x_offset, roi.y_offset, roi.width, roi.height) == (12, 34, 14, 20)
    assert (info.header.stamp.sec, info.header.stamp.nanosec) == (3, 1)

"""What the calibrator of image_pipeline sends is stored and in use."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from blob_tracker.camera import CameraModel
import numpy as np
import pytest
from sensor_msgs.srv import SetCameraInfo
from support.clients import needs
from support.processes import probe, start

needs('camera_calibration')

SIZE = 640, 480
MATRIX = np.array([[601.0, 0.0, 312.5], [0.0, 603.0, 245.5], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize('kind, coefficients, model', [
    ('PINHOLE', 5, 'plumb_bob'),
    ('PINHOLE', 8, 'rational_polynomial'),
    ('FISHEYE', 4, 'equidistant'),
])
def test_its_message_is_stored(
    kind: str, coefficients: int, model: str, domain: int, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As the button COMMIT sends it, with each of its lens models."""
    calibrator = import_module('camera_calibration.calibrator')
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    distortion = np.linspace(-0.02, 0.01, coefficients)
    info = calibrator.Calibrator.lrmsg(
        distortion, MATRIX, np.eye(3), np.hstack([MATRIX, np.zeros((3, 1))]), SIZE,
        calibrator.CAMERA_MODEL[kind],
    )
    with probe(domain) as node, start('camera', domain, device='/dev/no_such_camera'):
        answer = node.call(
            SetCameraInfo, 'camera/set_camera_info', SetCameraInfo.Request(camera_info=info)
        )
        assert answer.success, answer.status_message
    stored = CameraModel.from_file(tmp_path / 'camera_info' / 'camera.yaml')
    assert stored.distortion_model == model
    assert (stored.width, stored.height) == SIZE
    np.testing.assert_allclose(stored.matrix, MATRIX)
    np.testing.assert_allclose(stored.distortion, distortion)

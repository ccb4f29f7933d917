"""Frames in, bearings out, without ROS: within the budget, and with a true covariance."""

from blob_tracker import CameraModel, Frame, Pipeline
from blob_tracker.camera import CalibrationError
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.resources import config_path
from blob_tracker.simulation import flashing_light
import numpy as np
import pytest

FRAMES = 240
BUDGET = 0.05  # px rms, what the thesis wanted


def test_every_lit_frame_is_placed_within_the_budget() -> None:
    """All pairs of four seconds are found, 0.05 px rms at most, and the NEES is near 2."""
    scene = flashing_light()
    model = CameraModel.from_yaml(config_path('camera_info.yaml'))
    frames = (Frame(scene.frame(k), 1 + round(k * 1e9 / 60), 255) for k in range(FRAMES))
    bearings = list(Pipeline(model, noise=scene.sensor.noise).run(frames))
    assert [round(bearing.stamp_ns * 60 / 1e9) for bearing in bearings] == [*range(2, FRAMES, 2)]
    errors, nees = [], []
    for bearing in bearings:
        truth = scene.truth(round(bearing.stamp_ns * 60 / 1e9))
        azimuth, elevation, derivative = model.angles(truth.x, truth.y)
        error = np.array([bearing.azimuth - azimuth, bearing.elevation - elevation])
        nees.append(error @ np.linalg.solve(bearing.covariance, error))
        errors.append(np.linalg.solve(derivative, error))
    assert np.sqrt(np.mean(np.square(errors))) <= BUDGET
    # The mean of n draws of chi-square with 2 degrees of freedom: 95 % of them lie within this.
    assert abs(np.mean(nees) - 2.0) < 1.96 * 2.0 / np.sqrt(len(nees))


def test_late_frames_are_left_out_and_wrong_use_is_named() -> None:
    """A frame that comes twice ends nothing; an unknown method or another size does."""
    scene = flashing_light(width=160, height=120)
    model = CameraModel.from_field_of_view(160, 120, 50.0)
    frames = [Frame(scene.frame(k), 1 + k * 10**7, 255) for k in (1, 1, 2)]
    assert len(list(Pipeline(model, noise=scene.sensor.noise).run(frames))) == 1
    with pytest.raises(ValueError, match="no method 'magic'; there is centroid"):
        Pipeline(model, noise=scene.sensor.noise, method='magic')
    small = CameraModel.from_field_of_view(100, 100, 50.0)
    with pytest.raises(CalibrationError, match=r'reaches to \(160, 120\) px'):
        list(Pipeline(small, noise=scene.sensor.noise).run(frames))


def test_no_flash_is_silence() -> None:
    """Frames without a flash yield nothing."""
    scene = flashing_light(width=160, height=120)
    model = CameraModel.from_field_of_view(160, 120, 50.0)
    dark = [Frame(scene.frame(1), 1, 255), Frame(scene.frame(3), 10**7, 255)]
    assert list(Pipeline(model, noise=scene.sensor.noise).run(dark)) == []


def test_line_jitter_is_taken_off() -> None:
    """Bearings turn by the offset of their lines; jitter of another height is an error."""
    scene = flashing_light(width=160, height=120)
    model = CameraModel.from_field_of_view(160, 120, 50.0)
    frames = [Frame(scene.frame(k), 1 + k * 10**7, 255) for k in range(4)]
    jitter = LineJitter(np.full(120, 0.25), np.zeros(120), 0.0)
    plain, corrected = (
        list(Pipeline(model, noise=scene.sensor.noise, line_jitter=each).run(frames))
        for each in (None, jitter)
    )
    assert len(plain) == len(corrected) > 0
    for without, taken_off in zip(plain, corrected):
        # d azimuth / dx is f / (f^2 + x^2): within 22 % of 1 / f at 25 degrees.
        expected = -1e3 * 0.25 / model.matrix[0, 0]
        assert taken_off.azimuth - without.azimuth == pytest.approx(expected, rel=0.22)
    with pytest.raises(CalibrationError, match='is for 120 lines and the picture has 240'):
        larger = CameraModel.from_field_of_view(320, 240, 50.0)
        Pipeline(larger, noise=scene.sensor.noise, line_jitter=jitter)

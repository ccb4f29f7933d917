"""camera_info to the camera model and back."""

from __future__ import annotations

import dataclasses
from math import nan

from blob_tracker.camera import CalibrationError, CameraModel, pinhole_matrix
from blob_tracker.pipeline import Pipeline
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.camera_info import (
    from_camera_model, KnownCamera, stamped, to_camera_model,
)
from blob_tracker.ros.messages.image import from_pixels, to_frame
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo
from support.camera_models import MODELS
from support.window_messages import of_window

MODEL = CameraModel(
    640, 480, pinhole_matrix(600.0, 640, 480), np.array([-0.2, 0.1, 0.0, 0.0, 0.01])
)


def test_round_trip_keeps_every_number() -> None:
    """K, D, model and size survive."""
    back = to_camera_model(from_camera_model(MODEL, 640, 480))
    np.testing.assert_array_equal(back.matrix, MODEL.matrix)
    np.testing.assert_array_equal(back.distortion, MODEL.distortion)
    assert (back.width, back.height, back.distortion_model) == (640, 480, 'plumb_bob')


@pytest.mark.parametrize('name', MODELS)
def test_every_lens_survives(name: str) -> None:
    """The camera that comes out of the message looks in the same directions."""
    back = to_camera_model(from_camera_model(MODELS[name], 640, 480))
    for pixel in ((0.0, 0.0), (600.0, 20.0)):
        assert back.angles(*pixel)[:2] == MODELS[name].angles(*pixel)[:2]


def test_fisheye_is_equidistant() -> None:
    """The name that some releases of ROS' calibrator give to set_camera_info."""
    info = from_camera_model(MODELS['equidistant'], 640, 480)
    info.distortion_model = 'fisheye'
    assert to_camera_model(info).distortion_model == 'equidistant'


def test_rectification_is_carried_along() -> None:
    """R and P of a calibration reach camera_info and come back; where all is 0 there is none."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    info = from_camera_model(
        dataclasses.replace(MODEL, rectification=turn, projection=2.0 * np.eye(3, 4)), 640, 480
    )
    back = to_camera_model(info)
    np.testing.assert_array_equal(back.rectification_matrix, turn)
    np.testing.assert_array_equal(back.projection_matrix, 2.0 * np.eye(3, 4))
    info.r, info.p = np.zeros(9), np.zeros(12)
    np.testing.assert_array_equal(to_camera_model(info).rectification_matrix, np.eye(3))
    np.testing.assert_array_equal(to_camera_model(info).projection_matrix[:, :3], MODEL.matrix)


def test_another_size_is_an_error_not_a_scale() -> None:
    """The sentence has both sizes."""
    with pytest.raises(CalibrationError, match='for 640 x 480 px and the camera gives 320 x 240'):
        from_camera_model(MODEL, 320, 240)
    # Too small and too large, whatever part of the sensor the images are.
    for size in ((1280, 960), (641, 480)):
        sizes = f'for 640 x 480 px and the camera gives {size[0]} x {size[1]} px without crop'
        with pytest.raises(CalibrationError, match=sizes):
            from_camera_model(MODEL, 320, 240, x0=8, y0=8, sensor_size=size)
    with pytest.raises(CalibrationError, match='gives 408 x 308 px without crop'):
        from_camera_model(MODEL, 400, 300, x0=8, y0=8)


def test_calibration_of_binned_images_is_named() -> None:
    """It has the images' size, but K belongs to the sensor without binning."""
    with pytest.raises(CalibrationError, match='binned size, 640 x 480 .*with binning off'):
        from_camera_model(MODEL, 640, 480, binning=(2, 2), sensor_size=(1280, 960))


@pytest.mark.parametrize(
    'place, roi',
    [
        ({}, (0, 0, 0, 0)),
        ({'binning': (2, 2)}, (0, 0, 0, 0)),  # 0 x 0 is the whole sensor
        ({'x0': 160, 'y0': 60}, (160, 60, 480, 420)),
        ({'x0': 160, 'y0': 60, 'binning': (2, 4)}, (160, 60, 480, 420)),
    ],
)
def test_crop_and_binning_are_written(place: dict, roi: tuple[int, ...]) -> None:
    """REP 104: width, height and K of the sensor, the roi in its pixels, with and without K."""
    bins = place.get('binning', (1, 1))
    size = (640 - roi[0]) // bins[0], (480 - roi[1]) // bins[1]
    for model in (MODEL, None):
        info = from_camera_model(model, *size, sensor_size=(640, 480), **place)
        assert (info.width, info.height) == (640, 480)
        written = info.roi
        assert (written.x_offset, written.y_offset, written.width, written.height) == roi
        assert (info.binning_x, info.binning_y) == bins
        assert info.k[0] == (0.0 if model is None else 600.0)
    assert from_camera_model(None, *size, **place) == info  # the images reach to the edges here


def test_an_odd_sensor_that_is_binned_is_whole() -> None:
    """The column that is left over makes no crop of it."""
    info = from_camera_model(None, 320, 244, binning=(2, 2), sensor_size=(641, 489))
    assert info.roi.width == 0
    to_frame(from_pixels(np.zeros((244, 320), np.uint8), 0, ''), info)


@pytest.mark.parametrize('name', ['tilted', 'skewed', 'equidistant'])
def test_crop_and_binning_leave_the_bearing(name: str) -> None:
    """
    A light has the same bearing whatever part of the sensor is read, binned or not.

    From pixels on the sensor, that are summed as the camera's chip does, by each message to the
    frame and the camera model, and by the segmenter's window to the bearing.
    """
    model = MODELS[name]
    x, y = 437.25, 129.75  # px of the sensor, neither in the middle of a pixel nor of a bin
    rows, columns = np.mgrid[:480, :640]
    light = 150.0 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2.0 * 4.0**2))
    azimuth, elevation, derivative = model.angles(x, y)
    random = np.random.default_rng(3)
    for x0, y0, width, height, binning in (
        (0, 0, 640, 480, 1),
        (161, 60, 400, 300, 1),
        (161, 60, 200, 150, 2),
    ):
        info = from_camera_model(
            model, width, height, x0=x0, y0=y0, binning=(binning, binning),
            sensor_size=(640, 480),
        )
        read = np.s_[y0:y0 + height * binning, x0:x0 + width * binning]
        bins = light[read].reshape(height, binning, width, binning).mean(axis=(1, 3))
        frames = []
        for index in range(12):
            pixels = random.normal(20.0 + (index % 2) * bins, 0.7).round().astype(np.uint8)
            image = from_pixels(pixels, index * 20_000_000, 'optical')
            frames.append(to_frame(image, info))
        assert (frames[0].x0, frames[0].y0, frames[0].binning) == (x0, y0, (binning, binning))
        pipeline = Pipeline(
            to_camera_model(info), noise=SensorNoise(gain=1e6, read_noise=0.7)
        )
        bearings = list(pipeline.run(frames))
        assert len(bearings) >= 3, pipeline.segmenter.reason
        mean = np.mean([(b.azimuth, b.elevation) for b in bearings], axis=0)
        off = np.linalg.solve(derivative, mean - [azimuth, elevation])
        # The bound for one frame is 0.007 px; half a pixel of a wrong bin would be 0.5.
        assert np.abs(off).max() < 0.02


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
    window = Window(
        np.zeros((5, 7), np.uint8), x0=12, y0=34, stamp_ns=3_000_000_001, binning=(2, 4)
    )
    whole = stamped(CameraInfo(width=640), 5, 'optical')
    info = of_window(whole, window, 'optical')
    assert (info.width, whole.roi.width, whole.header.stamp.nanosec) == (640, 0, 5)
    roi = info.roi
    assert (roi.x_offset, roi.y_offset, roi.width, roi.height) == (12, 34, 14, 20)
    assert (info.header.stamp.sec, info.header.stamp.nanosec) == (3, 1)


def test_k_of_a_binned_picture_gives_no_camera() -> None:
    """With the sensor's size beside it every bearing would be wrong by the binning."""
    info = from_camera_model(MODEL, 640, 480)
    info.width, info.height = 1280, 960
    with pytest.raises(MessageError, match='is the middle of 640 x 480 px'):
        KnownCamera().model(info)


def test_what_is_unusual_of_a_camera_is_known_with_it() -> None:
    """And goes with the next calibration."""
    camera = KnownCamera()
    odd = dataclasses.replace(MODEL, matrix=MODEL.matrix * np.array([[1.6], [1.0], [1.0]]))
    camera.model(from_camera_model(odd, 640, 480))
    assert any('as high as wide' in each for each in camera.doubts)
    camera.model(from_camera_model(MODEL, 640, 480))
    assert camera.doubts == []

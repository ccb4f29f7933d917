"""A camera that is steered: it turns as commanded, and its truth is where its light is."""

from __future__ import annotations

from blob_tracker.camera import CameraModel
from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
from blob_tracker.simulation.pan_tilt import Joints, PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.platform_motion import MOTIONS, Ride
from blob_tracker.simulation.steered_camera import SteeredCamera
import numpy as np
import pytest

MODEL = CameraModel.from_field_of_view(160, 120, 20.0)
STILL = Ride(1.0, np.zeros((9, 3)), np.zeros((9, 3)))


def steered(ride: Ride) -> SteeredCamera:
    """Return a camera that looks at a light straight ahead of the level frame."""
    camera = PanTiltCamera(
        MODEL, ride, lambda times: np.tile([0.0, 0.0, 1.0], (len(times), 1)), sigma=1.5,
        amplitude=120.0, texture=0.0, region=(160, 120),
    )
    return SteeredCamera(camera, PanTilt(Joints(delay=0.0)))


def test_a_command_moves_the_light_in_the_picture() -> None:
    """By 20 mrad to the right and 10 up: the light goes to the left and down."""
    vehicle = steered(STILL)
    _, truth = vehicle.picture(2, 0.1)
    assert (truth.x, truth.y) == pytest.approx((79.5, 59.5), abs=1e-6)
    assert not vehicle.rate(0.1).any()
    vehicle.pan_tilt.command(0.02, 0.01)
    _, truth = vehicle.picture(4, 1.1)
    focal_length = MODEL.matrix[0, 0]
    assert truth.x - 79.5 == pytest.approx(-0.02 * focal_length, rel=0.01)
    assert truth.y - 59.5 == pytest.approx(0.01 * focal_length, rel=0.01)


def test_the_light_is_found_where_the_truth_says() -> None:
    """On a boat: each lit picture to 6 sigma before an even shore, and no dark one."""
    ride = MOTIONS['sea'].ride(3.0, seed=3)
    vehicle, segmenter = steered(ride), Segmenter()
    found = 0
    for index in range(120):
        frame, truth = vehicle.picture(index, index / 60.0)
        assert truth.lit is (index % 2 == 0)
        window = segmenter.update(frame)
        if window is None:
            continue
        assert truth.lit
        location = locate(window, noise=vehicle.camera.sensor.noise)
        error = np.array([location.x - truth.x, location.y - truth.y])
        assert error @ np.linalg.solve(location.covariance, error) < 36.0
        found += 1
    assert found >= 55
    assert np.abs(vehicle.rate(1.0)).max() > 1e-3

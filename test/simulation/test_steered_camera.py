"""A camera that is steered: it turns as commanded, and its truth is where its light is."""

from __future__ import annotations

from blob_tracker.camera import CameraModel
from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.pan_tilt import Joints, PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.platform_motion import MOTIONS, Ride
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.simulation.steered_camera import SteeredCamera
import numpy as np
import pytest

MODEL = CameraModel.from_field_of_view(160, 120, 20.0)
GYRO = Gyro(noise=0.0, bias=0.0, scale=0.0, turn=0.0)
STILL = Ride(1.0, np.zeros((9, 3)), np.zeros((9, 3)))


def steered(ride: Ride, sensor: Sensor = Sensor()) -> SteeredCamera:
    """Return a camera that looks at a light straight ahead of the level frame."""
    camera = PanTiltCamera(
        MODEL, ride, lambda times: np.tile([0.0, 0.0, 1.0], (len(times), 1)), sigma=1.5,
        amplitude=120.0, texture=0.0, region=(160, 120), sensor=sensor,
    )
    felt = GYRO.samples(ride, 2.0, np.random.default_rng(1))
    return SteeredCamera(camera, PanTilt(Joints(delay=0.0)), GYRO, felt)


def test_a_command_moves_the_light_in_the_picture() -> None:
    """By 20 mrad to the right and 10 up: the light goes to the left and down."""
    vehicle = steered(STILL)
    _, truth = vehicle.picture(2, 0.1)
    assert (truth.x, truth.y) == pytest.approx((79.5, 59.5), abs=1e-6)
    assert {state.rate for state in vehicle.states()} == {(0.0, 0.0, 0.0)}
    vehicle.pan_tilt.command(0.02, 0.01)
    _, truth = vehicle.picture(4, 1.1)
    focal_length = MODEL.matrix[0, 0]
    assert truth.x - 79.5 == pytest.approx(-0.02 * focal_length, rel=0.01)
    assert truth.y - 59.5 == pytest.approx(0.01 * focal_length, rel=0.01)


def test_a_rolling_shutter_sees_the_light_when_its_row_is_exposed() -> None:
    """A steady turn by 0.5 rad/s: at the stamp and the time to the row it is where it is found."""
    rate = 0.5
    yaw = np.array([0.0, 0.0, rate])
    ride = Ride(0.25, np.outer(0.25 * np.arange(9), yaw), np.tile(yaw, (9, 1)))
    vehicle = steered(ride, Sensor(row_time=1e-4))
    focal_length = MODEL.matrix[0, 0]
    for index, end in ((0, 0.05), (2, 0.1)):
        frame, truth = vehicle.picture(index, end)
        assert frame.line_time_ns == pytest.approx(1e5)
        seen = (frame.stamp_ns - 10**9) / 1e9 + 1e-4 * truth.y
        assert seen < end
        assert truth.x - 79.5 == pytest.approx(-focal_length * np.tan(rate * seen), abs=0.01)


def test_the_light_is_found_where_the_truth_says() -> None:
    """On a boat: each lit picture to 6 sigma before an even shore, and no dark one."""
    ride = MOTIONS['sea'].ride(3.0, seed=3)
    vehicle, segmenter = steered(ride), Segmenter()
    found = 0
    for index in range(120):
        frame, truth = vehicle.picture(index, 0.002 + index / 60.0)
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


def test_states_are_of_even_times_and_true() -> None:
    """Driven in fits and starts, with a command and an exposure in between: as in small steps."""
    ride = MOTIONS['rover'].ride(2.0, seed=4)
    uneven, even = steered(ride), steered(ride)
    for time in np.arange(0.0, 1.0, 0.001):
        if time == 0.5:
            for vehicle in (uneven, even):
                vehicle.advance(0.5)
                vehicle.pan_tilt.command(0.1, -0.05)
        even.advance(time)
    for time in (0.013, 0.4, 0.5):
        uneven.advance(time)
    uneven.picture(0, 0.5555)
    uneven.advance(0.999)
    ours, theirs = uneven.states(), even.states()
    times = np.array([each.time for each in ours])
    np.testing.assert_allclose(times, np.arange(1, 1 + len(ours)) / GYRO.rate)
    felt_times = np.array([each.felt_time for each in ours])
    np.testing.assert_allclose(felt_times, times - 0.5 / GYRO.rate)
    # A mean is the rate in its middle but for the bend; half a sample later it is 0.016 rad/s off.
    np.testing.assert_allclose([each.rate for each in ours], ride.rates(felt_times), atol=2e-3)
    assert [each.time for each in ours] == [each.time for each in theirs]
    np.testing.assert_array_equal(
        [each.rate for each in ours], [each.rate for each in theirs]
    )
    # The motors' limits hold on the mean of steps of up to 2 ms, which here are not the same: it
    # is as if a command of 0.1 rad came half a step, 1 ms, earlier or later at 1 rad/s.
    np.testing.assert_allclose(
        [each.angles for each in ours], [each.angles for each in theirs], atol=1e-3
    )
    # It may still swing about where it was sent.
    assert ours[-1].angles == pytest.approx((0.1, -0.05), abs=0.02)
    assert uneven.states() == []


def test_it_begins_again_where_the_pan_tilt_stands() -> None:
    """The ride leaps to its beginning; the camera does not."""
    vehicle = steered(STILL)
    vehicle.pan_tilt.command(0.02, 0.01)
    vehicle.advance(0.9)
    again = vehicle.again()
    assert again.pan_tilt.time == 0.0
    assert again.pan_tilt.angles == vehicle.pan_tilt.angles != (0.0, 0.0)
    again.advance(0.0101)
    assert [state.time for state in again.states()] == pytest.approx([0.005, 0.01])


def test_another_camera_goes_on_with_the_same_pan_tilt() -> None:
    """Its states are those after the time up to which it was driven, each once."""
    vehicle = steered(STILL)
    vehicle.advance(0.0101)
    felt = GYRO.samples(STILL, 1.0, np.random.default_rng(1))
    other = SteeredCamera(vehicle.camera, vehicle.pan_tilt, GYRO, felt)
    other.advance(0.0201)
    assert [state.time for state in other.states()] == pytest.approx([0.015, 0.02])

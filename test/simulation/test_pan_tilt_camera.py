"""The light is where the joints and the vehicle put it, and smeared as they turn."""

from __future__ import annotations

from blob_tracker.camera import CameraModel
from blob_tracker.location import locate
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.platform_motion import Ride
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest

MODEL = CameraModel.from_data_sheet(640, 480, 6.0, 10.0)
QUIET = Sensor(SensorNoise(gain=np.inf, read_noise=0.0), bits=16)
AHEAD = np.array([0.0, 0.0, 1.0])


def camera(angles: tuple[float, float, float], yaw_rate: float = 0.0) -> PanTiltCamera:
    """Return a camera on a vehicle at this attitude, which turns to the right."""
    times = np.array([0.0, 1.0])
    first = np.array([angles, angles])
    first[:, 2] += yaw_rate * (times - 0.5)
    rates = np.tile([0.0, 0.0, yaw_rate], (2, 1))
    return PanTiltCamera(
        MODEL, Ride(1.0, first, rates), lambda t: np.tile(AHEAD, (len(t), 1)), 1.2, 20000.0,
        background=1000.0, texture=0.0, sensor=QUIET, exposure=0.02,
    )


def located(one: PanTiltCamera, joints: tuple[float, float]) -> tuple[float, float, float]:
    """Return azimuth and elevation of the light in the middle of the ride, mrad, and its sigma."""
    frame = one.frame(0, 0.5, lambda times: np.tile(joints, (len(times), 1)), lit=True)
    y, x = np.unravel_index(np.argmax(frame.image), frame.image.shape)
    part = frame.image[y - 8:y + 9, x - 8:x + 9]
    found = locate(
        Window(part, x0=frame.x0 + int(x) - 8, y0=frame.y0 + int(y) - 8, stamp_ns=frame.stamp_ns),
        noise=SensorNoise(gain=1.0, read_noise=1.0),
    )
    bearing = MODEL.bearing(found)
    return bearing.azimuth, bearing.elevation, found.sigma


def test_a_bearing_is_what_is_left_to_turn() -> None:
    """Bow up by 20 mrad and right by 30: the light is lower and to the left, without roll."""
    azimuth, elevation, _ = located(camera((0.0, 0.02, 0.03)), (0.0, 0.0))
    assert azimuth == pytest.approx(-30.0, abs=0.02)
    assert elevation == pytest.approx(-20.0, abs=0.02)
    azimuth, elevation, _ = located(camera((0.0, 0.02, 0.03)), (-0.03, -0.02))
    # 0.6 urad for each mrad of one turn seen from the other: 3e-4 mrad; the fit to 0.001 px.
    assert (azimuth, elevation) == pytest.approx((0.0, 0.0), abs=0.02)


def test_rays_and_pixels_are_the_same() -> None:
    """Rolled, pitched, yawed and turned: the located light is the ray to a thousandth of a px."""
    one = camera((0.2, -0.03, 0.04))
    joints = (-0.02, 0.01)
    ray = one.rays(np.array([0.5]), np.array([joints]))[0]
    azimuth, elevation, _ = located(one, joints)
    assert azimuth == pytest.approx(1e3 * np.arctan2(ray[0], ray[2]), abs=0.01)
    assert elevation == pytest.approx(
        1e3 * np.arctan2(-ray[1], np.hypot(ray[0], ray[2])), abs=0.01)
    off = one.off_axis(np.array([0.5]), np.array([joints]))[0]
    assert off == pytest.approx(np.arccos(ray[2]), rel=1e-6)


def test_a_turn_within_the_exposure_smears_the_light_about_its_middle() -> None:
    """0.2 rad/s over 20 ms are 2.4 px: the variance of x grows by 2.4^2 / 12."""
    azimuth, elevation, sigma = located(camera((0.0, 0.0, 0.0), yaw_rate=0.2), (0.0, 0.0))
    assert (azimuth, elevation) == pytest.approx((0.0, 0.0), abs=0.01)
    still = located(camera((0.0, 0.0, 0.0)), (0.0, 0.0))[2]
    assert sigma > 1.05 * still


def test_the_shore_turns_with_the_light() -> None:
    """A mark right of the light, rolled to the right side down by 90 degrees, is above it."""
    one = PanTiltCamera(
        MODEL, Ride(1.0, np.zeros((2, 3)), np.zeros((2, 3))),
        lambda t: np.tile(AHEAD, (len(t), 1)), 1.2, 0.0, sensor=QUIET,
    )
    rolled = PanTiltCamera(
        MODEL, Ride(1.0, np.tile([np.pi / 2, 0.0, 0.0], (2, 1)), np.zeros((2, 3))),
        lambda t: np.tile(AHEAD, (len(t), 1)), 1.2, 0.0, sensor=QUIET,
    )

    def joints(times):
        return np.zeros((len(times), 2))

    level = one.frame(0, 0.5, joints, lit=False).image[30:91, 50:111].astype(float)
    turned = rolled.frame(0, 0.5, joints, lit=False).image[30:91, 50:111].astype(float)
    # The middle lies between pixels: half a pixel is left for the turn's place.
    alike = [np.corrcoef(np.rot90(level, k)[2:-2, 2:-2].ravel(), turned[2:-2, 2:-2].ravel())[0, 1]
             for k in range(4)]
    assert int(np.argmax(alike)) == 1
    assert alike[1] > 0.8


def test_a_light_that_is_switched_within_the_exposure_is_where_it_was_then() -> None:
    """On in the last quarter of 20 ms at 0.5 rad/s: to the left by 3/8 of its way."""
    one = camera((0.0, 0.0, 0.0), yaw_rate=0.5)
    joints = np.zeros((5, 2))
    whole, part = (
        one.frame(0, 0.5, lambda times: joints, lit=lit).image.astype(float) - 1000.0
        for lit in (True, lambda times: (times > 0.505).astype(float))
    )
    # Parts of an exposure are drawn where their middles are, the one that is partly lit too.
    assert part.sum() == pytest.approx(0.25 * whole.sum(), rel=0.02)
    columns = np.arange(whole.shape[1])
    apart = (part @ columns).sum() / part.sum() - (whole @ columns).sum() / whole.sum()
    assert apart == pytest.approx(-0.375 * 0.02 * 0.5 * MODEL.matrix[0, 0], abs=0.15)

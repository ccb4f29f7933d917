"""What a camera that moves sees between two rays: the light's motion alone is a straight line."""

from __future__ import annotations

from math import atan2, hypot, pi

from blob_tracker.tracking import CameraPose, Sight
from blob_tracker.tracking.interpolation import interpolated
from blob_tracker.tracking.rays import directions
from blob_tracker.tracking.sight import between
from blob_tracker.types import Bearing
import numpy as np
from scipy.spatial.transform import Rotation

MS = 1_000_000
LIGHT = np.array([20.0, 3.0, 1.0])
COVARIANCE = np.array([[0.01, 0.004], [0.004, 0.02]])


def pose(ms: float) -> CameraPose:
    """Return that of a camera that pans by 1 rad/s, ever faster, and drives at 1 m/s."""
    pan = -pi / 2 - 1e-3 * ms - 2.5 * (1e-3 * ms) ** 2
    return CameraPose(
        np.array([0.0, 1e-3 * ms, 0.0]), Rotation.from_euler('xyz', [-1.7, 0.1, pan]).as_matrix()
    )


def sight(ms: float) -> Sight:
    """Return what it sees of a light at rest."""
    x, y, z = pose(ms).rotation.T @ (LIGHT - pose(ms).position)
    return Sight(
        Bearing(1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)), COVARIANCE, round(ms * MS)),
        pose(ms),
    )


def test_a_light_at_rest_stays_where_it_is() -> None:
    """However the camera pans; a line in its own axes would be off by 0.25 mrad."""
    before, after = sight(0.0), sight(20.0)
    found = between(before, after, 10 * MS)
    ray = found.pose.rotation @ directions(
        1e-3 * np.array([found.bearing.azimuth, found.bearing.elevation])
    )
    right = LIGHT - found.pose.position
    off = np.cross(ray, right / np.linalg.norm(right))
    # The drive of 20 mm by a light at 20 m: 1 mrad, whose bend is a part in a thousand of it.
    assert np.linalg.norm(off) < 1e-6
    np.testing.assert_allclose(found.pose.position, [0.0, 0.01, 0.0])
    simple = interpolated(before.bearing, after.bearing, 10 * MS)
    there = sight(10.0).bearing
    assert hypot(simple.azimuth - there.azimuth, simple.elevation - there.elevation) > 0.2


def test_the_covariance_turns_with_the_ray() -> None:
    """As that of bearings that scatter with it: the camera has rolled by a radian."""
    before, stamp_ns = sight(0.0), 300 * MS
    rolled = CameraPose(np.zeros(3), pose(0.0).rotation @ Rotation.from_rotvec(
        [0.0, 0.2, 1.0]
    ).as_matrix())
    random = np.random.default_rng(3)
    noise = random.multivariate_normal([0.0, 0.0], COVARIANCE, 4000)
    seen = []
    for azimuth, elevation in noise:
        after = Sight(
            Bearing(120.0 + azimuth, -200.0 + elevation, COVARIANCE, stamp_ns), rolled
        )
        found = between(before, after, stamp_ns).bearing
        seen.append([found.azimuth, found.elevation])
    stated = found.covariance
    # 4000 draws know a variance to 2.2 %, at four of its standard errors.
    np.testing.assert_allclose(np.cov(np.transpose(seen)), stated, atol=0.09 * COVARIANCE[1, 1])
    assert not np.allclose(stated, COVARIANCE, atol=2e-3)


def test_a_camera_at_rest_is_interpolated_as_ever() -> None:
    """To the bit, where both have the one pose."""
    before = sight(0.0)
    after = Sight(sight(20.0).bearing, before.pose)
    found = between(before, after, 7 * MS)
    plain = interpolated(before.bearing, after.bearing, 7 * MS)
    assert found.pose is before.pose
    assert (found.bearing.azimuth, found.bearing.elevation) == (plain.azimuth, plain.elevation)
    assert (found.bearing.covariance == plain.covariance).all()

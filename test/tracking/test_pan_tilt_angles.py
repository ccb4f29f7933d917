"""The pan/tilt's place from its joint angles."""

from __future__ import annotations

from blob_tracker.tracking import PanTiltAngles, PlatformGap, StampJump, TrackingError
from consistency import of_rays
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

MS = 1_000_000  # ns


def test_boresight_has_pan_and_tilt_as_its_angles() -> None:
    """Azimuth and elevation in the base, between two samples too."""
    angles = PanTiltAngles()
    angles.push(0, 0.1, -0.2)
    angles.push(10 * MS, 0.3, 0.2)
    for stamp, expected in ((0, (100.0, -200.0)), (5 * MS, (200.0, 0.0)), (10 * MS, (300, 200))):
        turn = angles.at(stamp)
        assert of_rays(turn[None, :, 2])[0] == pytest.approx(expected)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)


def test_rate_is_the_derivative() -> None:
    """In the base's axes, past the newest sample too."""
    angles = PanTiltAngles()
    angles.push(0, 0.1, -0.2)
    angles.push(100 * MS, 0.4, 0.1)
    for stamp in (50 * MS, 180 * MS):
        before, after = (Rotation.from_matrix(angles.at(stamp + d)) for d in (-MS, MS))
        moved = (after * before.inv()).as_rotvec() / 0.002
        np.testing.assert_allclose(angles.rate_at(stamp), moved, atol=1e-5)


def test_a_turn_is_taken_the_short_way() -> None:
    """Of a joint that is read modulo a turn."""
    angles = PanTiltAngles()
    angles.push(0, np.pi - 0.01, 0.0)
    angles.push(10 * MS, -np.pi + 0.03, 0.0)
    assert angles.rate_at(5 * MS) == pytest.approx([0.0, 4.0, 0.0])
    assert abs(of_rays(angles.at(5 * MS)[None, :, 2])[0, 0]) == pytest.approx(1e3 * np.pi - 10.0)


def test_order_and_gaps() -> None:
    """A late sample is put in its place, an instant that is not covered is told."""
    angles = PanTiltAngles(hold=0.1, memory=1.0)
    with pytest.raises(PlatformGap, match='no joint angles have come'):
        angles.at(0)
    angles.push(100 * MS, 0.2, 0.0)
    angles.push(0, 0.0, 0.0)
    angles.push(50 * MS, 0.05, 0.0)
    assert of_rays(angles.at(75 * MS)[None, :, 2])[0, 0] == pytest.approx(125.0)
    with pytest.raises(TrackingError, match='with the stamp'):
        angles.push(50 * MS, 0.0, 0.0)
    with pytest.raises(PlatformGap, match='not kept'):
        angles.at(-MS)
    with pytest.raises(PlatformGap, match='0.101 s old'):
        angles.at(201 * MS)
    angles.push(5000 * MS, 0.0, 0.0)
    with pytest.raises(StampJump, match='4.900 s before'):
        angles.push(100 * MS, 0.0, 0.0)
    angles.reset()
    angles.push(100 * MS, 0.3, 0.0)
    assert of_rays(angles.at(150 * MS)[None, :, 2])[0, 0] == pytest.approx(300.0)
    angles.push(400 * MS, 0.0, 0.0)
    with pytest.raises(PlatformGap, match='apart'):
        angles.at(300 * MS)
    # What moved in so long a time tells no rate.
    np.testing.assert_array_equal(angles.rate_at(450 * MS), np.zeros(3))


def test_impossible_angles_and_parameters_are_refused() -> None:
    """Each by its name."""
    for pan, tilt in ((np.nan, 0.0), (0.0, np.inf)):
        with pytest.raises(TrackingError, match='pan and tilt'):
            PanTiltAngles().push(0, pan, tilt)
    with pytest.raises(TrackingError, match='hold'):
        PanTiltAngles(hold=-1.0)
    with pytest.raises(TrackingError, match='memory'):
        PanTiltAngles(memory=0.0)

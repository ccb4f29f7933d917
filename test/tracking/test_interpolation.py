"""Between two bearings: on the line, with the noise of both and what the motion strays."""

from blob_tracker.tracking.interpolation import interpolated
from blob_tracker.types import Bearing
import numpy as np
import pytest

STEP_NS = 40_000_000
ONE = Bearing(10.0, -4.0, np.diag([0.01, 0.04]), 1_000_000_000)
OTHER = Bearing(14.0, 0.0, np.diag([0.03, 0.04]), 1_000_000_000 + STEP_NS)


def test_the_ends_are_what_was_measured() -> None:
    """To the covariance."""
    for each in (ONE, OTHER):
        found = interpolated(ONE, OTHER, each.stamp_ns, 1e3)
        assert (found.azimuth, found.elevation) == (each.azimuth, each.elevation)
        assert found.stamp_ns == each.stamp_ns
        np.testing.assert_allclose(found.covariance, each.covariance)


def test_a_quarter_of_the_way() -> None:
    """Place and noise, of a light that moves evenly."""
    found = interpolated(ONE, OTHER, 1_000_000_000 + STEP_NS // 4, 0.0)
    assert (found.azimuth, found.elevation) == pytest.approx((11.0, -3.0))
    np.testing.assert_allclose(
        found.covariance, (9.0 * ONE.covariance + OTHER.covariance) / 16.0
    )


def test_the_shorter_way_round() -> None:
    """From 1 mrad before the back of the camera to 1 mrad beyond it."""
    back = 1e3 * np.pi
    one, other = (
        Bearing(angle, 0.0, np.eye(2), at) for angle, at in ((back - 1, 0), (1 - back, 4))
    )
    assert interpolated(one, other, 1, 0.0).azimuth == pytest.approx(back - 0.5)
    assert interpolated(one, other, 3, 0.0).azimuth == pytest.approx(0.5 - back)


def test_a_motion_strays_from_the_line_as_told() -> None:
    """White angular acceleration, integrated in 100 steps: variance within 10 % of it."""
    random = np.random.default_rng(6)
    steps, runs, acceleration, h = 100, 4000, 200.0, 1e-9 * STEP_NS
    dt = h / steps
    rates = np.cumsum(random.normal(0.0, acceleration * np.sqrt(dt), (runs, steps)), axis=1)
    places = np.concatenate([np.zeros((runs, 1)), np.cumsum(rates * dt, axis=1)], axis=1)
    for part in (0.25, 0.5, 0.8):
        strayed = places[:, round(part * steps)] - part * places[:, -1]
        one, other = (Bearing(0.0, 0.0, np.zeros((2, 2)), at) for at in (0, STEP_NS))
        told = interpolated(one, other, round(part * STEP_NS), acceleration).covariance
        # 4000 runs know a variance to 2.2 %, 100 steps to as much.
        assert np.mean(strayed**2) == pytest.approx(told[0, 0], rel=0.1)


@pytest.mark.parametrize('stamp_ns', [999_999_999, 1_040_000_001])
def test_an_instant_outside_is_refused(stamp_ns: int) -> None:
    """That would be a prediction."""
    with pytest.raises(ValueError, match='does not lie between'):
        interpolated(ONE, OTHER, stamp_ns, 0.0)

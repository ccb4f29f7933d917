"""Between two bearings: on the line, with the noise of both and what the motion strays."""

from blob_tracker.tracking.interpolation import interpolated, strays
from blob_tracker.types import Bearing
import numpy as np
import pytest

STEP_NS = 40_000_000
ONE = Bearing(10.0, -4.0, np.diag([0.01, 0.04]), 1_000_000_000)
OTHER = Bearing(14.0, 0.0, np.diag([0.03, 0.04]), 1_000_000_000 + STEP_NS)


def test_the_ends_are_what_was_measured() -> None:
    """To the covariance."""
    for each in (ONE, OTHER):
        found = interpolated(ONE, OTHER, each.stamp_ns)
        assert (found.azimuth, found.elevation) == (each.azimuth, each.elevation)
        assert found.stamp_ns == each.stamp_ns
        np.testing.assert_allclose(found.covariance, each.covariance)


def test_a_quarter_of_the_way() -> None:
    """Place and noise, of a light that moves evenly."""
    found = interpolated(ONE, OTHER, 1_000_000_000 + STEP_NS // 4)
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
    assert interpolated(one, other, 1).azimuth == pytest.approx(back - 0.5)
    assert interpolated(one, other, 3).azimuth == pytest.approx(0.5 - back)


def test_a_motion_strays_from_lines_as_told() -> None:
    """White acceleration, integrated in 160 steps: from three lines, within 10 % of it."""
    random = np.random.default_rng(6)
    steps, runs, h = 160, 4000, 0.04
    dt = h / steps
    rates = np.cumsum(random.normal(0.0, np.sqrt(dt), (runs, steps)), axis=1)
    places = np.concatenate([np.zeros((runs, 1)), np.cumsum(rates * dt, axis=1)], axis=1)
    at, ends = 80, np.array([[0, 160], [60, 130], [20, 84], [80, 80]])
    parts = (at - ends[:3, 0]) / (ends[:3, 1] - ends[:3, 0])
    line = (1.0 - parts) * places[:, ends[:3, 0]] + parts * places[:, ends[:3, 1]]
    strayed = places[:, [at]] - line
    told = strays(dt * (at - ends[:, 0]), dt * (ends[:, 1] - at))
    # 4000 runs know a variance to 2.2 %, the steps to as much.
    np.testing.assert_allclose(strayed.T @ strayed / runs, told[:3, :3], rtol=0.1)
    assert not told[3].any()  # measured at that instant
    assert told[0, 0] == pytest.approx(h**3 / 48.0)


@pytest.mark.parametrize('stamp_ns', [999_999_999, 1_040_000_001])
def test_an_instant_outside_is_refused(stamp_ns: int) -> None:
    """That would be a prediction."""
    with pytest.raises(ValueError, match='does not lie between'):
        interpolated(ONE, OTHER, stamp_ns)

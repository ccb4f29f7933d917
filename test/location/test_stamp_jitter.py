"""Stamps that jitter are told from frames that come unevenly, by the motion of the light."""

from __future__ import annotations

from blob_tracker.location.stamp_jitter import StampJitter
from blob_tracker.types import Location
import numpy as np
import pytest

INTERVAL, SIGMA = 1 / 30, 0.02  # s from flash to flash, px
SETTLED = 40


def played(
    speed: float, jitter: float, *, stamped: bool, count: int = 400, gap: bool = False
) -> tuple[float, list[str], float]:
    """Return the NEES after the first flashes, what was said, and the last sigma of the stamps."""
    random = np.random.default_rng(3)
    check, squares, said = StampJitter(), [], []
    for index in range(count):
        if gap and index % 5 > 2:
            continue
        early = float(random.uniform(-jitter, jitter))
        stamp, time = index * INTERVAL + early, index * INTERVAL + (0.0 if stamped else early)
        noise = SIGMA * random.standard_normal(2)

        def place(at: float) -> np.ndarray:
            angle = speed * at / 200.0
            return 200.0 * np.array([np.cos(angle), np.sin(angle)])

        x, y = place(time) + noise
        location = Location(
            x, y, SIGMA**2 * np.eye(2), 100.0, 10.0, 1.5, 50.0, 1.0, 0, round(1e9 * stamp)
        )
        found = check.doubted(location)
        if index > SETTLED:
            error = np.array([x, y]) - place(stamp)
            squares.append(error @ np.linalg.solve(found.covariance, error))
            said.append(found.warning)
    return float(np.mean(squares)), said, check.sigma


@pytest.mark.parametrize('gap', [False, True])
@pytest.mark.parametrize('jitter', [1e-3, 3e-3, 5e-3])
def test_stamps_that_jitter_are_in_the_covariance(jitter: float, gap: bool) -> None:
    """NEES 2 to five standard errors and the turn of the way; of even frames, and with gaps."""
    nees, said, sigma = played(120.0, jitter, stamped=True, gap=gap)
    assert 1.5 < nees < 3.0
    assert sigma == pytest.approx(jitter / np.sqrt(3.0), rel=0.3)
    assert sum('the stamps jitter by' in each for each in said) > 0.95 * len(said)


@pytest.mark.parametrize('jitter', [1e-3, 5e-3])
def test_frames_that_come_unevenly_are_believed(jitter: float) -> None:
    """Their places are those at their stamps: nothing is added, nothing said."""
    nees, said, sigma = played(120.0, jitter, stamped=False)
    assert 1.5 < nees < 2.5 and sigma == 0.0 and not any(said)


@pytest.mark.parametrize('speed, jitter', [(0.0, 5e-3), (120.0, 0.0)])
def test_a_light_at_rest_and_true_stamps_lose_nothing(speed: float, jitter: float) -> None:
    """Nothing is said, and the covariance is that of noise."""
    nees, said, _ = played(speed, jitter, stamped=True)
    assert 1.5 < nees < 2.5 and not any(said)

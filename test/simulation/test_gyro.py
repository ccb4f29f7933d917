"""A gyro says what the vehicle does, and is off as it is said to be."""

from __future__ import annotations

from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.platform_motion import MOTIONS
import numpy as np
import pytest

PERFECT = Gyro(noise=0.0, bias=0.0, scale=0.0, turn=0.0)


def test_the_sum_of_its_samples_is_the_turn() -> None:
    """Step by step, over 5 s of sea: the coning that is left out is 1e-5 rad."""
    ride = MOTIONS['sea'].ride(6.0, 1)
    middles, rates = PERFECT.samples(ride, 5.0, np.random.default_rng(1))
    assert middles[[0, -1]] == pytest.approx([0.0025, 4.9975])
    turned = ride.rotations(np.zeros(1))[0]
    for x, y, z in rates / PERFECT.rate:
        angle = np.sqrt(x * x + y * y + z * z)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        # Rodrigues
        turned = turned @ (
            np.eye(3) + np.sin(angle) / angle * cross
            + (1.0 - np.cos(angle)) / angle**2 * cross @ cross
        )
    assert turned == pytest.approx(ride.rotations(np.array([5.0]))[0], abs=2e-5)


def test_errors_are_as_large_as_said() -> None:
    """Noise of 2000 samples to 3 %, three deviations; the bias through its mean."""
    ride = MOTIONS['sea'].scaled(0.0).ride(12.0, 1)
    gyro = Gyro(noise=1e-4, bias=3e-3)
    _, rates = gyro.samples(ride, 10.0, np.random.default_rng(2))
    assert rates.std(axis=0) == pytest.approx(1e-3, rel=0.05)
    assert np.abs(rates.mean(axis=0)) == pytest.approx(3e-3, abs=1e-4)
    assert gyro.variance == pytest.approx(1e-6)


@pytest.mark.parametrize('wrong', [{'rate': 0.0}, {'noise': -1.0}, {'noise': np.nan}])
def test_what_cannot_be_is_refused(wrong: dict[str, float]) -> None:
    """By name."""
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Gyro(**wrong)

"""What is wrong with a gyro, by the picture: each fault by its name, none where there is none."""

from __future__ import annotations

from math import pi

from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking.gyro_fit import Fit, fit_gyro, moves_of
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation

DURATION = 10.0  # s
BEARING = 2e-5  # rad, of each angle
LIGHT = np.array([0.05, -0.03, 1.0]) / np.linalg.norm([0.05, -0.03, 1.0])
NOTHING = np.eye(3)
OFF = Rotation.from_euler('xyz', [20.0, 0.0, 20.0], degrees=True)


def compared(
    motion: str, seed: int, wrong: NDArray[np.float64] = NOTHING, late: float = 0.0,
    size: float = 1.0,
) -> Fit:
    """Compare a ride with what a gyro makes of it, its rates changed and its stamps late."""
    random = np.random.default_rng(seed)
    ride = MOTIONS[motion].scaled(size).ride(DURATION + 1.0, seed)
    times, rates = Gyro().samples(ride, DURATION, random)
    seen = np.arange(0.05, DURATION - 0.05, 1.0 / 30.0)
    directions = np.einsum('nij,i->nj', ride.rotations(seen), LIGHT)
    directions += BEARING * random.standard_normal(directions.shape)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return fit_gyro(moves_of(seen, directions, 0.08, 0.5), times + late, rates @ wrong.T)


@pytest.mark.parametrize('motion', list(MOTIONS))
@pytest.mark.parametrize('wrong, words', [
    (180.0 / pi * NOTHING, 'its rates are in degrees/s'),
    (-NOTHING, 'its rates have the wrong sign'),
    (NOTHING[[1, 0, 2]], 'x is y, y is x, z is z'),
    (NOTHING[[2, 0, 1]] * [[1.0], [-1.0], [-1.0]], "its axes are others: of the camera's"),
    (OFF.as_matrix(), 'its axes are off by'),
])
def test_a_fault_is_named(motion: str, wrong: NDArray[np.float64], words: str) -> None:
    """And the turn that it tells takes the rates back; 2 degrees are in the gyro's own errors."""
    told, fault = compared(motion, 1, wrong)
    assert told
    assert fault is not None
    assert fault.words.startswith(words) or words in fault.words
    assert fault.turn is not None
    back = fault.scale * fault.turn @ wrong
    assert np.linalg.norm(back[:2] - NOTHING[:2], axis=1).max() < 0.06


@pytest.mark.parametrize('motion', list(MOTIONS))
@pytest.mark.parametrize('late', [-0.12, 0.05])
def test_an_offset_of_the_stamps_is_measured(motion: str, late: float) -> None:
    """To 3 ms."""
    told, fault = compared(motion, 2, late=late)
    assert told
    assert fault is not None
    assert fault.offset == pytest.approx(late, abs=3e-3)
    assert fault.words == f'its stamps are {1e3 * abs(fault.offset):.0f} ms ' + (
        'late' if late > 0.0 else 'early'
    )


@pytest.mark.parametrize('motion', list(MOTIONS))
def test_a_right_one_has_no_fault(motion: str) -> None:
    """In no ride, with its bias, its scale and its mounting."""
    fits = [compared(motion, seed) for seed in range(10)]
    assert all(told for told, _ in fits)
    assert all(fault is None for _, fault in fits)


def test_without_turning_nothing_is_told() -> None:
    """Whatever the axes; and nothing of too short a time."""
    for wrong in (NOTHING, -NOTHING):
        assert compared('sea', 3, wrong, size=0.01) == Fit(False, None)
    few = moves_of(np.arange(0.0, 1.0, 0.1), np.tile(LIGHT, (10, 1)), 0.08, 0.5)
    assert fit_gyro(few, np.arange(0.0, 1.0, 0.01), np.zeros((100, 3))) == Fit(False, None)


def test_the_gyro_of_another_platform() -> None:
    """It turns otherwise: nothing makes it fit, and it is worse than none."""
    random = np.random.default_rng(5)
    ride, other = (MOTIONS['rover'].ride(DURATION + 1.0, seed) for seed in (5, 6))
    times, rates = Gyro().samples(other, DURATION, random)
    seen = np.arange(0.05, DURATION - 0.05, 1.0 / 30.0)
    directions = np.einsum('nij,i->nj', ride.rotations(seen), LIGHT)
    moves = moves_of(seen, directions, 0.08, 0.5)
    told, fault = fit_gyro(moves, times, 3.0 * rates)
    assert told
    assert fault is not None
    assert fault.turn is None

"""What the watch keeps, and that its word stays until there is another."""

from __future__ import annotations

from blob_tracker.simulation.platform_motion import MOTIONS
from blob_tracker.tracking import GyroWatch
from blob_tracker.types import Bearing
import numpy as np
from support.consistency import of_rays

S = 1_000_000_000  # ns


def play(watch: GyroWatch, begin: float, end: float, sign: float) -> None:
    """Have samples and bearings of a ride come, with wild ones and late ones among them."""
    ride = MOTIONS['rover'].ride(31.0, 1)
    for time in np.arange(begin, end, 0.01):
        at = np.array([time])
        watch.push(round(S * time), sign * ride.rates(at)[0])
        watch.push(round(S * (time - 0.05)), [9.0, 9.0, 9.0])  # late
    for index, time in enumerate(np.arange(begin, end, 0.04)):
        azimuth, elevation = of_rays(ride.rotations(np.array([time]))[:, 2])[0].tolist()
        azimuth += 2000.0 * (index == 40)
        watch.saw('', Bearing(azimuth, elevation, 1e-4 * np.eye(2), round(S * time)), None)


def test_its_word_stays_until_there_is_another() -> None:
    """Wrong, then nothing that tells, then right."""
    watch = GyroWatch()
    assert not watch.judge().told
    play(watch, 0.0, 8.0, -1.0)
    assert watch.judge().told
    assert watch.fault is not None
    assert watch.fault.words == 'its rates have the wrong sign'
    watch.reset()
    assert not watch.judge().told
    assert watch.fault is not None
    play(watch, 10.0, 19.0, 1.0)
    assert watch.judge().told
    assert watch.fault is None


def test_a_bearing_that_cannot_be_is_left_out() -> None:
    """Whoever tracks it says so."""
    watch = GyroWatch()
    watch.saw('', Bearing(np.nan, 0.0, np.eye(2), 1), None)
    assert not watch.judge().told

"""What turns the pan/tilt: from bearings, joints and the gyro to angles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from blob_tracker.studies.beyond.servo_scenario import Array, Scenario
from blob_tracker.tracking import PanTiltAngles, PlatformRates, Tracker, TrackingError
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np


class Law(Protocol):
    """What turns the pan/tilt: each answer is the pan and tilt to command, rad, or None."""

    def joints(self, stamp_ns: int, pan: float, tilt: float) -> None:
        """Take a joint state."""

    def gyro(self, stamp_ns: int, rate: Array, variance: float) -> None:
        """Take a sample of the boat's gyro, rad/s."""

    def bearing(self, bearing: Bearing) -> tuple[float, float] | None:
        """Take a bearing."""

    def tick(self, now_ns: int) -> tuple[float, float] | None:
        """Answer at a tick of the commands."""


class Proportional:
    """The example's servo client: a part of each bearing is turned (examples/servo_client.py)."""

    GAIN, DEAD_BAND, SPEED, LOST_AFTER = 0.14, 0.2, 1.0, 0.2

    def __init__(self, start: tuple[float, float]) -> None:
        self._angle = np.array(start)
        self._stamp_ns: int | None = None

    def joints(self, stamp_ns: int, pan: float, tilt: float) -> None:
        """Know nothing of them."""

    def gyro(self, stamp_ns: int, rate: Array, variance: float) -> None:
        """Know nothing of it."""

    def bearing(self, bearing: Bearing) -> tuple[float, float] | None:
        """Turn by a part of it."""
        error = np.array([bearing.azimuth, bearing.elevation])
        before, self._stamp_ns = self._stamp_ns, bearing.stamp_ns
        if before is None or bearing.stamp_ns - before > 1e9 * self.LOST_AFTER:
            return None
        most = self.SPEED * 1e-9 * (bearing.stamp_ns - before)
        step = np.where(np.abs(error) > self.DEAD_BAND, MRAD * self.GAIN * error, 0.0)
        self._angle = self._angle + np.clip(step, -most, most)
        return float(self._angle[0]), float(self._angle[1])

    def tick(self, now_ns: int) -> None:
        """Wait for a bearing."""


class Held:
    """The joints' angles at the bearing's stamp and the bearing: the last direction, held."""

    def __init__(self) -> None:
        self._angles = PanTiltAngles()

    def joints(self, stamp_ns: int, pan: float, tilt: float) -> None:
        """Keep them."""
        self._angles.push(stamp_ns, pan, tilt)

    def gyro(self, stamp_ns: int, rate: Array, variance: float) -> None:
        """Know nothing of it."""

    def bearing(self, bearing: Bearing) -> tuple[float, float] | None:
        """Turn to where it was."""
        azimuth, elevation = MRAD * bearing.azimuth, MRAD * bearing.elevation
        x, y, z = self._angles.at(bearing.stamp_ns) @ (
            np.sin(azimuth) * np.cos(elevation), -np.sin(elevation),
            np.cos(azimuth) * np.cos(elevation),
        )
        return float(np.arctan2(x, z)), float(np.arctan2(-y, np.hypot(x, z)))

    def tick(self, now_ns: int) -> None:
        """Wait for a bearing."""


class Predicted:
    """
    The target where it will be when the pan/tilt moves: the tracker's prediction.

    Parameters
    ----------
    scenario : Scenario
        Of which the servo's delay and the error of the joints' angles are known.
    imu : bool
        Whether the boat's gyro is used.

    """

    def __init__(self, scenario: Scenario, *, imu: bool) -> None:
        self._delay_ns = round(1e9 * scenario.servo_delay)
        self._angles = PanTiltAngles(sigma=scenario.joint_error)
        self._rates = PlatformRates() if imu else None
        # The better model in either case, here: what a gyro leaves has no acceleration to follow.
        self.tracker = Tracker(
            'constant_velocity' if imu else 'constant_acceleration',
            jerk=scenario.vehicle_jerk,
            acceleration=scenario.vehicle_acceleration,
            stabilised_acceleration=scenario.light_acceleration,
            gate_sigma=scenario.gate_sigma,
            # A prediction is better than none: the pan/tilt's own limits bound what it does.
            max_sigma=50.0,
            pan_tilt=self._angles,
            platform=self._rates,
        )

    def joints(self, stamp_ns: int, pan: float, tilt: float) -> None:
        """Keep them."""
        self._angles.push(stamp_ns, pan, tilt)

    def gyro(self, stamp_ns: int, rate: Array, variance: float) -> None:
        """Keep it."""
        if self._rates is not None:
            self._rates.push(stamp_ns, rate, variance)

    def bearing(self, bearing: Bearing) -> None:
        """Take it into the track."""
        try:
            self.tracker.update(bearing)
        except TrackingError:
            pass  # the track goes on without it

    def tick(self, now_ns: int) -> tuple[float, float] | None:
        """Turn to where the target will be."""
        track = self.tracker.at(now_ns + self._delay_ns)
        return None if track is None else (MRAD * track.azimuth, MRAD * track.elevation)


# By what they use: from the scenario and the angles at the beginning, rad.
LAWS: dict[str, Callable[[Scenario, tuple[float, float]], Law]] = {
    'proportional': lambda scenario, start: Proportional(start),
    'last direction held': lambda scenario, start: Held(),
    'predicted': lambda scenario, start: Predicted(scenario, imu=False),
    'predicted, with the gyro': lambda scenario, start: Predicted(scenario, imu=True),
}

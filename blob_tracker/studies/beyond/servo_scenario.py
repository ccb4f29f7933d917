"""What a servo on a boat has to do, and what it does it with."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, sqrt, tau
from typing import NamedTuple

from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.pan_tilt import Joints
from blob_tracker.simulation.platform_motion import MOTIONS, PlatformMotion, Ride, Shock
from blob_tracker.studies.chapter_5.displacements import LABORATORY
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scenario:
    """
    A laser range finder on a work boat that has to point at a light on the shore.

    From the thesis come the range, the lens and the size of the picture, the rocks, and the demand
    (pages 1, 11 and 13). All else is chosen here; docs/servo.md says why.

    Parameters
    ----------
    distance : float
        m.
    speed : float
        Of the boat across the line of sight, m/s.
    sway : float
        Amplitude of its way up and down and to the sides, m, at `sway_frequency`, Hz.
    motion : PlatformMotion
        How it turns.
    rock : (float, float, float)
        Greatest angular acceleration about roll, pitch and yaw as its tool strikes a rock,
        rad/s^2.
    rock_every, rock_first, rock_duration : float
        Time between two strikes, until the first, and of one, s.
    focal_length, pixel : float
        mm and um.
    rate, exposure : float
        Frames a second, and s.
    readout : float
        From the exposure of the first line to that of the last, s; 0 of a global shutter.
    readout_known : bool
        Whether the tracker is told of it.
    interlaced : bool
        Whether the camera gives fields at `rate`, the light in step with pictures of two.
    frequency, clock_error : float
        Of a light that runs free and is on for half of the time, Hz, as the tracker knows it, and
        what its clock is off by, as a part; a frequency of 0: in step with the frames, by wire.
    latency : float
        From the middle of the exposure, of its first line, until the bearing is there: half the
        exposure, read-out (one frame), transfer and computing, s.
    sigma, amplitude, background, texture : float
        Image of the light and of the shore, px and DN.
    joints : Joints
        Of the pan/tilt.
    joint_rate, joint_latency : float
        Of the joint states, Hz and s.
    gyro : Gyro
        Of the boat.
    gyro_latency : float
        From the end of a sample until it is there, s.
    command_rate : float
        Of the predictions that are sent, Hz.
    vehicle_acceleration, vehicle_jerk, light_acceleration : float
        Process noise of the tracker, mrad/s^2 and mrad/s^3: what the boat does, and what is left
        of it, and of the light's own way, where the gyro is used.
    gate_sigma : float
        Of the tracker, standard deviations: wide, as only the light flashes in step, and the boat
        does not move by the tracker's model.

    """

    distance: float = 1000.0
    speed: float = 1.0
    sway: float = 0.15
    sway_frequency: float = 0.45
    motion: PlatformMotion = MOTIONS['sea']
    rock: tuple[float, float, float] = (0.25, 0.4, 0.1)
    rock_every: float = 5.0
    rock_first: float = 2.5
    rock_duration: float = 0.25
    focal_length: float = 6.0
    pixel: float = 10.0
    rate: float = 60.0
    exposure: float = 0.002
    readout: float = 0.0
    readout_known: bool = True
    interlaced: bool = False
    frequency: float = 0.0
    clock_error: float = 0.0
    latency: float = 0.025
    sigma: float = 1.0
    amplitude: float = 150.0
    background: float = 40.0
    texture: float = 8.0
    joints: Joints = Joints(resolution=tau / 2**16)
    joint_rate: float = 200.0
    joint_latency: float = 0.003
    gyro: Gyro = Gyro()
    gyro_latency: float = 0.002
    command_rate: float = 200.0
    vehicle_acceleration: float = 36.0
    vehicle_jerk: float = 410.0
    light_acceleration: float = 3.0
    gate_sigma: float = 8.0

    def disturbed(self, factor: float) -> Scenario:
        """Return the scenario with a boat that turns, and is struck, so many times as much."""
        roll, pitch, yaw = self.rock
        return replace(
            self, motion=self.motion.scaled(factor), sway=factor * self.sway,
            rock=(factor * roll, factor * pitch, factor * yaw),
        )

    def ride(self, duration: float, seed: int) -> Ride:
        """Draw how the boat turns, the rocks included."""
        strikes = np.arange(self.rock_first, duration, self.rock_every)
        shocks = tuple(Shock(float(time), self.rock, self.rock_duration) for time in strikes)
        return replace(self.motion, shocks=shocks).ride(duration + 1.0, seed)

    def light(self, times: Array) -> Array:
        """Return the (n, 3) unit vectors onto the light in the level frame, at (n,) times in s."""
        swing = self.sway / self.distance * np.sin(tau * self.sway_frequency * times)
        azimuth = -self.speed / self.distance * times + swing
        elevation = -0.7 * swing
        return np.stack([
            np.sin(azimuth) * np.cos(elevation), -np.sin(elevation),
            np.cos(azimuth) * np.cos(elevation),
        ], axis=1)

    @property
    def joint_error(self) -> float:
        """
        Return the standard deviation of a joint's angle between two joint states, rad.

        The encoder's step, even over its width, and the bend of the way between two states, which
        at the greatest acceleration a is a t (T - t) / 2: a T^2 / sqrt(120) rms.
        """
        bend = self.joints.acceleration / self.joint_rate**2 / sqrt(120.0)
        return sqrt(self.joints.resolution**2 / 12.0 + bend**2)

    @property
    def servo_delay(self) -> float:
        """Time from sending a prediction to the middle of its being obeyed, s."""
        return self.joints.delay + self.joints.lag + 0.5 / self.command_rate


class Finder(NamedTuple):
    """How the light is found: method, threshold and noise, and what the pictures suffer from."""

    method: str
    threshold: str
    noise: SensorNoise
    chain: AnalogueChain


FINDERS = {
    "the thesis' centroid": Finder(
        'centroid', 'histogram', SensorNoise(gain=inf, read_noise=1.0), LABORATORY.chain,
    ),
    'default': Finder(
        'maximum_likelihood', 'sigma_window', SensorNoise(gain=40.0, read_noise=0.7),
        AnalogueChain(),
    ),
}


class Boresight(NamedTuple):
    """
    What is found of the bearings when the laser is lined up with a light at rest.

    Parameters
    ----------
    azimuth, elevation : float
        Their mean error, which is taken off all bearings, mrad.
    scatter : float
        Variance of their errors beyond the one that they state, which is added to it, mrad^2.

    """

    azimuth: float = 0.0
    elevation: float = 0.0
    scatter: float = 0.0

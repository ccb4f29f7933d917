"""The thesis' application as a loop in simulated time: nothing is used before it has arrived."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from heapq import heappop, heappush
from itertools import count
from math import inf, sqrt, tau
from typing import NamedTuple, Protocol

from blob_tracker.camera import CameraModel, LensError
from blob_tracker.location import locate
from blob_tracker.segmentation import FrameError, Segmenter, threshold_by_name
from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.pan_tilt import Joints, PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera, PARTS
from blob_tracker.simulation.platform_motion import MOTIONS, PlatformMotion, Ride, Shock
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.studies.chapter_5.displacements import LABORATORY
from blob_tracker.tracking import PanTiltAngles, PlatformRates, Tracker, TrackingError
from blob_tracker.types import Bearing, Frame, LocationError, SensorNoise
from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
START_NS = 10**9  # stamp of the time 0: ns count from there


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
    latency : float
        From the middle of the exposure until the bearing is there: half the exposure, read-out
        (one frame), transfer and computing, s.
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


class History(NamedTuple):
    """What happened: (n,) times, s, and pointing errors, mrad; (n, 2) joints, rad; bearings."""

    times: Array
    errors: Array
    joints: Array
    bearings: int


@dataclass
class Loop:
    """
    The boat, the pan/tilt, the camera, the segmenter, the locator and a law, event by event.

    Parameters
    ----------
    scenario : Scenario
        What happens.
    finder : Finder
        How the light is found.
    law : str
        What turns the pan/tilt, a key of `LAWS`.
    duration : float
        s.
    seed : int
        Of the boat's motion and of all noise.
    region : (int, int)
        Of the sensor that is read out, px; the rest of the picture is left out of the drawing.
    off : (float, float)
        How far pan and tilt are off the light at the beginning, rad.
    boresight : Boresight
        Of the camera.
    every : float
        Time between two looks at the true pointing error, s.

    """

    scenario: Scenario
    finder: Finder
    law: str
    duration: float
    seed: int
    region: tuple[int, int] = (160, 120)
    off: tuple[float, float] = (0.0, 0.0)
    boresight: Boresight = Boresight()
    every: float = 0.002
    _events: list[tuple[float, int, Callable[[float, int], None], int]] = field(
        default_factory=list
    )

    def __post_init__(self) -> None:
        scenario = self.scenario
        self.model = CameraModel.from_data_sheet(
            640, 480, scenario.focal_length, scenario.pixel
        )
        self.ride = scenario.ride(self.duration, self.seed)
        self.camera = PanTiltCamera(
            self.model, self.ride, scenario.light, scenario.sigma, scenario.amplitude,
            background=scenario.background, texture=scenario.texture,
            sensor=Sensor(self.finder.noise), exposure=scenario.exposure, chain=self.finder.chain,
            region=self.region, seed=self.seed,
        )
        x, y, z = self.camera.rays(np.zeros(1), np.zeros((1, 2)))[0]
        start = (
            float(np.arctan2(x, z)) + self.off[0],
            float(np.arctan2(-y, np.hypot(x, z))) + self.off[1],
        )
        self.pan_tilt = PanTilt(scenario.joints, *start)
        self._law = LAWS[self.law](scenario, start)
        self.segmenter = Segmenter(
            threshold=threshold_by_name(self.finder.threshold, sigmas=3.0, extension=2)
        )
        self._order = count()
        self._underway: dict[int, Bearing] = {}
        self._bearings = 0
        self._felt = scenario.gyro.samples(
            self.ride, self.duration, np.random.default_rng([self.seed, 11])
        )

    def run(self) -> History:
        """Run it to the end."""
        scenario, truth = self.scenario, []
        self._at(_times(self.every, self.duration), lambda time, _: truth.append(
            (time, *self.pan_tilt.angles)))
        self._at(_times(1.0 / scenario.joint_rate, self.duration), self._read_joints)
        there = 0.5 / scenario.gyro.rate + scenario.gyro_latency
        self._at(self._felt[0] + there, self._take_gyro)
        self._at(_times(1.0 / scenario.command_rate, self.duration, first=0.0013), self._tick)
        # An exposure ends here; the bearing that comes of it is there when it has arrived.
        middles = _times(1.0 / scenario.rate, self.duration - scenario.latency, first=0.004)
        self._at(middles + 0.5 * scenario.exposure, self._expose)
        while self._events:
            time, _, event, index = heappop(self._events)
            self.pan_tilt.advance(time)
            event(time, index)
        times, joints = np.array(truth)[:, 0], np.array(truth)[:, 1:]
        errors = self.camera.off_axis(times, joints) / MRAD
        return History(times, errors, joints, self._bearings)

    def _at(
        self, times: Iterable[float], event: Callable[[float, int], None], first: int = 0
    ) -> None:
        """Let something happen at each of the times."""
        for index, time in enumerate(times):
            heappush(self._events, (float(time), next(self._order), event, first + index))

    def _expose(self, time: float, index: int) -> None:
        """Take the frame whose exposure is over; what comes of it arrives later."""
        middle = time - 0.5 * self.scenario.exposure
        joints = self.pan_tilt.at(self.camera.times(middle))
        bearing = self.bearing_of(self.camera.frame(index, middle, joints, lit=index % 2 == 0))
        if bearing is not None:
            self._underway[index] = bearing
            self._at([middle + self.scenario.latency], self._take_bearing, index)

    def bearing_of(self, frame: Frame) -> Bearing | None:
        """Return what the default pipeline, or the thesis', makes of a frame."""
        try:
            window = self.segmenter.update(frame)
            if window is None:
                return None
            found = locate(window, method=self.finder.method, noise=self.finder.noise)
            bearing = self.model.bearing(found)
        except (FrameError, LocationError, LensError):
            return None
        return replace(
            bearing, azimuth=bearing.azimuth - self.boresight.azimuth,
            elevation=bearing.elevation - self.boresight.elevation,
            covariance=bearing.covariance + self.boresight.scatter * np.eye(2),
        )

    def _take_bearing(self, time: float, index: int) -> None:
        self._bearings += 1
        self._obey(self._law.bearing(self._underway.pop(index)))

    def _tick(self, time: float, index: int) -> None:
        self._obey(self._law.tick(_stamp(time)))

    def _obey(self, command: tuple[float, float] | None) -> None:
        if command is not None:
            self.pan_tilt.command(*command)

    def _read_joints(self, time: float, index: int) -> None:
        """Read the encoders; the message comes later."""
        pan, tilt = self.pan_tilt.reported()
        self._at(
            [time + self.scenario.joint_latency],
            lambda arrival, _: self._law.joints(_stamp(time), pan, tilt),
        )

    def _take_gyro(self, time: float, index: int) -> None:
        self._law.gyro(
            _stamp(self._felt[0][index]), self._felt[1][index], self.scenario.gyro.variance
        )


def _stamp(time: float) -> int:
    """Return the stamp of a time in s, ns."""
    return START_NS + round(1e9 * time)


def _times(interval: float, end: float, *, first: float = 0.0) -> Array:
    """Return the instants of something periodic, s."""
    return np.asarray(first + interval * np.arange(int((end - first) / interval) + 1))


def boresight_of(scenario: Scenario, finder: Finder, seed: int) -> Boresight:
    """
    Return what a camera's bearings of a light straight ahead are off by, the boat at rest.

    Its seed, of the noise and the shore, is to be none of the rides to which it is applied.
    """
    rest = replace(scenario.disturbed(0.0), speed=0.0)
    loop = Loop(rest, finder, 'proportional', 1.0, seed)
    found, stated = [], []
    for index in range(60):
        # Over 2 px: at every sub-pixel phase.
        joints = np.full((PARTS, 2), index / 30.0 / loop.model.matrix[0, 0])
        middle = index / scenario.rate
        bearing = loop.bearing_of(loop.camera.frame(index, middle, joints, lit=index % 2 == 0))
        if bearing is not None:
            x, y, z = loop.camera.rays(np.array([middle]), joints[:1])[0]
            truth = np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))
            found.append((bearing.azimuth - truth[0] / MRAD, bearing.elevation - truth[1] / MRAD))
            stated.append(np.trace(bearing.covariance) / 2.0)
    azimuth, elevation = np.mean(found, axis=0).tolist()
    scatter = float(np.var(found, axis=0).mean() - np.mean(stated))
    return Boresight(azimuth, elevation, max(scatter, 0.0))

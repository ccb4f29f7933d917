"""The thesis' application as a loop in simulated time: nothing is used before it has arrived."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple

from blob_tracker.camera import CameraModel, LensError
from blob_tracker.capture.fields import fields
from blob_tracker.location import locate
from blob_tracker.segmentation import (
    FieldSegmenter, flash_by_name, FrameError, Segmenter, threshold_by_name,
)
from blob_tracker.simulation.pan_tilt import PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.simulation.waveforms import periodic
from blob_tracker.studies.beyond.servo_laws import LAWS
from blob_tracker.studies.beyond.servo_scenario import Array, Boresight, Finder, Scenario
from blob_tracker.types import Bearing, Frame, LocationError
from blob_tracker.units import MRAD
import numpy as np

START_NS = 10**9  # stamp of the time 0: ns count from there
PHASE = 0.1  # of its period, that a light which runs free has at the time 0


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
            sensor=Sensor(self.finder.noise, row_time=scenario.readout / (self.region[1] - 1)),
            exposure=scenario.exposure, chain=self.finder.chain,
            region=self.region, seed=self.seed,
        )
        x, y, z = self.camera.rays(np.zeros(1), np.zeros((1, 2)))[0]
        start = (
            float(np.arctan2(x, z)) + self.off[0],
            float(np.arctan2(-y, np.hypot(x, z))) + self.off[1],
        )
        self.pan_tilt = PanTilt(scenario.joints, *start)
        self._law = LAWS[self.law](scenario, start)
        self.segmenter = (
            FieldSegmenter(self._new_segmenter) if scenario.interlaced else self._new_segmenter()
        )
        # A line of a field covers its own and the one below, see `fields`.
        shift = np.zeros((3, 3))
        shift[1, 2] = 0.5
        self._seen_by = (
            replace(self.model, matrix=self.model.matrix + shift) if scenario.interlaced
            else self.model
        )
        self._order = count()
        self._underway: dict[int, Bearing] = {}
        self._bearings = 0
        self._felt = scenario.gyro.samples(
            self.ride, self.duration, np.random.default_rng([self.seed, 11])
        )

    def _new_segmenter(self) -> Segmenter:
        free = self.scenario.frequency
        return Segmenter(
            flash=flash_by_name('periodic', frequency=free) if free else None,
            threshold=threshold_by_name(self.finder.threshold, sigmas=3.0, extension=2),
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
        self._at(middles + scenario.readout + 0.5 * scenario.exposure, self._expose)
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
        first = time - self.scenario.readout - 0.5 * self.scenario.exposure
        interlaced = self.scenario.interlaced
        lit = (index // 2 if interlaced else index) % 2 == 0
        free = self.scenario.frequency * (1.0 + self.scenario.clock_error)
        frame = self.camera.frame(
            index, first, self.pan_tilt.at, lit=periodic(free, 0.5, PHASE) if free else lit
        )
        if interlaced:
            kind = index % 2
            field = replace(frame, image=frame.image[kind::2])
            frame, = fields(field, ('top', 'bottom')[kind], 0)
        if not self.scenario.readout_known:
            frame = replace(frame, line_time_ns=0.0)
        bearing = self.bearing_of(frame)
        if bearing is not None:
            self._underway[index] = bearing
            self._at([first + self.scenario.latency], self._take_bearing, index)

    def bearing_of(self, frame: Frame) -> Bearing | None:
        """Return what the default pipeline, or the thesis', makes of a frame."""
        try:
            window = self.segmenter.update(frame)
            if window is None:
                return None
            found = locate(window, method=self.finder.method, noise=self.finder.noise)
            bearing = self._seen_by.bearing(found)
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
        turned = index / 30.0 / loop.model.matrix[0, 0]

        def joints(times: Array, turned: float = turned) -> Array:
            return np.full((len(times), 2), turned)

        middle = index / scenario.rate
        bearing = loop.bearing_of(loop.camera.frame(index, middle, joints, lit=index % 2 == 0))
        if bearing is not None:
            times = np.array([middle])
            x, y, z = loop.camera.rays(times, joints(times))[0]
            truth = np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))
            found.append((bearing.azimuth - truth[0] / MRAD, bearing.elevation - truth[1] / MRAD))
            stated.append(np.trace(bearing.covariance) / 2.0)
    azimuth, elevation = np.mean(found, axis=0).tolist()
    scatter = float(np.var(found, axis=0).mean() - np.mean(stated))
    return Boresight(azimuth, elevation, max(scatter, 0.0))

"""Prediction of a target's bearing from vehicles, and what a bearing costs, beside filterpy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf, nan, sqrt
from statistics import median
from time import process_time
from typing import Any

from blob_tracker.simulation.platform_motion import MOTIONS, Ride
from blob_tracker.tracking import MODELS, PlatformRates, Tracker
from blob_tracker.tracking.hypothesis import (
    CONFIRMING, FIRST_ACCELERATION_MRAD_S2, FIRST_RATE_MRAD_S,
)
from blob_tracker.tracking.models import fill_step
from blob_tracker.tracking.process_noise import process_noise
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from numpy.typing import NDArray

try:
    from filterpy.kalman import KalmanFilter
except ImportError:  # its rows are left out, and the tables say why
    KalmanFilter = None

Tick = Callable[[str], None]
Array = NDArray[np.float64]

RATE, SIGMA = 30.0, 0.1  # bearings a second, as of a light that flashes at 60 Hz, and mrad
HORIZONS = (0.01, 0.03, 0.1)  # s
GYRO_RATE, GYRO_NOISE = 500.0, 1.6e-3  # Hz, rad/s: 0.004 degrees a second a root of Hz
STILL = 3.0  # mrad/s^2: process noise of a target that hardly moves
SETTLED = 30  # bearings at the start that are not judged
REHEARSAL, REHEARSED = 900, 30.0  # seed and length, s, of the ride that tells the process noise
LAGS = 10
HELD, LIMIT, STABILISED, FILTERPY = 'last bearing held', 'limit', 'gyro', 'filterpy'


@dataclass(frozen=True)
class Row:
    """
    Errors of one way to predict, on one vehicle.

    Parameters
    ----------
    motion, contender : str
        Names.
    noise : float
        Process noise, mrad/s^2 or mrad/s^3; NaN if there is none.
    rms : tuple of float
        Of azimuth and elevation together, for each of HORIZONS, mrad.
    nees, nis : float
        Of the filtered bearing and of the innovations, over their degrees of freedom: 1 where the
        covariance is true. NaN where it is not looked at.
    correlation : float
        Largest autocorrelation of the innovations over the first LAGS, by amount.
    bound : float
        What 95 % of the correlations of white innovations keep within.

    """

    motion: str
    contender: str
    noise: float
    rms: tuple[float, ...]
    nees: float = nan
    nis: float = nan
    correlation: float = nan
    bound: float = nan


@dataclass(frozen=True)
class Cost:
    """
    What a bearing costs.

    Parameters
    ----------
    model : str
        A key of MODELS.
    seconds : float
        Of `Tracker.update`, median of the repeats.
    answer : float
        Of `Tracker.at`.
    stabilised : float
        Of `Tracker.update` with the platform's rotation.
    reference : float
        Of filterpy's predict and update on the same bearings; NaN where it is missing.

    """

    model: str
    seconds: float
    answer: float
    stabilised: float
    reference: float

    @property
    def ratio(self) -> float:
        """`seconds` over `reference`."""
        return self.seconds / self.reference


@dataclass(frozen=True)
class Figures:
    """The rows of both."""

    rows: Sequence[Row] = ()
    costs: Sequence[Cost] = ()


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(MOTIONS) + len(MODELS)


def run(duration: float, repeats: int, tick: Tick) -> Figures:
    """Return the rows from rides of `duration` s, and the costs as medians of the repeats."""
    rows = []
    for motion in MOTIONS:
        tick(f'tracking: {motion}')
        rows += ride_rows(motion, duration)
    costs = []
    for model in MODELS:
        tick(f'tracking: cost, {model}')
        costs.append(cost(model, repeats))
    return Figures(rows, costs)


def ride_rows(motion: str, duration: float) -> list[Row]:
    """Return the rows of one vehicle; the target is a light far away."""
    rehearsal = MOTIONS[motion].ride(REHEARSED, REHEARSAL)
    rehearsed = bearings_of(rehearsal, REHEARSED, REHEARSAL)
    ride = MOTIONS[motion].ride(duration + 1.0, 1)
    bearings = bearings_of(ride, duration, 1)
    true = Truth(ride, bearings)
    rows = []
    for model, (_, parameter) in MODELS.items():
        noise = process_noise(rehearsed, model)
        settings: dict[str, Any] = {parameter: noise}
        tracker = Tracker(model, **settings, gate_sigma=inf, max_sigma=1e6)
        rows.append(_row(motion, model, noise, ours(tracker, bearings), true))
        if KalmanFilter is not None:
            found = filtered(model, noise, bearings)
            rows.append(_row(motion, f'{FILTERPY}, {model}', noise, found, true))
    tracker = Tracker(
        platform=PlatformRates(), stabilised_acceleration=STILL, gate_sigma=inf, max_sigma=1e6
    )
    name = f'constant_velocity and {STABILISED}'
    rows.append(_row(motion, name, STILL, ours(tracker, bearings, gyro(ride, duration)), true))
    held = [
        Answer(*[np.array([each.azimuth, each.elevation])] * (1 + len(HORIZONS)))
        for each in bearings
    ]
    rows.append(_row(motion, HELD, nan, held, true))
    limits = [
        [
            MRAD_PER_RAD * MOTIONS[motion].process(axis).prediction_limit(
                horizon, interval=1.0 / RATE, variance=(SIGMA / MRAD_PER_RAD)**2
            )
            for axis in ('pitch', 'yaw')
        ]
        for horizon in HORIZONS
    ]
    return [*rows, Row(motion, LIMIT, nan, tuple(np.sqrt(np.mean(np.square(limits), axis=1))))]


def bearings_of(ride: Ride, duration: float, seed: int) -> list[Bearing]:
    """Return bearings of a light straight ahead at rest, from a vehicle that turns."""
    times = np.arange(0.0, duration, 1.0 / RATE)
    noise = SIGMA * np.random.default_rng([seed, 1]).standard_normal((times.size, 2))
    return [
        Bearing(azimuth, elevation, SIGMA**2 * np.eye(2), round(1e9 * time))
        for time, (azimuth, elevation) in zip(times, (angles_at(ride, times) + noise).tolist())
    ]


def angles_at(ride: Ride, times: Array) -> Array:
    """Return the light's (n, 2) azimuth and elevation on the vehicle, mrad."""
    x, y, z = ride.rotations(times)[:, 2].T
    return MRAD_PER_RAD * np.stack([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))], axis=1)


def gyro(ride: Ride, duration: float) -> Iterator[tuple[int, Array]]:
    """Yield the stamps, ns, and noisy angular velocities, rad/s, of a gyro on the vehicle."""
    times = np.arange(0.0, duration, 1.0 / GYRO_RATE)
    noise = GYRO_NOISE * np.random.default_rng(7).standard_normal((times.size, 3))
    for time, rate in zip(times, ride.rates(times) + noise):
        yield round(1e9 * time), rate


class Truth:
    """Where the light is at the bearings, and as far after them as is predicted."""

    def __init__(self, ride: Ride, bearings: Sequence[Bearing]) -> None:
        times = 1e-9 * np.array([each.stamp_ns for each in bearings])
        self.angles = [angles_at(ride, times + ahead) for ahead in (0.0, *HORIZONS)]


class Answer:
    """What is said after a bearing: the angles then and at each horizon, and how sure it is."""

    def __init__(
        self, *angles: Array, covariance: Array | None = None, innovation: Array | None = None
    ) -> None:
        self.angles = angles
        self.covariance = covariance
        self.innovation = innovation


def ours(
    tracker: Tracker, bearings: Sequence[Bearing], rates: Iterator[tuple[int, Array]] | None = None
) -> list[Answer]:
    """Return the tracker's answers; a gyro's samples come as far as each bearing's stamp."""
    answers = []
    sample = next(rates) if rates is not None else None
    for bearing in bearings:
        while rates is not None and sample is not None and sample[0] <= bearing.stamp_ns:
            assert tracker.platform is not None
            tracker.platform.push(*sample, GYRO_NOISE**2)
            sample = next(rates, None)
        track = tracker.update(bearing)
        ahead = [tracker.at(bearing.stamp_ns + round(1e9 * each)) for each in HORIZONS]
        innovation = tracker.innovation
        answers.append(Answer(
            # Before there is a track that tells, the bearing held; it is not counted.
            track.state[:2], *((track if each is None else each).state[:2] for each in ahead),
            covariance=track.angle_covariance,
            innovation=None if innovation is None else np.array(innovation[:2]),
        ))
    return answers


def prepared(model: str, bearings: Sequence[Bearing]) -> Any:
    """Return filterpy's filter at the first bearing, with the same prior as ours."""
    size = MODELS[model].size
    kalman = KalmanFilter(dim_x=size, dim_z=2)
    kalman.H = np.eye(2, size)
    kalman.x[:2, 0] = bearings[0].azimuth, bearings[0].elevation
    deviations = [0.0] * 2 + [FIRST_RATE_MRAD_S] * 2 + [FIRST_ACCELERATION_MRAD_S2] * 2
    kalman.P = np.diag(np.square(deviations[:size]))
    kalman.P[:2, :2] = bearings[0].covariance
    return kalman


def step_of(model: str, noise: float, seconds: float) -> tuple[Array, Array]:
    """Return transition and process noise of the model."""
    size = MODELS[model].size
    transition, added = np.empty((size, size)), np.empty((size, size))
    fill_step(seconds, noise**2, transition, added)
    return transition, added


def filtered(model: str, noise: float, bearings: Sequence[Bearing]) -> list[Answer]:
    """Return the answers of filterpy's filter with the same model, noise and prior."""
    kalman = prepared(model, bearings)
    answers = []
    for index, bearing in enumerate(bearings):
        if index:
            seconds = 1e-9 * (bearing.stamp_ns - bearings[index - 1].stamp_ns)
            transition, added = step_of(model, noise, seconds)
            kalman.predict(F=transition, Q=added)
            kalman.update(np.array([bearing.azimuth, bearing.elevation]), R=bearing.covariance)
        root = np.linalg.cholesky(kalman.S) if index else np.eye(2)
        answers.append(Answer(
            kalman.x[:2, 0].copy(),
            *((step_of(model, noise, each)[0] @ kalman.x)[:2, 0] for each in HORIZONS),
            covariance=kalman.P[:2, :2].copy(),
            innovation=np.linalg.solve(root, kalman.y[:, 0]) if index else None,
        ))
    return answers


def _row(
    motion: str, contender: str, noise: float, answers: Sequence[Answer], true: Truth
) -> Row:
    chosen = slice(SETTLED, None)
    errors = [
        np.array([each.angles[place] for each in answers])[chosen] - angles[chosen]
        for place, angles in enumerate(true.angles)
    ]
    rms = tuple(sqrt(np.mean(each**2)) for each in errors[1:])
    kept = answers[chosen]
    covariances = [each.covariance for each in kept if each.covariance is not None]
    innovations = np.array([each.innovation for each in kept if each.innovation is not None])
    if len(covariances) < len(kept) or len(innovations) < len(kept):
        return Row(motion, contender, noise, rms)
    nees = np.einsum('ni,nij,nj', errors[0], np.linalg.inv(covariances), errors[0])
    power = np.mean(innovations**2)
    # Each axis by itself: what is too much in one does not make up for what is too little in
    # the other.
    correlations = [
        np.mean(innovations[lag:] * innovations[:-lag], axis=0) / np.mean(innovations**2, axis=0)
        for lag in range(1, LAGS + 1)
    ]
    return Row(
        motion, contender, noise, rms, float(nees) / errors[0].size, float(power),
        float(np.abs(correlations).max()), 1.96 / sqrt(len(kept)),
    )


def cost(model: str, repeats: int) -> Cost:
    """Return what a bearing costs, all in turn on the same bearings, one core."""
    noise = {'constant_velocity': 40.0, 'constant_acceleration': 400.0}[model]
    ride = MOTIONS['sea'].ride(REHEARSED + 1.0, 2)
    bearings = bearings_of(ride, REHEARSED, 2)
    steps_to = [
        step_of(model, noise, 1e-9 * (after.stamp_ns - before.stamp_ns))
        for before, after in zip(bearings, bearings[1:])
    ]
    seen = [np.array([each.azimuth, each.elevation]) for each in bearings]
    platform = PlatformRates(memory=2.0 * REHEARSED)
    for stamp, rate in gyro(ride, REHEARSED + 0.5):
        platform.push(stamp, rate, GYRO_NOISE**2)
    found: dict[str, list[float]] = {'ours': [], 'answer': [], 'stabilised': [], FILTERPY: []}
    for _ in range(repeats + 1):  # the first compiles
        for name, rates in (('ours', None), ('stabilised', platform)):
            tracker = Tracker(
                model, acceleration=noise, jerk=noise, platform=rates, gate_sigma=inf
            )
            began = process_time()
            for bearing in bearings:
                tracker.update(bearing)
            found[name].append((process_time() - began) / len(bearings))
        tracker = Tracker(model, acceleration=noise, jerk=noise)
        for bearing in bearings[:CONFIRMING]:
            tracker.update(bearing)
        stamp = bearing.stamp_ns + 1
        began = process_time()
        for _ in bearings:
            tracker.at(stamp)
        found['answer'].append((process_time() - began) / len(bearings))
        if KalmanFilter is None:
            found[FILTERPY].append(nan)
            continue
        kalman = prepared(model, bearings)
        began = process_time()
        for (transition, added), measured, bearing in zip(steps_to, seen[1:], bearings[1:]):
            kalman.predict(F=transition, Q=added)
            kalman.update(measured, R=bearing.covariance)
        found[FILTERPY].append((process_time() - began) / len(steps_to))
    medians = {name: median(each[1:]) for name, each in found.items()}
    return Cost(
        model, medians['ours'], medians['answer'], medians['stabilised'], medians[FILTERPY]
    )

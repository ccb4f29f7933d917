"""How well a direction is predicted on a boat, a rover and a drone; if the filter knows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, sqrt

from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.platform_motion import MOTIONS, Ride
from blob_tracker.studies.axes import COLOURS, legend_below, new_axes
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
from blob_tracker.tracking import PlatformRates, Tracker, TrackingError
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD, MRAD_PER_RAD
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads stats when it is first used

Array = NDArray[np.float64]
HORIZONS = (0.01, 0.03, 0.1)  # s from the bearing's stamp
RATE, SIGMA = 30.0, 0.03  # bearings a second, and the deviation of each angle, mrad
SETTLED = 1.0  # s after which errors count
DURATIONS, SEEDS = (3.0, 12.0), (2, 20)  # s, and rides: quick and full
LAGS = 5  # frames over which innovations are compared
START_NS = 10**9
HELD, LIMIT = 'last bearing held', "the motion's own limit"
# Process noise by motion: the most likely one for a ride of 30 s that is none of those here
# (blob_tracker.tracking.process_noise), mrad/s^2 and mrad/s^3; with the gyro's rotation known,
# what its errors leave.
NOISES: dict[str, tuple[float, float, float, float]] = {
    'sea': (36.0, 410.0, 1.0, 3.7),
    'rover': (410.0, 15000.0, 5.2, 73.0),
    'drone': (230.0, 6900.0, 3.3, 29.0),
}
FILTERS = {
    'constant velocity': ('constant_velocity', False),
    'constant acceleration': ('constant_acceleration', False),
    'constant velocity, gyro': ('constant_velocity', True),
    'constant acceleration, gyro': ('constant_acceleration', True),
}


def cases(quick: bool) -> Sequence[Case]:
    """Return a case for each motion and ride."""
    return [
        {'motion': motion, 'seed': seed, 'duration': DURATIONS[not quick]}
        for motion in MOTIONS for seed in range(1, 1 + SEEDS[not quick])
    ]


def measure(case: Case) -> Measured:
    """Follow a light ahead of a vehicle that turns, through one ride."""
    duration = case['duration']
    ride = MOTIONS[case['motion']].ride(duration + 0.5, case['seed'])
    random = np.random.default_rng([case['seed'], 21])
    times = 0.1 + np.arange(int((duration - 0.1) * RATE)) / RATE
    truth = directions(ride, times)
    seen = truth + SIGMA * random.standard_normal(truth.shape)
    felt = Gyro().samples(ride, duration, random)
    future = {horizon: directions(ride, times + horizon) for horizon in HORIZONS}
    counted = times >= SETTLED
    found: Measured = {
        HELD: {'squares': [_square(seen - future[each], counted) for each in HORIZONS]},
    }
    for name, (model, gyro) in FILTERS.items():
        tracker = _tracker(case['motion'], model, gyro=gyro)
        found[name] = _followed(tracker, times, seen, truth, future, felt)
    return found


def directions(ride: Ride, times: Array) -> Array:
    """Return (n, 2) azimuth and elevation of a light straight ahead at rest, mrad."""
    x, y, z = np.swapaxes(ride.rotations(times), -1, -2)[:, :, 2].T
    return MRAD_PER_RAD * np.stack([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))], axis=1)


def limit(motion: str, horizon: float) -> float:
    """
    Return the error that a filter which knows the motion would have, both angles together, mrad.

    Azimuth is taken to be yaw and elevation pitch, each by itself.
    """
    yaw, pitch = (
        MRAD_PER_RAD * MOTIONS[motion].process(axis).prediction_limit(
            horizon, interval=1.0 / RATE, variance=(MRAD * SIGMA) ** 2
        )
        for axis in ('yaw', 'pitch')
    )
    return hypot(yaw, pitch)


def _tracker(motion: str, model: str, *, gyro: bool) -> Tracker:
    acceleration, jerk, resting, resting_jerk = NOISES[motion]
    return Tracker(
        model,
        acceleration=acceleration,
        jerk=jerk,
        stabilised_acceleration=resting,
        stabilised_jerk=resting_jerk,
        gate_sigma=8.0,  # what is compared are the filters: nothing here is a false light
        max_sigma=1e3,
        platform=PlatformRates() if gyro else None,
    )


def _square(errors: Array, counted: NDArray[np.bool_]) -> float:
    """Return the mean square of both angles together, mrad^2."""
    return float((errors[counted] ** 2).sum(axis=1).mean())


def _followed(
    tracker: Tracker, times: Array, seen: Array, truth: Array,
    future: Mapping[float, Array], felt: tuple[Array, Array],
) -> Measured:
    """Return the squares of the prediction's errors, NEES, and innovations; causal."""
    covariance = SIGMA**2 * np.eye(2)
    platform, gyro, taken = tracker.platform, Gyro(), 0
    there = felt[0] + 0.5 / gyro.rate  # a sample is a mean: it is there when it is over
    errors = {horizon: np.zeros_like(truth) for horizon in HORIZONS}
    nees, innovations = np.zeros(len(times)), np.zeros((len(times), 2))
    for index, time in enumerate(times.tolist()):
        while platform is not None and taken < len(there) and there[taken] <= time:
            platform.push(_stamp(felt[0][taken]), felt[1][taken], gyro.variance)
            taken += 1
        stamp = _stamp(time)
        try:
            azimuth, elevation = seen[index].tolist()
            track = tracker.update(Bearing(azimuth, elevation, covariance, stamp))
            off = np.array([track.azimuth, track.elevation]) - truth[index]
            nees[index] = off @ np.linalg.solve(track.angle_covariance, off)
        except TrackingError:
            nees[index] = np.nan
        if tracker.innovation is not None:
            innovations[index] = tracker.innovation.first, tracker.innovation.second
        for horizon in HORIZONS:
            ahead = tracker.at(stamp + round(1e9 * horizon))
            if ahead is None:  # as with the last bearing held
                errors[horizon][index] = seen[index] - future[horizon][index]
            else:
                errors[horizon][index] = ahead.azimuth, ahead.elevation
                errors[horizon][index] -= future[horizon][index]
    counted = times >= SETTLED
    return {
        'squares': [_square(errors[each], counted) for each in HORIZONS],
        'nees': nees[counted].tolist(),
        'innovations': innovations[counted].tolist(),
    }


def _stamp(time: float) -> int:
    return START_NS + round(1e9 * time)


def conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Lay the errors beside the limit, and the filter's own opinion beside the errors."""
    rms = {
        (motion, name): [
            sqrt(float(np.mean([
                found[name]['squares'][place] for case, found in results
                if case['motion'] == motion
            ])))
            for place in range(len(HORIZONS))
        ]
        for motion in MOTIONS for name in (HELD, *FILTERS)
    }
    limits = {motion: [limit(motion, horizon) for horizon in HORIZONS] for motion in MOTIONS}
    rows: list[list[Cell]] = []
    for motion in MOTIONS:
        rows += [[motion, name, *rms[motion, name]] for name in (HELD, *FILTERS)]
        rows.append([motion, LIMIT, *limits[motion]])
    consistent = {
        (motion, name): _consistency(
            [found[name] for case, found in results if case['motion'] == motion]
        )
        for motion in MOTIONS for name in FILTERS
    }
    cv, ca, gyro = list(FILTERS)[0], list(FILTERS)[1], list(FILTERS)[2]
    sea = {name: rms['sea', name] for name in (HELD, *FILTERS)}
    gain = [rms[motion, HELD][1] / min(rms[motion, cv][1], rms[motion, ca][1])
            for motion in MOTIONS]
    over = [min(rms[motion, cv][1], rms[motion, ca][1]) / limits[motion][1] for motion in MOTIONS]
    with_gyro = [rms[motion, gyro][1] for motion in MOTIONS]
    inside = [entry[1] for entry in consistent.values()]
    white = [abs(entry[3]) for entry in consistent.values()]
    whitest = {
        motion: min(abs(consistent[motion, name][3]) for name in FILTERS) for motion in MOTIONS
    }
    bound = next(iter(consistent.values()))[4]
    return Findings(
        shows=(
            f'30 ms ahead the better filter errs {min(gain):.1f} to {max(gain):.1f} times less '
            f'than the last bearing held and {min(over):.2f} to {max(over):.2f} times as much as '
            "one that knew the motion's own process, on a boat, a rover and a drone; with the "
            f'gyro, which is no later here than the bearing, it errs by {min(with_gyro):.2f} to '
            f'{max(with_gyro):.2f} mrad. On the boat at 100 ms: {sea[HELD][2]:.1f} mrad held, '
            f'{sea[cv][2]:.1f} constant velocity, {sea[ca][2]:.1f} constant acceleration, '
            f'{limits["sea"][2]:.1f} the limit, {sea[gyro][2]:.1f} with the gyro. A gyro is worth '
            'most where bearings come late, as in the study servo. NEES of the filtered angles is '
            f'{min(e[0] for e in consistent.values()):.2f} to '
            f'{max(e[0] for e in consistent.values()):.2f} of 2, inside its 95 % bounds for '
            f'{100.0 * min(inside):.0f} to {100.0 * max(inside):.0f} % of the time. No vehicle '
            'moves by the model: its turns have a memory, and the largest correlation of '
            f'innovations is {max(white):.2f}, where chance has {bound:.2f}.'
        ),
        agreement=(
            f'30 ms ahead {min(gain):.1f} to {max(gain):.1f} times better than the last bearing '
            f"held, {min(over):.2f} to {max(over):.2f} times the motion's own limit"
        ),
        tables=(
            Table(
                'prediction', 'Error of the predicted direction, both angles together',
                ('vehicle', 'predicted by',
                 *(f'{1e3 * horizon:g} ms ahead, rms mrad' for horizon in HORIZONS)),
                rows,
            ),
            Table(
                'prediction_consistency', "The filter's own opinion: angles at the bearings",
                ('vehicle', 'filter', 'NEES of 2', 'inside its 95 % bounds', 'NIS of 2',
                 f'largest correlation of innovations, lags 1 to {LAGS}', 'chance, 95 %'),
                [[*key, *entry] for key, entry in consistent.items()],
            ),
        ),
        figures={'prediction': _draw(rms, limits)},
        checks=[
            *(
                Check(f'{motion}: the better filter 30 ms ahead', 'better than the bearing held',
                      f'{one:.1f} times', one > 1.0)
                for motion, one in zip(MOTIONS, gain)
            ),
            *(
                Check(f'{motion}: the better filter 30 ms ahead',
                      "<= 1.3 times the motion's limit", f'{one:.2f} times', one <= 1.3)
                for motion, one in zip(MOTIONS, over)
            ),
            *(
                Check(f'{motion}, {name}: a true covariance',
                      'NEES inside its 95 % bounds for 90 % of the time',
                      f'{100.0 * entry[1]:.0f} %', entry[1] >= 0.9)
                for (motion, name), entry in consistent.items()
            ),
            *(
                Check(f'{motion}: innovations of the filter with the whitest ones',
                      f'correlations within chance, {bound:.2f}', f'{least:.2f}', least <= bound)
                for motion, least in whitest.items()
            ),
        ],
    )


def _consistency(runs: Sequence[Measured]) -> tuple[float, float, float, float, float]:
    """
    Return what NEES and innovations of runs of one filter say.

    NEES: mean, and the part of the instants at which its mean over the runs lies within the 95 %
    interval of a chi-square with two degrees of freedom each (Bar-Shalom, Li, Kirubarajan,
    Estimation with Applications to Tracking and Navigation, 5.4.2). Innovations: mean square, and
    the largest correlation over LAGS lags, with the bound that chance keeps in 95 % of them.
    """
    nees = np.array([run['nees'] for run in runs], dtype=float)
    low, high = scipy.stats.chi2.ppf([0.025, 0.975], 2 * len(runs)) / len(runs)
    by_time = np.nanmean(nees, axis=0)
    series = np.array([run['innovations'] for run in runs])
    power = (series**2).mean()
    correlations = [
        float((series[:, lag:] * series[:, :-lag]).mean() / power) for lag in range(1, 1 + LAGS)
    ]
    return (
        float(np.nanmean(nees)),
        float(((by_time >= low) & (by_time <= high)).mean()),
        float(2.0 * power),
        max(correlations, key=abs),
        1.96 / sqrt(series.size),
    )


def _draw(
    rms: Mapping[tuple[str, str], Sequence[float]], limits: Mapping[str, Sequence[float]]
) -> Figure:
    """Draw the errors against the horizon, a panel for each vehicle."""
    figure, panels = new_axes(len(limits))
    ahead = 1e3 * np.array(HORIZONS)
    for panel, (motion, own) in zip(panels, limits.items()):
        panel.set(xlabel=f'ms ahead, {motion}', ylabel='error, rms mrad', xscale='log',
                  yscale='log')
        for name, colour in zip((HELD, *FILTERS), COLOURS):
            style = '--' if name.startswith('constant acceleration') else '-'
            panel.plot(ahead, rms[motion, name], 'o' + style, color=colour, label=name)
        panel.plot(ahead, own, 'k:', label=LIMIT)
        panel.set_xticks(ahead, [f'{each:g}' for each in ahead])
    legend_below(figure, panels[0], 3)
    return figure


STUDY = Study(
    name='prediction',
    title='The direction 10, 30 and 100 ms ahead, on a boat, a rover and a drone',
    source='Disturbances, page 1',
    cases=cases,
    measure=measure,
    conclude=conclude,
)

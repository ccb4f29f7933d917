"""How a gyro sits beside a camera, from turning both before a light that stands still."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

from blob_tracker.calibration.imu_problem import ImuProblem
from blob_tracker.tracking.gyro_fit import fit_gyro, intervals_of, moves_of
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

FEWEST = 100  # intervals between two bearings, for 8 unknowns and a noise
LONGEST_S = 0.3  # of an interval
SAMPLES = 2  # of the gyro in the shortest
SHORTEST_S = 0.08  # of one of the first look
MARGIN_S = 0.25  # that the gyro is to cover beyond the bearings: an offset within it is found
# Of the intervals; where the gyro is seen to be wrong, those beside them are as well.
MOST_STRAY, TROUBLED_STRAY = 0.25, 0.1
LEAST_AT_LIMIT = 3  # samples with the largest rate of all
GAP = 2.5  # times the median step of the gyro
COARSE = 0.03  # of the rates: what every other sample does not tell of those between
ROUNDS = 2  # of the fit, each with the noise of the one before
BAD_NOISE = 5e-3  # 0.3 degrees/s/sqrt(Hz), thirty times that of a cheap one
VAGUE_RAD = 0.05  # of the turn: with it the tracker is as well off without the gyro
CORRELATED = 6.0  # standard deviations of a correlation of what is left: no noise


class ImuError(ValueError):
    """
    Samples that tell nothing of how the gyro sits; the message says why.

    Examples
    --------
    Too short a recording:

    >>> directions = np.tile([0.0, 0.0, 1.0], (20, 1))
    >>> covariances = np.tile(1e-9 * np.eye(2), (20, 1, 1))
    >>> times = 0.05 * np.arange(20)
    >>> calibrate_imu(times, directions, covariances, times, np.zeros((20, 3)))
    Traceback (most recent call last):
        ...
    blob_tracker.calibration.imu.ImuError: 20 samples of the gyro; 100 are the least

    """


@dataclass(frozen=True)
class ImuCalibration:
    """
    How a gyro sits beside a camera.

    Parameters
    ----------
    turn : (3, 3) array
        Takes components in the IMU to those in the camera's optical frame.
    offset : float
        How late the stamps of the gyro are, s, by those of the bearings.
    bias : (3,) array
        That the gyro says at rest, in its own axes, rad/s.
    scale : float
        By which the camera sees it turn further than the gyro says, as a part: of the gyro, or of
        the focal length.
    noise : float
        Density of the gyro's noise, rad/s/sqrt(Hz).
    covariance : (8, 8) array
        Of the turn about x, y and z of the camera (rad), offset, bias and scale.
    times : (n,) array
        Ends of the intervals, s.
    residuals : (n, 2) array
        Measured less predicted at the end of each interval, over its standard deviation and
        without what it shares with the former ones.
    stray : float
        Share of the intervals that were left out.

    Examples
    --------
    An IMU that sits as ROS has it, x forward and z up, and how well that is known:

    >>> found = ImuCalibration(
    ...     np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]), offset=0.01,
    ...     bias=np.zeros(3), scale=0.0, noise=1e-4, covariance=np.diag([1e-6] * 3 + [1e-8] * 5),
    ...     times=np.zeros(0), residuals=np.zeros((0, 2)), stray=0.0,
    ... )
    >>> found.sigmas[:3].round(4).tolist()  # rad
    [0.001, 0.001, 0.001]
    >>> (found.turn @ [0.0, 0.0, 1.0]).tolist()  # up is the camera's -y
    [0.0, -1.0, 0.0]

    """

    turn: Array
    offset: float
    bias: Array
    scale: float
    noise: float
    covariance: Array
    times: Array
    residuals: Array
    stray: float

    @property
    def sigmas(self) -> Array:
        """Return the standard deviations of the 8, in that order."""
        return np.sqrt(np.diag(self.covariance))


def calibrate_imu(
    times: Array, directions: Array, covariances: Array, gyro_times: Array, rates: Array
) -> ImuCalibration:
    """
    Fit the turn, the offset of the stamps, the bias and the scale of a gyro.

    From one bearing to the next the light's direction turns by the vector

        v = (1 + s) C (-a + 1/2 int w x (a - a0) dt),    w = rate - bias,  a = int w dt

    over the interval, by the gyro's clock (Magnus expansion; C takes the IMU's axes to the
    camera's). The residuals have the noise of both bearings, of which two neighbours share one,
    and of the gyro, whose density is the likeliest.

    Parameters
    ----------
    times : (n,) array
        Of the bearings, s, rising.
    directions : (n, 3) array
        Of the light in the optical frame, of length 1.
    covariances : (n, 2, 2) array
        Of azimuth and elevation, rad^2.
    gyro_times : (m,) array
        s, rising, of the same origin.
    rates : (m, 3) array
        In the IMU's axes, rad/s.

    Raises
    ------
    ImuError
        If they tell nothing, with what to do.

    Examples
    --------
    An IMU with ROS' axes, whose stamps are 10 ms late, beside a camera that is turned by hand
    before a light:

    >>> from blob_tracker.simulation.platform_motion import Ride
    >>> random, speeds = np.random.default_rng(1), 2.0 * np.pi * np.array([0.31, 0.37, 0.23])
    >>> gyro_times, times = np.arange(0.0, 16.0, 0.01), np.arange(0.1, 15.9, 0.05)
    >>> phases = np.outer(gyro_times, speeds)
    >>> ride = Ride(0.01, 0.25 * np.sin(phases), 0.25 * speeds * np.cos(phases))
    >>> seen = random.normal(ride.rotations(times)[:, 2], 3e-5)
    >>> seen /= np.linalg.norm(seen, axis=1, keepdims=True)
    >>> turn = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    >>> rates = random.normal(ride.rates(gyro_times) @ turn, 1e-3)
    >>> covariances = np.tile(3e-5**2 * np.eye(2), (len(times), 1, 1))
    >>> found = calibrate_imu(times, seen, covariances, gyro_times + 0.01, rates)
    >>> found.turn.round().astype(int).tolist(), round(1e3 * found.offset)  # -, ms
    ([[0, -1, 0], [0, 0, -1], [1, 0, 0]], 10)

    """
    known = np.isfinite(directions).all(axis=1) & np.isfinite(covariances).all(axis=(1, 2))
    times, directions, covariances = _each_once(
        times[known], directions[known], covariances[known]
    )
    gyro_times, rates = _each_once(gyro_times, rates)
    if len(gyro_times) < FEWEST:
        raise ImuError(f'{len(gyro_times)} samples of the gyro; {FEWEST} are the least')
    if not np.isfinite(rates).all():
        raise ImuError('some rates of the gyro are not numbers: is it starting or failing?')
    if not rates.any():
        raise ImuError('all rates of the gyro are 0: does its driver fill in angular_velocity?')
    within = (times > gyro_times[0] + MARGIN_S) & (times < gyro_times[-1] - MARGIN_S)
    times, directions, covariances = times[within], directions[within], covariances[within]
    # Of shorter ones neighbours would share the noise of a sample.
    shortest = SAMPLES * float(np.median(np.diff(gyro_times)))
    if shortest > LONGEST_S:
        raise ImuError(
            f'the gyro speaks at {SAMPLES / shortest:.3g} Hz; {SAMPLES / LONGEST_S:.0f} are the '
            'least, and 50 are better'
        )
    pairs = intervals_of(times, shortest, LONGEST_S)
    if len(pairs[0]) < FEWEST:
        raise ImuError(
            f'{len(pairs[0])} pairs of bearings follow each other within {LONGEST_S:g} s while '
            f'the gyro speaks; {FEWEST} are the least: turn for half a minute, with the light in '
            'view'
        )
    trouble = _trouble(gyro_times, rates)
    start = _start(times, directions, gyro_times, rates, trouble)
    problem = ImuProblem(times, directions, covariances, pairs, gyro_times, rates, start)
    # Intervals of another light, or with a gap or the limit of the gyro in them, are left out.
    parameters = problem.robust()
    agree = problem.agree(parameters)
    pairs = pairs[0][agree], pairs[1][agree]
    problem = ImuProblem(times, directions, covariances, pairs, gyro_times, rates, start)
    noise = problem.noise(parameters)
    for _ in range(ROUNDS):
        root = problem.root(problem.covariance(parameters), noise)
        fit = least_squares(
            lambda each: problem.whitened(each, root), parameters, method='lm', x_scale='jac',
        )
        parameters = fit.x
        noise = problem.noise(parameters)
    root = problem.root(problem.covariance(parameters), noise)
    left = problem.whitened(parameters, root)
    size = np.linalg.norm(fit.jac, axis=0)
    normal = (fit.jac / size).T @ (fit.jac / size)
    values, vectors = np.linalg.eigh(normal)
    inverse = vectors / np.maximum(values, 1e-14) @ vectors.T / np.outer(size, size)
    residuals = left.reshape(-1, 2)
    _check(inverse, noise, residuals, 1.0 - float(agree.mean()), trouble)
    turn = (Rotation.from_rotvec(parameters[:3]) * Rotation.from_matrix(start)).as_matrix()
    return ImuCalibration(
        turn, float(parameters[3]), parameters[4:7], float(parameters[7]), noise, inverse,
        times[pairs[1]], residuals, 1.0 - float(agree.mean()),
    )


def _each_once(times: Array, *values: Array) -> tuple[Array, ...]:
    """Return samples in the order of their stamps, the first of each stamp."""
    rising, first = np.unique(times, return_index=True)
    return rising, *(each[first] for each in values)


def _start(
    times: Array, directions: Array, gyro_times: Array, rates: Array, trouble: str
) -> Array:
    """Return the turn to begin with, or raise where there was too little turning."""
    moves = moves_of(times, directions, SHORTEST_S, LONGEST_S)
    told, fault = fit_gyro(moves, gyro_times, rates)
    if not told:
        raise ImuError(
            'the light moves too little in the picture, or otherwise than the gyro says: '
            + (trouble or 'turn camera and IMU together, by 20 degrees and more to either side, '
                          'about all axes')
        )
    if fault is None:
        return np.eye(3)
    if fault.turn is None:
        raise ImuError(
            f'{fault.words}: '
            + (trouble or 'are both on the same platform, and the stamps of one clock?')
        )
    if fault.scale != 1.0:
        raise ImuError(f'{fault.words}: have the driver publish rad/s, and record again')
    # Of a light ahead the picture hardly shows a turn about its own axis: the hand tells it.
    first, second = fault.turn[0], fault.turn[1]
    return np.stack([first, second, np.cross(first, second)])


def _trouble(gyro_times: Array, rates: Array) -> str:
    """Return what the samples of the gyro suffer from; empty if nothing is to be seen."""
    found = []
    most = np.abs(rates).max(axis=0)
    at_limit = (np.abs(rates) >= most * (1.0 - 1e-9)).sum(axis=0)
    axis = int(at_limit.argmax())
    if at_limit[axis] >= LEAST_AT_LIMIT:
        found.append(
            f'the gyro is at its limit about {"xyz"[axis]}, {most[axis]:.3g} rad/s, in '
            f'{at_limit[axis]} samples: turn slower, or choose a wider range'
        )
    steps = np.diff(gyro_times)
    gaps = steps > GAP * np.median(steps)
    if gaps.any():
        found.append(
            f'{int(gaps.sum())} gaps between samples of the gyro, of up to {steps.max():.2g} s: '
            'samples are lost on the way'
        )
    middle = rates[1:-1:2]
    guess = CubicSpline(gyro_times[::2], rates[::2])(gyro_times[1:-1:2])
    if np.linalg.norm(middle - guess) > COARSE * np.linalg.norm(middle - middle.mean(axis=0)):
        found.append(
            f'{1.0 / np.median(steps):.3g} Hz of the gyro are too few for how it is turned: turn '
            'slower, or have it publish more often'
        )
    return '; '.join(found)


def _check(
    covariance: Array, noise: float, residuals: Array, stray: float, trouble: str
) -> None:
    """Raise ImuError if the fit is none."""
    # About 0 where it is noise, with a standard deviation of 1 over the root of their number.
    count = residuals[1:].size
    shared = float((residuals[1:] * residuals[:-1]).mean() / (residuals**2).mean())
    if stray > (TROUBLED_STRAY if trouble else MOST_STRAY):
        raise ImuError(
            f'in {100.0 * stray:.0f} % of the intervals the light moves otherwise than camera and '
            f'gyro do: {trouble or "is it always the same light, and does it stand still?"}'
        )
    if noise > BAD_NOISE or abs(shared) > CORRELATED / sqrt(count):
        raise ImuError(
            f'the light moves otherwise than camera and gyro do ({noise:.2g} rad/s/sqrt(Hz) are '
            f'left, correlated by {shared:.2f}): ' + (trouble or (
                'it must stand still, far off or where the camera turns on the spot, and the IMU '
                'must be rigid with the camera'))
        )
    values, vectors = np.linalg.eigh(covariance[:3, :3])
    if values[-1] > VAGUE_RAD**2:
        axis = 'xyz'[int(np.abs(vectors[:, -1]).argmax())]
        raise ImuError(
            f'the turn about {axis} of the camera is known to '
            f'{180.0 / pi * sqrt(values[-1]):.0f} degrees only: turn about two axes and more, nod '
            'and swing'
        )

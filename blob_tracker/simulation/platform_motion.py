"""How a vehicle turns: a boat, a rover or a drone, as linear processes whose limits are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
import scipy  # which loads linalg when it is first used

Array = NDArray[np.float64]
AXES = ('roll', 'pitch', 'yaw')
INTERVAL_S = 0.0025  # s between samples: a cubic between them errs by 1e-4 of a swing of 25 Hz


@dataclass(frozen=True)
class Swing:
    """
    One mode in which a vehicle turns about an axis: a resonance that is driven by coloured noise.

        x'' + 2 d w x' + w^2 x = u,    u' = -u / s + white noise,    w = 2 pi frequency

    The angular acceleration has no jumps, as no moment on a hull has; the jerk is white.

    Parameters
    ----------
    deviation : float
        Standard deviation of the angle, rad.
    frequency : float
        Of the resonance, undamped, Hz.
    damping : float
        d: part of the critical damping; a small one is a long swell, 0.5 and more is chop.
    smoothing : float
        s: time constant of what drives it, s.

    Examples
    --------
    A long swell, whose process has three states:

    >>> process = process_of([Swing(deviation=0.05, frequency=0.1, damping=0.1, smoothing=0.5)])
    >>> process.drift.shape
    (3, 3)

    """

    deviation: float
    frequency: float
    damping: float
    smoothing: float


class Process(NamedTuple):
    """
    A linear process x' = A x + noise, of which an angle and its rate are seen.

    Parameters
    ----------
    drift : (n, n) array
        A, 1/s.
    stationary : (n, n) array
        Covariance of the state after a long time.
    angle, rate : (n,) array
        Rows that take the state to the angle, rad, and its rate, rad/s.

    Examples
    --------
    How well the angle of a swell can be known 50 ms ahead of samples at 100 Hz, at best:

    >>> process = process_of([Swing(0.05, 0.1, 0.1, 0.5)])
    >>> limit = process.prediction_limit(0.05, interval=0.01, variance=1e-8)
    >>> 1e-6 < limit < 1e-3  # rad
    True

    """

    drift: Array
    stationary: Array
    angle: Array
    rate: Array

    def step(self, interval: float) -> tuple[Array, Array]:
        """
        Return the (n, n) transition F over an interval in s and the covariance that it adds.

        A process that is stationary stays so, P = F P F' + Q, and so Q = P - F P F'. It holds for
        any interval, where the usual exponential of both grows beyond all numbers.
        """
        transition = np.asarray(scipy.linalg.expm(interval * self.drift))
        return transition, self.stationary - transition @ self.stationary @ transition.T

    def prediction_limit(self, horizon: float, *, interval: float, variance: float) -> float:
        """
        Return the least rms error of a prediction of the angle: the motion's own limit, rad.

        It is that of the Kalman filter that knows the process, in its steady state: the solution
        of the discrete algebraic Riccati equation, carried over the horizon.

        Parameters
        ----------
        horizon : float
            Time from the last measurement to the instant that is predicted, s.
        interval : float
            Time between two measurements of the angle, s.
        variance : float
            Of a measurement, rad^2.

        """
        transition, added = self.step(interval)
        row = self.angle[:, None]
        prior = scipy.linalg.solve_discrete_are(
            transition.T, row, added, np.array([[variance]])
        )
        gain = prior @ row / (row.T @ prior @ row + variance)
        posterior = prior - gain @ row.T @ prior
        transition, added = self.step(horizon)
        return sqrt(float(self.angle @ (transition @ posterior @ transition.T + added)
                          @ self.angle))


def process_of(swings: Sequence[Swing]) -> Process:
    """
    Return the process of an axis: the sum of its swings, three states each.

    Examples
    --------
    Two swings of 0.03 rad and 0.04 rad are 0.05 rad together:

    >>> swings = [Swing(0.03, 0.1, 0.1, 0.5), Swing(0.04, 0.4, 0.5, 0.2)]
    >>> process = process_of(swings)
    >>> round(float(process.angle @ process.stationary @ process.angle) ** 0.5, 3)  # rad
    0.05

    """
    drifts, stationaries = [], []
    for swing in swings:
        turn = 2.0 * pi * swing.frequency
        drift = np.array([
            [0.0, 1.0, 0.0],
            [-turn**2, -2.0 * swing.damping * turn, 1.0],
            [0.0, 0.0, -1.0 / swing.smoothing],
        ])
        stationary = scipy.linalg.solve_continuous_lyapunov(drift, -np.diag([0.0, 0.0, 1.0]))
        drifts.append(drift)
        stationaries.append(swing.deviation**2 / stationary[0, 0] * stationary)
    return Process(
        scipy.linalg.block_diag(*drifts),
        scipy.linalg.block_diag(*stationaries),
        np.tile([1.0, 0.0, 0.0], len(swings)),
        np.tile([0.0, 1.0, 0.0], len(swings)),
    )


@dataclass(frozen=True)
class Shock:
    """
    A blow to the vehicle, as where its tool strikes a rock: a smooth pulse of moment.

    The vehicle turns under it and swings out:

        x'' + 2 d w x' + w^2 x = a (1 - cos(2 pi t / duration)) / 2,    0 <= t <= duration

    Parameters
    ----------
    time : float
        When it begins, s.
    acceleration : (float, float, float)
        a: greatest angular acceleration about roll, pitch and yaw, rad/s^2.
    duration : float
        Of the pulse, s.
    frequency : float
        With which the vehicle swings out, undamped, Hz.
    damping : float
        d: part of the critical damping, below 1.

    Examples
    --------
    Of a blow about pitch, of 2 rad/s^2: the angle before it and half a second after it began:

    >>> shock = Shock(time=1.0, acceleration=(0.0, 2.0, 0.0))
    >>> angles, _ = shock.swing(np.array([0.5, 1.5]))
    >>> [round(2.0 * angle, 3) for angle in angles.tolist()]  # rad
    [0.0, 0.064]

    """

    time: float
    acceleration: tuple[float, float, float]
    duration: float = 0.25
    frequency: float = 0.4
    damping: float = 0.25

    def swing(self, times: Array) -> tuple[Array, Array]:
        """Return the (n,) angle and rate at times in s, for an acceleration of 1 rad/s^2."""
        turn = 2.0 * pi * self.frequency
        pole = complex(-self.damping * turn, turn * sqrt(1.0 - self.damping**2))
        force = 2.0j * pi / self.duration
        since = times - self.time
        under = np.clip(since, 0.0, self.duration)
        # A half less a quarter of each of exp(+-force t), through 1 / (t - pole) and its
        # conjugate: the response of one exponential e^(f t) is (e^(f t) - e^(p t)) / (f - p).
        total = np.zeros(times.shape, dtype=complex)
        for weight, exponent in ((0.5, 0.0j), (-0.25, force), (-0.25, -force)):
            total += weight * (np.exp(exponent * under) - np.exp(pole * under)) / (exponent - pole)
        total *= np.exp(pole * np.maximum(since - self.duration, 0.0))
        # x = Im(z) / Im(p) and x' = Im(p z) / Im(p) solve x'' = ... where z' = p z + moment.
        return total.imag / pole.imag, (pole * total).imag / pole.imag


class Ride:
    """
    How a vehicle has turned: its attitude and its rate at any time.

    The base's axes are those of an optical frame, x right, y down, z forward, and at rest those
    of the level frame. It is turned by yaw about y, then pitch about x, then roll about z, each
    right-handed about its own, turned axis: to the right, bow up, and to the right side down.

    Parameters
    ----------
    interval : float
        Time between two samples, s; the first is at 0.
    angles : (n, 3) array
        Roll, pitch and yaw, rad.
    rates : (n, 3) array
        Their derivatives, rad/s.

    Examples
    --------
    A base that yaws to the right at 0.1 rad/s:

    >>> times = 0.01 * np.arange(101)
    >>> angles = np.stack([0.0 * times, 0.0 * times, 0.1 * times], axis=1)
    >>> ride = Ride(0.01, angles, np.tile([0.0, 0.0, 0.1], (101, 1)))
    >>> ride.rates(np.array([0.5])).round(3).tolist()  # rad/s
    [[0.0, 0.1, 0.0]]

    """

    def __init__(self, interval: float, angles: Array, rates: Array) -> None:
        times = interval * np.arange(len(angles))
        self.duration = float(times[-1])
        self._angles = scipy.interpolate.CubicHermiteSpline(times, angles, rates)
        self._rates = self._angles.derivative()

    def angles(self, times: Array) -> Array:
        """Return (n, 3) roll, pitch and yaw at (n,) times in s, rad."""
        return np.asarray(self._angles(times))

    def rotations(self, times: Array) -> Array:
        """Return (n, 3, 3) rotations that take components in the base to the level frame."""
        roll, pitch, yaw = self.angles(np.atleast_1d(times)).T
        return turn_about(1, yaw) @ turn_about(0, pitch) @ turn_about(2, roll)

    def rates(self, times: Array) -> Array:
        """Return the (n, 3) angular velocity as a gyro on the base has it: x, y, z, rad/s."""
        times = np.atleast_1d(times)
        roll, pitch, _ = self.angles(times).T
        roll_rate, pitch_rate, yaw_rate = np.asarray(self._rates(times)).T
        # Each axis seen from the base, behind the turns that follow it.
        by_roll = turn_about(2, -roll)
        by_both = by_roll @ turn_about(0, -pitch)
        rates = yaw_rate[:, None] * by_both[:, :, 1] + pitch_rate[:, None] * by_roll[:, :, 0]
        rates[:, 2] += roll_rate
        return np.asarray(rates)


def turn_about(axis: int, angles: Array) -> Array:
    """
    Return (n, 3, 3) right-handed rotations about axis 0, 1 or 2 by (n,) angles, rad.

    Examples
    --------
    A quarter about z takes x to y:

    >>> (turn_about(2, np.array([np.pi / 2.0])) @ [1.0, 0.0, 0.0]).round(3).tolist()
    [[0.0, 1.0, 0.0]]

    """
    second, third = (axis + 1) % 3, (axis + 2) % 3
    turns = np.zeros((*np.shape(angles), 3, 3))
    turns[..., axis, axis] = 1.0
    turns[..., second, second] = turns[..., third, third] = np.cos(angles)
    turns[..., third, second] = np.sin(angles)
    turns[..., second, third] = -turns[..., third, second]
    return turns


@dataclass(frozen=True)
class PlatformMotion:
    """
    How a vehicle turns about its axes.

    Parameters
    ----------
    roll, pitch, yaw : tuple of Swing
        What adds up to the angle about each axis.
    shocks : tuple of Shock
        Blows that come on top.

    Examples
    --------
    A boat that rolls by 0.1 rad, and does little else:

    >>> roll, other = Swing(0.1, 0.15, 0.1, 0.5), Swing(0.01, 0.3, 0.3, 0.3)
    >>> boat = PlatformMotion((roll,), (other,), (other,))
    >>> ride = boat.ride(61.0, seed=1)
    >>> ride.angles(np.arange(0.0, 60.0, 0.1)).std(axis=0).round(1).tolist()  # rad
    [0.1, 0.0, 0.0]

    """

    roll: tuple[Swing, ...]
    pitch: tuple[Swing, ...]
    yaw: tuple[Swing, ...]
    shocks: tuple[Shock, ...] = ()

    def process(self, axis: str) -> Process:
        """Return the process of an axis, one of `AXES`; the shocks are not in it."""
        return process_of(getattr(self, axis))

    def scaled(self, factor: float) -> PlatformMotion:
        """Return the motion with all angles, and the shocks, so many times as large."""
        roll, pitch, yaw = (
            tuple(replace(each, deviation=factor * each.deviation) for each in getattr(self, axis))
            for axis in AXES
        )
        shocks = tuple(
            replace(each, acceleration=(factor * about_roll, factor * about_pitch,
                                        factor * about_yaw))
            for each in self.shocks for about_roll, about_pitch, about_yaw in [each.acceleration]
        )
        return PlatformMotion(roll, pitch, yaw, shocks)

    def ride(self, duration: float, seed: int, interval: float = INTERVAL_S) -> Ride:
        """
        Draw a ride: exact at the samples, from a start that is as likely as any.

        Parameters
        ----------
        duration : float
            s.
        seed : int
            The same one gives the same ride.
        interval : float
            Between two samples, s.

        """
        random = np.random.default_rng([seed, 5])
        count = int(np.ceil(duration / interval)) + 1
        angles, rates = np.zeros((count, 3)), np.zeros((count, 3))
        for column, axis in enumerate(AXES):
            process = self.process(axis)
            angles[:, column], rates[:, column] = _drawn(process, count, interval, random)
        times = np.linspace(0.0, interval * (count - 1), count)
        for shock in self.shocks:
            angle, rate = shock.swing(times)
            angles += angle[:, None] * shock.acceleration
            rates += rate[:, None] * shock.acceleration
        return Ride(interval, angles, rates)


def _drawn(
    process: Process, count: int, interval: float, random: np.random.Generator
) -> tuple[Array, Array]:
    """Return (count,) angles and rates of one realisation."""
    transition, added = process.step(interval)
    state = _root(process.stationary) @ random.standard_normal(len(transition))
    noise = random.standard_normal((count, len(transition))) @ _root(added).T
    states = np.empty_like(noise)
    for index in range(count):
        states[index] = state
        state = transition @ state + noise[index]
    return states @ process.angle, states @ process.rate


def _root(covariance: Array) -> Array:
    """Return a matrix whose product with its transpose is the covariance, singular or not."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


DEGREE_RAD = pi / 180.0
# A work boat of 10 m in the wind sea of a lake: 8 m/s of wind over 5 km make waves of 0.29 m and
# 2.1 s (JONSWAP: Hasselmann et al. 1973), whose slope is 3.7 degrees rms. The beam follows it and
# the length averages it. The last swing is the engine's: see docs/servo.md for all numbers.
ENGINE = Swing(1.06e-5, 25.0, 0.02, 0.002)
MOTIONS = {
    'sea': PlatformMotion(
        roll=(Swing(3.0 * DEGREE_RAD, 0.40, 0.10, 0.25), ENGINE),
        pitch=(Swing(1.5 * DEGREE_RAD, 0.45, 0.25, 0.3), ENGINE),
        yaw=(Swing(1.5 * DEGREE_RAD, 0.17, 0.30, 0.6), ENGINE),
    ),
    # Four wheels on a track, at a walk: the suspension's modes, and steering.
    'rover': PlatformMotion(
        roll=(Swing(1.2 * DEGREE_RAD, 1.5, 0.3, 0.03), Swing(2.0 * DEGREE_RAD, 0.2, 0.5, 0.2)),
        pitch=(Swing(1.0 * DEGREE_RAD, 1.8, 0.3, 0.03), Swing(2.0 * DEGREE_RAD, 0.2, 0.5, 0.2)),
        yaw=(Swing(0.3 * DEGREE_RAD, 1.5, 0.3, 0.03), Swing(4.0 * DEGREE_RAD, 0.15, 0.7, 0.3)),
    ),
    # A quadcopter that holds its place in gusts: its attitude loop, and its rotors.
    'drone': PlatformMotion(
        roll=(Swing(2.0 * DEGREE_RAD, 0.8, 0.5, 0.05), Swing(5e-5, 60.0, 0.05, 0.001)),
        pitch=(Swing(2.0 * DEGREE_RAD, 0.8, 0.5, 0.05), Swing(5e-5, 60.0, 0.05, 0.001)),
        yaw=(Swing(1.5 * DEGREE_RAD, 0.4, 0.7, 0.1), Swing(2e-5, 60.0, 0.05, 0.001)),
    ),
}

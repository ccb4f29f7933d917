"""A pan/tilt: it answers late, lags behind, and turns no faster than its motors can."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import cos, exp, isfinite, sin, sqrt, tau

import numpy as np
from numpy.typing import NDArray
import scipy  # which loads interpolate when it is first used

Array = NDArray[np.float64]

BRAKE = 0.6  # of the acceleration, with which a long way ends: the rest is for the loop
STEP_S = 0.002  # s: within it the motors' limits hold on the mean
KEPT_S = 0.05  # s of the past that is known: longer than exposure and readout together


@dataclass(frozen=True)
class Joints:
    """
    What both joints of a pan/tilt can do.

    Each follows its command c as a position loop does,

        x'' = w^2 (c - x) - 2 d w x',    w = 2 pi frequency

    with x' and x'' held within `rate` and `acceleration`; where they are reached it brakes in
    time, as the controllers of such units do. Behind a steady command it lags by `lag`.

    Parameters
    ----------
    delay : float
        Time from the sending of a command to the motors, s.
    frequency : float
        Of the position loop, undamped, Hz.
    damping : float
        d: part of the critical damping, above 0 and below 1.
    rate : float
        rad/s.
    acceleration : float
        rad/s^2.
    resolution : float
        Step of the encoders, rad: of what is commanded and of what is reported; 0 for none.

    Raises
    ------
    ValueError
        If one of them is invalid.

    Examples
    --------
    How late a joint is that follows a steady command, ms:

    >>> round(1e3 * Joints(frequency=15.0, damping=0.8).lag)
    17

    """

    delay: float = 0.02
    frequency: float = 15.0
    damping: float = 0.8
    rate: float = 1.75
    acceleration: float = 10.0
    resolution: float = 0.0

    def __post_init__(self) -> None:
        for name in ('frequency', 'rate', 'acceleration'):
            if not getattr(self, name) > 0.0:
                raise ValueError(f'{name} is {getattr(self, name):g}; it must be above 0')
        for name in ('delay', 'resolution'):
            if not (isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise ValueError(f'{name} is {getattr(self, name):g}; it must be 0 or more')
        if not 0.0 < self.damping < 1.0:
            raise ValueError(f'damping is {self.damping:g}; it must be above 0 and below 1')

    @property
    def lag(self) -> float:
        """Time by which a joint is behind a command that moves steadily, 2 d / w, s."""
        return 2.0 * self.damping / (tau * self.frequency)


class PanTilt:
    """
    A pan/tilt that is driven through time.

    Parameters
    ----------
    joints : Joints
        What it can do.
    pan, tilt : float
        Where it stands at the time 0, rad: to the right and up.

    Attributes
    ----------
    time : float
        Up to which it has been driven, s.
    angles : (float, float)
        Where pan and tilt truly are at that time, rad.

    Examples
    --------
    A command of 0.2 rad, before the delay is over and half a second later:

    >>> pan_tilt = PanTilt(Joints(delay=0.02))
    >>> pan_tilt.command(0.2, 0.0)
    >>> for time in (0.01, 0.5):
    ...     pan_tilt.advance(time)
    ...     print(round(pan_tilt.angles[0], 3))  # rad
    0.0
    0.2

    """

    def __init__(self, joints: Joints, pan: float = 0.0, tilt: float = 0.0) -> None:
        self.joints = joints
        self.time = 0.0
        self.angles = (pan, tilt)
        self._rates = (0.0, 0.0)
        self._goal = (pan, tilt)
        self._goal_since = self._goal_until = 0.0
        self._goal_rates = (0.0, 0.0)
        self._underway: deque[tuple[float, tuple[float, float]]] = deque()
        self._past = deque([(self.time, *self.angles, *self._rates)])

    def command(self, pan: float | None, tilt: float | None) -> None:
        """
        Send the angles to go to, rad; the motors get them after the delay.

        None is for a joint that is to go on to where it was sent.

        Raises
        ------
        ValueError
            If one of them is no number.

        """
        former = self._underway[-1][1] if self._underway else self._goal
        pan, tilt = former[0] if pan is None else pan, former[1] if tilt is None else tilt
        if not (isfinite(pan) and isfinite(tilt)):
            raise ValueError(f'the command is {pan}, {tilt} rad; both must be finite')
        goal = (self._rounded(pan), self._rounded(tilt))
        self._underway.append((self.time + self.joints.delay, goal))

    def reported(self) -> tuple[float, float]:
        """Return what the encoders read at this time, rad."""
        pan, tilt = self.angles
        return self._rounded(pan), self._rounded(tilt)

    def at(self, times: Array) -> Array:
        """
        Return where pan and tilt were, cubics through angles and rates of the steps.

        Parameters
        ----------
        times : (n,) array
            From the last `KEPT_S` s, to which it has been driven, s.

        Returns
        -------
        (n, 2) array
            rad.

        Raises
        ------
        ValueError
            If a time is not of them.

        """
        past = np.array(self._past)
        if not past[0, 0] <= np.min(times) <= np.max(times) <= self.time:
            raise ValueError(
                f'times are from {np.min(times):g} to {np.max(times):g} s; known are '
                f'{past[0, 0]:g} to {self.time:g} s: drive it up to the last one, and ask before '
                f'the first is {KEPT_S:g} s ago'
            )
        if len(past) == 1:
            return np.tile(past[0, 1:3], (len(times), 1))
        return np.asarray(scipy.interpolate.CubicHermiteSpline(
            past[:, 0], past[:, 1:3], past[:, 3:]
        )(times))

    def advance(self, time: float) -> None:
        """Drive it up to a time in s; what was sent early enough is obeyed on the way."""
        while self.time < time:
            while self._underway and self._underway[0][0] <= self.time + 1e-12:
                self._obey(*self._underway.popleft())
            until = min(time, self.time + STEP_S)
            if self._underway:
                until = min(until, self._underway[0][0])
            if self.time > self._goal_until:
                self._goal_rates = (0.0, 0.0)
            self._step(until - self.time)
            self.time = until
            self._past.append((until, *self.angles, *self._rates))
            while self._past[1][0] <= until - KEPT_S:
                self._past.popleft()

    def _obey(self, arrival: float, goal: tuple[float, float]) -> None:
        """Take a command, and how fast commands move: a leap is no motion, nor is the last one."""
        elapsed, most = arrival - self._goal_since, self.joints.rate
        pan_rate, tilt_rate = (
            (new - old) / elapsed if abs(new - old) < most * elapsed else 0.0
            for old, new in zip(self._goal, goal)
        )
        self._goal, self._goal_since, self._goal_rates = goal, arrival, (pan_rate, tilt_rate)
        self._goal_until = arrival + 2.0 * elapsed

    def _step(self, interval: float) -> None:
        """Move both joints by an interval in which the command stands."""
        joints = self.joints
        turn = tau * joints.frequency
        fade = joints.damping * turn
        own = turn * sqrt(1.0 - joints.damping**2)
        decay = exp(-fade * interval)
        cosine, sine = decay * cos(own * interval), decay * sin(own * interval) / own
        moved = []
        for angle, rate, goal, along in zip(
            self.angles, self._rates, self._goal, self._goal_rates
        ):
            away = angle - goal
            after = away * (cosine + fade * sine) + rate * sine
            speed = rate * (cosine - fade * sine) - away * turn**2 * sine
            most = joints.acceleration * interval
            if abs(speed - rate) > most or abs(speed) > joints.rate:
                # Not faster than can be braked in time, to the speed of the commands.
                top = sqrt(2.0 * BRAKE * joints.acceleration * abs(away))
                speed = min(max(speed, along - top, -joints.rate), along + top, joints.rate)
                speed = min(max(speed, rate - most), rate + most)
                after = away + 0.5 * (rate + speed) * interval
            moved.append((goal + after, speed))
        (pan, pan_rate), (tilt, tilt_rate) = moved
        self.angles, self._rates = (pan, tilt), (pan_rate, tilt_rate)

    def _rounded(self, angle: float) -> float:
        """Return the nearest angle that the encoder has."""
        step = self.joints.resolution
        return step * round(angle / step) if step else angle

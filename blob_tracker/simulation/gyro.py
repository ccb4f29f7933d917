"""A gyro on a vehicle: what it makes of a ride."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

from blob_tracker.simulation.platform_motion import Ride
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Gyro:
    """
    Three axes of a MEMS gyro.

    A sample is the mean of the angular velocity over the interval up to the next one.

    Parameters
    ----------
    rate : float
        Samples a second.
    noise : float
        Rate noise density, rad/s/sqrt(Hz).
    bias : float
        Of each axis, of either sign, rad/s.
    scale : float
        Error of the scale, a part of the rate.
    turn : float
        Error of its mounting: a small turn about each axis, of either sign, rad.

    Raises
    ------
    ValueError
        If one of them is invalid.

    """

    rate: float = 200.0
    noise: float = 1.4e-4
    bias: float = 2e-3
    scale: float = 0.003
    turn: float = 0.005

    def __post_init__(self) -> None:
        if not (self.rate > 0.0 and isfinite(self.rate)):
            raise ValueError(f'rate is {self.rate:g} samples a second; it must be above 0')
        if not (self.noise >= 0.0 and isfinite(self.noise)):
            raise ValueError(f'noise is {self.noise:g} rad/s/sqrt(Hz); it must be 0 or more')

    @property
    def variance(self) -> float:
        """Of the noise of a sample, (rad/s)^2: that of the density up to half the rate."""
        return 0.5 * self.noise**2 * self.rate

    def samples(
        self, ride: Ride, duration: float, random: np.random.Generator
    ) -> tuple[Array, Array]:
        """
        Draw what it says of a ride.

        Parameters
        ----------
        ride : Ride
            How the vehicle turns.
        duration : float
            s.
        random : Generator
            Of noise, and of the signs.

        Returns
        -------
        (n,) array
            Middles of the samples, s: half an interval before they end.
        (n, 3) array
            Angular velocity in the base's axes, rad/s.

        """
        interval, count = 1.0 / self.rate, int(duration * self.rate)
        ends = np.linspace(interval, interval * count, count)
        middles = ends - 0.5 * interval
        # Simpson's rule.
        first, second, third = (ride.rates(each) for each in (ends - interval, middles, ends))
        mean: Array = (first + 4.0 * second + third) / 6.0
        x, y, z = self.turn * random.choice([-1.0, 1.0], 3)
        mounted = np.array([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]])
        bias = self.bias * random.choice([-1.0, 1.0], 3)
        noise = sqrt(self.variance) * random.standard_normal(mean.shape)
        rates: Array = (1.0 + self.scale) * mean @ mounted.T + bias + noise
        return np.asarray(middles), rates

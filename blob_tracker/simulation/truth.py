"""What is known of a simulated frame."""

from __future__ import annotations

from math import nan
from typing import NamedTuple


class Truth(NamedTuple):
    """
    The light in a frame; NaN if there is none.

    Parameters
    ----------
    x, y : float
        Its centre of gravity, px. With a rolling shutter it is that of the moment at which the
        row that it lies in is exposed; where it leaves a streak, that of the moment at which it
        was seen.
    lit : bool
        Whether it is on for half of that exposure, or more.
    amplitude : float
        Its peak above what is behind it, DN, on the mean of the exposure: before the pixels take
        their means, and before the sensor.
    sigma : float
        Its size, px: that of a Gaussian, see `profiles` for others.
    tau : float
        When it was seen, from the middle of the exposure, s; 0 where it leaves no streak.

    Examples
    --------
    Where a light was, and that it was off:

    >>> truth = Truth(319.4, 240.2, lit=False, amplitude=150.0, sigma=2.0)
    >>> truth.lit, truth.x
    (False, 319.4)

    """

    x: float
    y: float
    lit: bool
    amplitude: float = nan
    sigma: float = nan
    tau: float = 0.0

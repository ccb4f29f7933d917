"""A texture behind the light that is not the same in the lit frame and in the unlit one."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.noise import noise_of_sum, variance_at
from blob_tracker.types import Location, SensorNoise, Window
import numpy as np

MEMORY = 128.0  # windows that were looked at, after which one weighs 1/e
FEWEST_WINDOWS = 16  # before anything is said
ENOUGH_WINDOWS, EVERY = 128, 16  # beyond so many windows only every sixteenth is looked at
FEWEST_PX = 24  # px about the light, that a correlation takes
REACH = 3.0  # sigma about the light, that are left out of it
SIGMAS = 3.0  # standard deviations, beyond which there is a texture
MOVING_SIGMAS = 3.0  # beyond which it moves; what chance makes of it grows little
LEAST_GROWTH = 1.3  # of the variance: what grows it less is not spoken of


class MovingTexture:
    """
    Measure how much of the texture behind a light the unlit frame knows.

    The fit takes a share kappa = r / (1 + r) of the unlit texture off the lit pixels, r the power
    of the texture at the scale of the pulse over that of the noise: the mean square of what the
    unlit window lends to the place of a pulse is 1 + r. If the texture is the same in both
    frames the variance of the place is 1 + kappa times that of the lit frame alone. If the two
    have the correlation rho, as camera or background move in between, it is

        V = 1 + r + kappa^2 (1 + r) - 2 kappa rho r

    and the covariance grows by V / (1 + kappa). rho is that of the pixels about the light.

    Attributes
    ----------
    growth : float
        Of the covariance; 1 if there is no such texture, or not known yet.

    """

    def __init__(self) -> None:
        self.growth = 1.0
        self._windows = 0
        # Of the windows that were looked at, weighted: count; sum of squares at the scale of the
        # pulse over their noise; pixels; lit times unlit; unlit squared less noise; its variance.
        self._sums = np.zeros(6)

    @property
    def warning(self) -> str:
        """Say that the background moves; '' where it does not."""
        if self.growth == 1.0:
            return ''
        return (
            'the texture behind the light moves between the lit and the unlit frame, and its '
            f'position is {math.sqrt(self.growth):.1f} times as uncertain: hold the camera still, '
            'set registration, or raise the frame rate'
        )

    def add(self, window: Window, location: Location, noise: SensorNoise) -> None:
        """
        Take the next window.

        Parameters
        ----------
        window : Window
            Lit and unlit pixels, DN.
        location : Location
            Of its light. One with a warning is left aside: its light may be in both.
        noise : SensorNoise
            Of a pixel of one frame.

        """
        self._windows += 1
        if (
            window.unlit is None or window.added_noise > 0.0 or location.warning
            or (self._windows > ENOUGH_WINDOWS and self._windows % EVERY)
        ):
            return
        noise = noise_of_sum(noise, window.looks)
        level, lent, count, product, square = _told(
            np.ascontiguousarray(window.lit, dtype=float),
            np.ascontiguousarray(window.unlit, dtype=float),
            math.inf if window.saturation is None else float(window.saturation),
            window.to_window(location.x, location.y), location.sigma,
        )
        if count < FEWEST_PX:
            return
        variance = variance_at(level, noise)
        self._sums *= 1.0 - 1.0 / MEMORY
        self._sums += (
            1.0, 0.5 * lent / variance, count, product, square - count * variance,
            2.0 * variance * max(square, count * variance),
        )
        self._judge()

    def _judge(self) -> None:
        """Set the growth by the sums."""
        self.growth = 1.0
        windows, squares, _, products, texture, deviation = (float(each) for each in self._sums)
        if windows < FEWEST_WINDOWS:
            return
        power = squares / windows - 1.0
        # Each window gives the mean of two chi-squares.
        if power < SIGMAS * (1.0 + power) / math.sqrt(windows):
            return
        sigma = math.sqrt(deviation)
        if texture < SIGMAS * sigma:
            return
        known = min(max(products / texture, 0.0), 1.0)
        if 1.0 - known < MOVING_SIGMAS * sigma / texture:
            return
        share = power / (1.0 + power)
        total = 1.0 + power + share**2 * (1.0 + power) - 2.0 * share * known * power
        growth = total / (1.0 + share)
        if growth > LEAST_GROWTH:
            self.growth = growth

    def doubted(self, location: Location) -> Location:
        """Return a location with the covariance that it has before such a texture."""
        if self.growth == 1.0:
            return location
        return replace(location, covariance=self.growth * location.covariance)


def compile_texture() -> None:
    """Compile what looks at the windows, or load it."""
    picture = np.arange(49.0).reshape(7, 7)
    _told(picture, picture, math.inf, (3.0, 3.0), 1.0)


@kernel
def _told(
    lit: Array, unlit: Array, limit: float, middle: tuple[float, float], sigma: float
) -> tuple[float, float, int, float, float]:
    """
    Return what a window tells of the texture behind a light.

    Returns
    -------
    tuple
        Mean of the unlit pixels, DN; what their departures from it lend to the place of a pulse,
        squared, DN^2; how many pixels there are about the light; and of these the sums of lit
        times unlit and of unlit squared, both without their means, DN^2.

    """
    height, width = lit.shape
    total, usable = 0.0, 0
    one, other, count = 0.0, 0.0, 0
    for j in range(height):
        for i in range(width):
            if lit[j, i] < limit and unlit[j, i] < limit:
                total += unlit[j, i]
                usable += 1
                dx, dy = i - middle[0], j - middle[1]
                if (dx * dx + dy * dy) / (sigma * sigma) > REACH * REACH:
                    one += lit[j, i]
                    other += unlit[j, i]
                    count += 1
    if count < FEWEST_PX:
        return 0.0, 0.0, count, 0.0, 0.0
    mean, one, other = total / usable, one / count, other / count
    along, across, along_square, across_square = 0.0, 0.0, 0.0, 0.0
    product, square = 0.0, 0.0
    for j in range(height):
        for i in range(width):
            if lit[j, i] < limit and unlit[j, i] < limit:
                dx, dy = i - middle[0], j - middle[1]
                squares = (dx * dx + dy * dy) / (sigma * sigma)
                pulse = math.exp(-0.5 * squares)
                along += dx * pulse * (unlit[j, i] - mean)
                across += dy * pulse * (unlit[j, i] - mean)
                along_square += (dx * pulse) ** 2
                across_square += (dy * pulse) ** 2
                if squares > REACH * REACH:
                    product += (lit[j, i] - one) * (unlit[j, i] - other)
                    square += (unlit[j, i] - other) ** 2
    lent = along * along / max(along_square, 1e-12) + across * across / max(across_square, 1e-12)
    return mean, lent, count, product, square

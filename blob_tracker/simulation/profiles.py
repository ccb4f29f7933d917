"""The shape of a light's image: round, elliptical, the thesis' lamp, comatic, or measured."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from blob_tracker.simulation.light import (
    pixel_integrated_gaussian, Place, REACH_SIGMA, rotated_gaussian,
)
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads its parts when they are first used

# The lamp of the thesis (section 4.3.2, eq. 4.35): peaks, DN, and s over the least s. They are
# those of location/multi_gaussian.py, which a simulator would load the compiler for.
LAMP_AMPLITUDES = (154.25, 77.68, 22.07)
LAMP_WIDTHS = (1.0, 2.57, 4.97)


class Profile(Protocol):
    """
    A shape without a size: lengths are in the sigma of the light that has it.

    Its highest value is 1, and its centre of gravity, where the truth of a light is, lies at 0.
    """

    @property
    def reach(self) -> float:
        """Distance beyond which nothing is drawn, sigma."""

    @property
    def peak(self) -> tuple[float, float]:
        """Where its highest value is from its centre of gravity, x and y, sigma."""

    def over_pixels(
        self, shape: tuple[int, int], x: Place, y: Place, sigma: float, aperture: float = 1.0
    ) -> NDArray[np.float64]:
        """Return the (h, w) means over the pixels, see `pixel_integrated_gaussian`."""


@dataclass(frozen=True)
class Gaussian:
    """
    A Gaussian, round or elliptical.

    Parameters
    ----------
    axis_ratio : float
        Long over short axis; the light's sigma is the geometric mean of both.
    angle : float
        Of the long axis, from x towards y, rad.

    Examples
    --------
    An ellipse, twice as long as it is wide, along x:

    >>> pixels = Gaussian(axis_ratio=2.0).over_pixels((21, 21), 10.0, 10.0, 2.0)
    >>> round(float(pixels[10, 12]), 2), round(float(pixels[12, 10]), 2)
    (0.76, 0.37)

    """

    axis_ratio: float = 1.0
    angle: float = 0.0
    peak = (0.0, 0.0)

    @property
    def reach(self) -> float:
        """Distance beyond which nothing is drawn, sigma."""
        return REACH_SIGMA * self.axis_ratio**0.5

    def over_pixels(
        self, shape: tuple[int, int], x: Place, y: Place, sigma: float, aperture: float = 1.0
    ) -> NDArray[np.float64]:
        """Return the (h, w) means over the pixels, see `pixel_integrated_gaussian`."""
        stretch = self.axis_ratio**0.5
        along, across = sigma * stretch, sigma / stretch
        if self.axis_ratio == 1.0 or self.angle == 0.0:
            return pixel_integrated_gaussian(shape, x, y, along, across, aperture=aperture)
        return rotated_gaussian(shape, x, y, along, across, self.angle, aperture=aperture)


@dataclass(frozen=True)
class ThreeGaussians:
    """
    The lamp behind a screen of the thesis: three Gaussians about one centre (eq. 4.35).

        f = 154.25 exp(-r^2 / s^2) + 77.68 exp(-(r / 2.57 s)^2) + 22.07 exp(-(r / 4.97 s)^2)

    A light of the amplitude 254.00 DN has these peaks. The thesis' width s has no 2 in the
    exponent: s = sqrt2 sigma, with sigma that of the light and of the narrowest of the three.

    Examples
    --------
    Five sigma off its middle it is far brighter than a Gaussian, which has 4e-6 there:

    >>> pixels = ThreeGaussians().over_pixels((1, 31), 10.0, 0.0, 2.0)
    >>> round(float(pixels[0, 20]), 2)
    0.1

    """

    reach = REACH_SIGMA * LAMP_WIDTHS[-1]
    peak = (0.0, 0.0)

    def over_pixels(
        self, shape: tuple[int, int], x: Place, y: Place, sigma: float, aperture: float = 1.0
    ) -> NDArray[np.float64]:
        """Return the (h, w) means over the pixels, see `pixel_integrated_gaussian`."""
        picture = np.zeros(shape)
        for amplitude, width in zip(LAMP_AMPLITUDES, LAMP_WIDTHS, strict=True):
            picture += amplitude / sum(LAMP_AMPLITUDES) * pixel_integrated_gaussian(
                shape, x, y, width * sigma, aperture=aperture
            )
        return picture


@dataclass(frozen=True)
class Comatic:
    """
    A spot with a tail, as a lens draws it off its axis: Gaussians in a row that grow and fade.

    Number k of the four has 2^-k times the height of the first, stands k coma from it, and is
    1 + k coma / 2 times as wide.

    Parameters
    ----------
    coma : float
        Step from one to the next, sigma; 0 gives the round Gaussian.
    angle : float
        Of the tail, from x towards y, rad.

    Examples
    --------
    The highest value of a spot whose tail goes along x is off its centre of gravity:

    >>> round(Comatic(coma=1.0).peak[0], 1)  # sigma
    -1.1

    """

    coma: float = 1.0
    angle: float = 0.0

    @cached_property
    def _pulses(self) -> NDArray[np.float64]:
        """(4, 3) heights, places along the tail from the centre of gravity, and widths, sigma."""
        steps = np.arange(4)
        heights, places, widths = 0.5**steps, self.coma * steps, 1.0 + 0.5 * self.coma * steps
        light = heights * widths**2
        pulses = np.stack([heights, places - (light @ places) / light.sum(), widths], axis=1)
        pulses[:, 0] /= self._along(pulses, self._highest(pulses))
        return pulses

    @staticmethod
    def _along(pulses: NDArray[np.float64], place: float) -> float:
        """Return the sum of the pulses at a place on the tail's axis."""
        heights, places, widths = pulses.T
        return float(heights @ np.exp(-0.5 * ((place - places) / widths) ** 2))

    def _highest(self, pulses: NDArray[np.float64]) -> float:
        """Return where on the axis the sum has its maximum."""
        found = scipy.optimize.minimize_scalar(
            lambda place: -self._along(pulses, place),
            bounds=(pulses[0, 1] - 0.1, pulses[-1, 1] + 0.1),
            method='bounded',
            options={'xatol': 1e-9},
        )
        return float(found.x)

    @property
    def reach(self) -> float:
        """Distance beyond which nothing is drawn, sigma."""
        _, places, widths = self._pulses.T
        return float((np.abs(places) + REACH_SIGMA * widths).max())

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Where its highest value is from its centre of gravity, x and y, sigma."""
        place = self._highest(self._pulses)
        return place * float(np.cos(self.angle)), place * float(np.sin(self.angle))

    def over_pixels(
        self, shape: tuple[int, int], x: Place, y: Place, sigma: float, aperture: float = 1.0
    ) -> NDArray[np.float64]:
        """Return the (h, w) means over the pixels, see `pixel_integrated_gaussian`."""
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        picture = np.zeros(shape)
        for height, place, width in self._pulses:
            picture += height * pixel_integrated_gaussian(
                shape,
                x + sigma * place * cosine,
                y + sigma * place * sine,
                sigma * width,
                aperture=aperture,
            )
        return picture


@dataclass(frozen=True, eq=False)
class Measured:
    """
    A spot that was measured: a picture of it with many elements to a pixel.

    Each element is the mean over its area, so that the running sum of the elements is the
    integral of the spot at their borders. Between them it is a cubic spline, and a pixel is the
    difference of the integral at its four corners: whatever the scale, no light is lost.

    Parameters
    ----------
    picture : (n, m) array
        The spot without its background, of any unit; it falls to 0 at the border.
    elements : float
        Elements of the picture to one sigma of the light.

    Raises
    ------
    ValueError
        If the picture has no light in it, or fewer than 4 elements to a side.

    Examples
    --------
    A spot from a picture with four elements to a sigma:

    >>> y, x = np.mgrid[-20:21, -20:21] / 4.0
    >>> spot = Measured(np.exp(-0.5 * (x**2 + y**2)), elements=4.0)
    >>> pixels = spot.over_pixels((15, 15), 7.0, 7.0, 1.5)
    >>> round(float(pixels.sum() / (2.0 * np.pi * 1.5**2)), 2)  # all of its light
    1.0

    """

    picture: NDArray[np.float64]
    elements: float

    def __post_init__(self) -> None:
        if np.ndim(self.picture) != 2 or min(np.shape(self.picture)) < 4:
            raise ValueError(
                f'a measured spot is a picture of 4 x 4 elements or more, not of the shape '
                f'{np.shape(self.picture)}'
            )
        if not (np.isfinite(self.picture).all() and np.sum(self.picture) > 0.0):
            raise ValueError('a measured spot must be finite and brighter than its background')
        if not self.elements > 0.0:
            raise ValueError(f'{self.elements} elements to a sigma; it must be above 0')

    @cached_property
    def _integral(self) -> scipy.interpolate.RectBivariateSpline:
        """From y and x in elements from the first corner to the light above and left of it."""
        height, width = np.shape(self.picture)
        sums = np.zeros((height + 1, width + 1))
        sums[1:, 1:] = np.cumsum(np.cumsum(self.picture, axis=0), axis=1) / np.max(self.picture)
        return scipy.interpolate.RectBivariateSpline(
            np.arange(height + 1), np.arange(width + 1), sums
        )

    @cached_property
    def _centre(self) -> tuple[float, float]:
        """Centre of gravity, x and y, elements from the first corner."""
        rows, columns = np.indices(np.shape(self.picture)) + 0.5
        light = self.picture / np.sum(self.picture)
        return float((light * columns).sum()), float((light * rows).sum())

    @property
    def reach(self) -> float:
        """Distance beyond which nothing is drawn, sigma."""
        height, width = np.shape(self.picture)
        x, y = self._centre
        return max(x, width - x, y, height - y) / self.elements

    @property
    def peak(self) -> tuple[float, float]:
        """Middle of its highest element from its centre of gravity, x and y, sigma."""
        row, column = np.unravel_index(np.argmax(self.picture), np.shape(self.picture))
        x, y = self._centre
        return (float(column) + 0.5 - x) / self.elements, (float(row) + 0.5 - y) / self.elements

    def over_pixels(
        self, shape: tuple[int, int], x: Place, y: Place, sigma: float, aperture: float = 1.0
    ) -> NDArray[np.float64]:
        """Return the (h, w) means over the pixels, see `pixel_integrated_gaussian`."""
        height, width = np.shape(self.picture)
        scale = self.elements / sigma  # elements to a pixel
        half = 0.5 * max(aperture, 1e-3)  # a point is a small square
        columns = np.arange(shape[1]) - np.reshape(x, (-1, 1))
        rows = (np.arange(shape[0]) - y)[:, None]
        left, right = (
            np.clip(self._centre[0] + scale * (columns + side), 0, width) for side in (-half, half)
        )
        above, below = (
            np.clip(self._centre[1] + scale * (rows + side), 0, height) for side in (-half, half)
        )
        light = (
            self._integral(below, right, grid=False) - self._integral(above, right, grid=False)
            - self._integral(below, left, grid=False) + self._integral(above, left, grid=False)
        )
        return np.asarray(light / (2.0 * half * scale) ** 2)


PROFILES: dict[str, Profile] = {
    'gaussian': Gaussian(), 'three_gaussians': ThreeGaussians(), 'comatic': Comatic(),
}

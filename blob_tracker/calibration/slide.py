"""Pixels per millimetre from a camera on a slide (thesis, 5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, pi, sqrt

from blob_tracker.calibration.scatter import variance_factor
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

LEAST_STATIONS = 4
MOVES = 3.0  # times the scatter, by which a control point moves at least
BENT = 3.3  # standard deviations: one in a thousand straight paths looks so bent
TABLE = (1.00, 0.10, 0.05)  # px, the shifts of thesis Table 5.1


class SlideError(ValueError):
    """
    Measurements that give no scale; the message says what is missing.

    Examples
    --------
    >>> calibrate_slide(np.array([0.0, 10.0]), np.zeros((2, 2)))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.calibration.slide.SlideError: the slide was read at 2 positions; ...

    """


@dataclass(frozen=True)
class Bend:
    """
    A departure of the path in the picture from even steps on a straight line.

    Parameters
    ----------
    kind : str
        'across': sideways; 'along': steps that grow; 'along, odd': steps that grow to both ends.
    pixels, sigma : float
        Its greatest size over the travel, px, and that figure's standard deviation.

    Examples
    --------
    A bend of 1.5 standard deviations comes by chance, one of 15 does not:

    >>> Bend('across', pixels=0.03, sigma=0.02).significant
    False
    >>> Bend('across', pixels=0.30, sigma=0.02).significant
    True

    """

    kind: str
    pixels: float
    sigma: float

    @property
    def significant(self) -> bool:
        """Tell whether a straight path would hardly ever look so."""
        return abs(self.pixels) > BENT * self.sigma


@dataclass(frozen=True)
class SlideCalibration:
    """
    Scale of a picture at one range.

    Parameters
    ----------
    start : (2,) array
        x, y of the control point at the slide's zero, px.
    scale : (2,) array
        Its movement along x and y, px per mm.
    covariance : (4, 4) array
        Of x and y of the start and of the scale: px^2, px^2 / mm, px^2 / mm^2.
    residuals : (n, 2) array
        Measured less fitted, px.
    chi2 : float
        Sum of the squared residuals over their variances.
    freedom : int
        Its degrees of freedom.
    factor : float
        By which the covariance was multiplied, since the scatter said so.
    bends : tuple of Bend
        The tests of straightness that the stations are enough for.

    Examples
    --------
    The focal length by a slide that is 1 m away, known to 2 mm:

    >>> slide = np.linspace(0.0, 50.0, 11)  # mm
    >>> pixels = np.stack([300.0 + 0.6 * slide, np.full(11, 120.0)], axis=1)
    >>> found = calibrate_slide(slide, np.random.default_rng(1).normal(pixels, 0.02))
    >>> [round(value, 1) for value in found.focal_length(1000.0, 2.0)]  # px
    [599.6, 1.2]
    >>> [round(value, 2) for value in found.displacement(30.0)]  # mm
    [50.03, 0.02]

    """

    start: NDArray[np.float64]
    scale: NDArray[np.float64]
    covariance: NDArray[np.float64]
    residuals: NDArray[np.float64]
    chi2: float
    freedom: int
    factor: float
    bends: tuple[Bend, ...]

    @property
    def pixels_per_mm(self) -> tuple[float, float]:
        """|du / dreal| of thesis eq. 5.1 and its standard deviation, px/mm."""
        value = hypot(*self.scale)
        return value, self._sigma(self.scale / value)

    @property
    def direction(self) -> tuple[float, float]:
        """
        Direction of the path and its standard deviation, mrad.

        From the x axis, positive where the path goes down to the right; -pi/2 to pi/2.
        """
        angle = atan2(self.scale[1], self.scale[0])
        wrapped = (angle + pi / 2) % pi - pi / 2
        across = np.array([-self.scale[1], self.scale[0]]) / hypot(*self.scale) ** 2
        return MRAD_PER_RAD * wrapped, MRAD_PER_RAD * self._sigma(across)

    @property
    def roll(self) -> tuple[float, float]:
        """
        Angle between the path and the nearest of the picture's axes, and its sigma, mrad.

        Turning the camera clockwise by it, seen from behind, takes it away.
        """
        angle, sigma = self.direction
        if abs(angle) > MRAD_PER_RAD * pi / 4:
            angle -= np.copysign(MRAD_PER_RAD * pi / 2, angle)
        return angle, sigma

    def displacement(self, pixels: float) -> tuple[float, float]:
        """Return the way of the slide for a shift in the picture, and its sigma, mm."""
        value, sigma = self.pixels_per_mm
        return pixels / value, pixels * sigma / value**2

    def focal_length(self, distance: float, distance_sigma: float = 0.0) -> tuple[float, float]:
        """
        Return the focal length and its standard deviation.

        With the image plane parallel to the slide, f = Z |du / dreal| (thesis, eq. 2.1).

        Parameters
        ----------
        distance, distance_sigma : float
            Distance Z of the control point from the lens along the axis, and its sigma, mm.

        Returns
        -------
        float, float
            px.

        """
        value, sigma = self.pixels_per_mm
        return value * distance, value * distance * hypot(sigma / value, distance_sigma / distance)

    def _sigma(self, direction: NDArray[np.float64]) -> float:
        return sqrt(float(direction @ self.covariance[2:, 2:] @ direction))


def calibrate_slide(
    slide: NDArray[np.float64],
    pixels: NDArray[np.float64],
    *,
    pixel_sigma: NDArray[np.float64] | None = None,
    slide_sigma: float = 0.0,
) -> SlideCalibration:
    """
    Fit the straight path of a control point to the readings of the slide.

    The point is at u_i = u_0 + g s_i in the picture, with errors in u and in the reading s:

        minimise sum_i r_i' (C_i + slide_sigma^2 g g')^-1 r_i,   r_i = u_i - u_0 - g s_i

    which is maximum likelihood for both errors normal (the effective variance of Deming's
    problem), and |g| the scale of thesis eq. 5.1.

    Parameters
    ----------
    slide : (n,) array
        Readings of the slide, mm, at 4 places or more.
    pixels : (n, 2) array
        Where the control point is, px.
    pixel_sigma : (n, 2) array, optional
        Standard deviations of the pixels; where it is left out they are all equal, and had from
        the scatter: of both coordinates, or of the one across the path where the slide has a
        sigma too.
    slide_sigma : float
        Standard deviation of a reading, mm.

    Returns
    -------
    SlideCalibration
        Scale, direction, and the tests of straightness.

    Raises
    ------
    SlideError
        If there are too few places, or values that are not finite or not possible.

    Examples
    --------
    A point that goes 1.7 px to the left for each mm of the slide, placed to 0.02 px:

    >>> slide = np.linspace(0.0, 50.0, 11)  # mm
    >>> pixels = np.stack([300.0 - 1.7 * slide, np.full(11, 120.0)], axis=1)
    >>> found = calibrate_slide(slide, np.random.default_rng(1).normal(pixels, 0.02))
    >>> scale, sigma = found.pixels_per_mm
    >>> round(scale, 2), round(sigma, 4)  # px/mm
    (1.7, 0.0002)

    """
    slide, pixels = np.asarray(slide, dtype=float), np.asarray(pixels, dtype=float)
    _check(slide, pixels, pixel_sigma, slide_sigma)
    known = pixel_sigma is not None
    middle = slide.mean()
    offset = slide - middle
    line = np.polyfit(offset, pixels, 1)  # (2, 2): scale, then start
    rest = pixels - line[1] - offset[:, None] * line[0]
    if not hypot(*line[0]) * np.ptp(slide) > MOVES * sqrt(float((rest**2).mean())) + 1e-9:
        raise SlideError(
            'the control point does not move with the slide, or by no more than its scatter'
        )
    if pixel_sigma is not None:
        variances = np.asarray(pixel_sigma, dtype=float) ** 2
    elif slide_sigma > 0.0:
        # The slide moves the point along its path only: what it does across is the pixels' own.
        across = np.array([-line[0, 1], line[0, 0]]) / hypot(*line[0])
        sideways = rest @ across
        variances = np.full(pixels.shape, max(sideways @ sideways / (len(slide) - 2), 1e-12))
        known = True
    else:
        variances = np.ones(pixels.shape)

    def whitened(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        root = _whitening(variances, slide_sigma, parameters[2:])
        rest = pixels - parameters[:2] - offset[:, None] * parameters[2:]
        return np.asarray(np.einsum('nij,nj->ni', root, rest).ravel())

    fit = least_squares(whitened, np.concatenate([line[1], line[0]]), x_scale='jac', method='lm')
    start, scale = fit.x[:2], fit.x[2:]
    root = _whitening(variances, slide_sigma, scale)
    design = np.concatenate([root, root * offset[:, None, None]], axis=2).reshape(-1, 4)
    freedom = 2 * len(slide) - 4
    chi2 = float(2.0 * fit.cost)
    factor = variance_factor(chi2, freedom, known=known)
    covariance = factor * np.linalg.inv(design.T @ design)
    to_zero = np.eye(4)  # from the middle of the travel, where both are independent
    to_zero[:2, 2:] = -middle * np.eye(2)
    return SlideCalibration(
        start=start - middle * scale,
        scale=scale,
        covariance=to_zero @ covariance @ to_zero.T,
        residuals=pixels - start - offset[:, None] * scale,
        chi2=chi2,
        freedom=freedom,
        factor=factor,
        bends=_bends(offset, pixels, scale, root, known=known),
    )


def _check(
    slide: NDArray[np.float64],
    pixels: NDArray[np.float64],
    pixel_sigma: NDArray[np.float64] | None,
    slide_sigma: float,
) -> None:
    """Raise where no scale can come of it."""
    if slide.ndim != 1 or pixels.shape != (len(slide), 2):
        raise SlideError(f'{slide.shape} readings do not go with {pixels.shape} pixels')
    if not (np.isfinite(slide).all() and np.isfinite(pixels).all()):
        raise SlideError('a reading or a pixel is NaN or infinite')
    places = len(np.unique(slide))
    if places < LEAST_STATIONS:
        raise SlideError(
            f'the slide was read at {places} positions; {LEAST_STATIONS} or more are needed, and '
            'ten show whether the path is straight'
        )
    if pixel_sigma is not None and not (
        np.shape(pixel_sigma) == pixels.shape
        and np.isfinite(pixel_sigma).all()
        and (np.asarray(pixel_sigma) > 0.0).all()
    ):
        raise SlideError('the sigmas of the pixels must be finite and above 0, one for each')
    if not 0.0 <= slide_sigma < np.inf:
        raise SlideError(f'the sigma of the slide is {slide_sigma} mm; it must be 0 or more')


def _whitening(
    variances: NDArray[np.float64], slide_sigma: float, scale: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the (n, 2, 2) matrices that make residuals independent with unit variance."""
    covariance = variances[:, :, None] * np.eye(2) + slide_sigma**2 * np.outer(scale, scale)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def _bends(
    offset: NDArray[np.float64],
    pixels: NDArray[np.float64],
    scale: NDArray[np.float64],
    root: NDArray[np.float64],
    *,
    known: bool,
) -> tuple[Bend, ...]:
    """Test whether the path is a parabola, or its steps grow: terms beyond the straight line."""
    along = scale / hypot(*scale)
    across = np.array([-along[1], along[0]])
    reach = np.abs(offset).max()
    travel = offset / reach
    square = travel**2 - np.polyval(np.polyfit(travel, travel**2, 1), travel)
    cube = travel**3 - np.polyval(np.polyfit(travel, travel**3, 2), travel)
    terms = [('across', square, across), ('along', square, along)]
    if len(np.unique(offset)) > LEAST_STATIONS:
        terms.append(('along, odd', cube, along))
    columns = [np.eye(2)[None] * np.ones((len(offset), 1, 1)), np.eye(2) * travel[:, None, None]]
    columns += [(shape[:, None] * direction)[:, :, None] for _, shape, direction in terms]
    design = (root @ np.concatenate(columns, axis=2)).reshape(2 * len(offset), -1)
    values = np.einsum('nij,nj->ni', root, pixels).ravel()
    solution = np.linalg.lstsq(design, values, rcond=None)[0]
    rest = values - design @ solution
    covariance = np.linalg.inv(design.T @ design)
    if not known:
        covariance *= rest @ rest / (len(values) - design.shape[1])
    bends = []
    for index, (kind, shape, _) in enumerate(terms, start=4):
        size = np.abs(shape).max()
        bends.append(
            Bend(kind, float(solution[index] * size), float(sqrt(covariance[index, index]) * size))
        )
    return tuple(bends)

"""An effective PSF: what a light gives a pixel, as a function of the pixel's offset from it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import ArrayLike, NDArray

PADDING = 4  # nodes of 0 about the surface: what lies outside reads those
LEAST_NODES = 7  # along an axis
FINEST_PX = 0.1  # between two nodes: finer than any lens draws
COARSEST_PX = 4.0


@dataclass(frozen=True, eq=False)
class EffectivePsf:
    r"""
    A pulse that is integrated over the pixel already: a cubic B-spline surface.

    The mean of the pixel at (k, l) is A P((k - x) / s, (l - y) / s) + b with

        P(u, v) = sum_ij c_ij beta(v / step - i + m) beta(u / step - j + m)

    beta the cubic B-spline and m the middle node (Anderson and King, PASP 112 (2000) 1381, with
    a spline in place of their grid). No pixel is integrated over when it is fitted. The scale s
    lets it grow and shrink with the light; the pixel, which is in it, would not: a pulse of 1.5 px
    that has doubled is 1 % too wide by that, which s takes up.

    Parameters
    ----------
    coefficients : (n, n) array
        c, row i of offset (i - m) step along y; n is odd. The peak of P is 1.
    step : float
        Between two nodes, px.
    sigma : float
        Of the Gaussian that fits the pulse best, px: what `Location.sigma` is at s = 1.
    covariance : (2, 2) array
        Of the error of a position that the error of the pulse makes, px^2: windows of one phase
        have it in common.
    varies : bool
        Whether the scale is fitted; else s = 1.

    Raises
    ------
    ValueError
        If a value is invalid.

    Examples
    --------
    A Gaussian of 1.5 px; its coefficients are one that is narrower, by the variance of the spline:

    >>> step, sigma = 0.75, 1.5
    >>> narrow = np.sqrt(sigma**2 - step**2 / 3.0)
    >>> line = sigma / narrow * np.exp(-0.5 * (step * np.arange(-10, 11) / narrow) ** 2)
    >>> pulse = EffectivePsf(np.outer(line, line), step, sigma)
    >>> pulse.value([0.0, 1.5], 0.0).round(2).tolist()  # the peak, and one sigma from it
    [1.0, 0.61]
    >>> pulse.image((11, 11), x=5.2, y=5.0).shape
    (11, 11)

    """

    coefficients: NDArray[np.float64]
    step: float
    sigma: float
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((2, 2)))
    varies: bool = True

    def __post_init__(self) -> None:
        shape = self.coefficients.shape
        if len(shape) != 2 or shape[0] != shape[1] or shape[0] % 2 != 1 or shape[0] < LEAST_NODES:
            raise ValueError(
                f'a pulse has (n, n) coefficients, n odd and {LEAST_NODES} or more, not {shape}'
            )
        if not np.isfinite(self.coefficients).all() or not (np.abs(self.coefficients) < 1e3).all():
            raise ValueError('the coefficients of a pulse with the peak 1 are within 1000 of 0')
        if not FINEST_PX <= self.step <= COARSEST_PX:
            raise ValueError(
                f'the step is {self.step} px; it must be {FINEST_PX:g} to {COARSEST_PX:g}'
            )
        if not 0.0 < self.sigma < math.inf:
            raise ValueError(f'sigma is {self.sigma} px; it must be above 0')
        covariance = self.covariance
        if covariance.shape != (2, 2) or not np.isfinite(covariance).all():
            raise ValueError('the covariance is not a (2, 2) array of numbers')
        if np.linalg.eigvalsh(covariance).min() < 0.0:
            raise ValueError('the covariance has a negative variance')
        peak = self.value(*self._grid()).max()
        if not 0.9 < peak < 1.1:
            raise ValueError(f'the peak of the pulse is {peak:.3g}; it must be 1')

    def _grid(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        middle = self.coefficients.shape[0] // 2
        along = np.arange(-2 * middle, 2 * middle + 1) * (0.5 * self.step)
        return along[None, :], along[:, None]

    @property
    def reach(self) -> float:
        """Return the offset beyond which the pulse is 0, px."""
        return (self.coefficients.shape[0] // 2 + 2) * self.step

    def value(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.float64]:
        """Return P at offsets u and v, px."""
        u, v = np.broadcast_arrays(np.asarray(u, dtype=float), np.asarray(v, dtype=float))
        out = np.empty((3, u.size))
        evaluate(surface_of(self), u.ravel().copy(), v.ravel().copy(), out)
        return out[0].reshape(u.shape)

    def image(
        self, shape: tuple[int, int], x: float, y: float, scale: float = 1.0
    ) -> NDArray[np.float64]:
        """Return the (h, w) pixels of a pulse at x and y, px."""
        images = empty_images(*shape, self.coefficients.shape[0] + 2 * PADDING)
        fill_images(surface_of(self), x, y, scale, images)
        return images.values[0].copy()


def shifted(pulse: EffectivePsf, x: float, y: float) -> EffectivePsf:
    """Return the pulse that has the same light x and y px further on: another centre."""
    import scipy  # no part of a start

    middle = pulse.coefficients.shape[0] // 2
    along = np.arange(-middle, middle + 1) * pulse.step
    surface = pulse.value(along[None, :] + x, along[:, None] + y)
    return replace(pulse, coefficients=scipy.ndimage.spline_filter(surface, order=3))


class Surface(NamedTuple):
    """
    An effective PSF as kernels read it.

    Parameters
    ----------
    coefficients : (n, n) array
        With PADDING nodes of 0 on each side.
    step : float
        px.

    """

    coefficients: Array
    step: float


def surface_of(pulse: EffectivePsf) -> Surface:
    """Return the surface of a pulse."""
    return Surface(np.pad(pulse.coefficients, PADDING), float(pulse.step))


class Images(NamedTuple):
    """
    A pulse in the pixels of a window; memory to be used again.

    Parameters
    ----------
    values : (4, h, w) array
        The pulse and its slopes by x, y and scale, for an amplitude of 1.
    across : (3, w, 4) array
        For each column: the weights of four nodes in the value and in the slope, and its offset.
    first : (w,) int array
        The first of those nodes.
    row : (2, n) array
        The nodes' sums along a column: of the value and of the slope along y.

    """

    values: Array
    across: Array
    first: NDArray[np.int64]
    row: Array


@kernel
def empty_images(height: int, width: int, nodes: int) -> Images:
    """Return the memory for them; `nodes` counts the padding."""
    return Images(
        np.empty((4, height, width)), np.empty((3, width, 4)), np.empty(width, np.int64),
        np.empty((2, nodes)),
    )


@kernel
def spline(offset: float, step: float, nodes: int, value: Array, slope: Array) -> int:
    """Fill the weights of four nodes at an offset, px, and their slopes; return the first one."""
    place = min(max(offset / step + nodes // 2, 1.0), nodes - 3.0)
    first = int(place)
    t = place - first
    r = 1.0 - t
    value[0] = r * r * r / 6.0
    value[1] = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0
    value[2] = (3.0 * r * r * r - 6.0 * r * r + 4.0) / 6.0
    value[3] = t * t * t / 6.0
    slope[0] = -0.5 * r * r / step
    slope[1] = (1.5 * t * t - 2.0 * t) / step
    slope[2] = (2.0 * r - 1.5 * r * r) / step
    slope[3] = 0.5 * t * t / step
    return first - 1


@kernel
def fill_images(surface: Surface, x: float, y: float, scale: float, images: Images) -> None:
    """Fill the pulse at x, y, px, and its slopes."""
    nodes, step = surface
    values, across, firsts, row = images
    count = nodes.shape[0]
    height, width = values.shape[1:]
    for i in range(width):
        offset = (i - x) / scale
        firsts[i] = spline(offset, step, count, across[0, i], across[1, i])
        across[2, i, 0] = offset
    begin, end = firsts[0], firsts[width - 1] + 4
    weights, slopes = np.empty(4), np.empty(4)
    for j in range(height):
        v = (j - y) / scale
        first = spline(v, step, count, weights, slopes)
        a, b, c, d = weights[0], weights[1], weights[2], weights[3]
        e, f, g, h = slopes[0], slopes[1], slopes[2], slopes[3]
        for k in range(begin, end):
            n0, n1, n2, n3 = (
                nodes[first, k], nodes[first + 1, k], nodes[first + 2, k], nodes[first + 3, k]
            )
            row[0, k] = a * n0 + b * n1 + c * n2 + d * n3
            row[1, k] = e * n0 + f * n1 + g * n2 + h * n3
        for i in range(width):
            k = firsts[i]
            p0, p1, p2, p3 = row[0, k], row[0, k + 1], row[0, k + 2], row[0, k + 3]
            w0, w1, w2, w3 = across[0, i, 0], across[0, i, 1], across[0, i, 2], across[0, i, 3]
            by_u = (
                across[1, i, 0] * p0 + across[1, i, 1] * p1 + across[1, i, 2] * p2
                + across[1, i, 3] * p3
            )
            by_v = w0 * row[1, k] + w1 * row[1, k + 1] + w2 * row[1, k + 2] + w3 * row[1, k + 3]
            values[0, j, i] = w0 * p0 + w1 * p1 + w2 * p2 + w3 * p3
            values[1, j, i] = -by_u / scale
            values[2, j, i] = -by_v / scale
            values[3, j, i] = -(across[2, i, 0] * by_u + v * by_v) / scale


@kernel
def evaluate(surface: Surface, u: Array, v: Array, out: Array) -> None:
    """Fill the value and the slopes along u and v at (m,) offsets, px, into (3, m)."""
    nodes, step = surface
    count = nodes.shape[0]
    wu, su, wv, sv = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    for m in range(u.size):
        left = spline(u[m], step, count, wu, su)
        top = spline(v[m], step, count, wv, sv)
        value, by_u, by_v = 0.0, 0.0, 0.0
        for a in range(4):
            for b in range(4):
                node = nodes[top + a, left + b]
                value += wv[a] * wu[b] * node
                by_u += wv[a] * su[b] * node
                by_v += sv[a] * wu[b] * node
        out[0, m] = value
        out[1, m] = by_u
        out[2, m] = by_v

"""The surface of a pulse that fits windows best, at places that are given."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.effective_psf import EffectivePsf, evaluate, spline, surface_of
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.types import LocationError
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP = 0.5  # px between two nodes
SHARP = 0.75  # px: of pulses narrower than that the nodes lie closer
SHARP_STEP = 0.4
SMOOTHEST = 1e-2  # of the information on a node: the penalty of a first look
PINNED = 1e3  # of the information on a node: the outermost ones are 0
EMPTY = 1e-9  # of it: a node that no pixel saw is what its neighbours make it
UNEVEN = 0.02  # of the peak: what pixels and lenses differ by, so that no one window rules
FAINT = 0.1  # of the peak: what is below it is mostly noise, or a tail
CENTRING = 20  # steps
CENTRED = 1e-6  # px


@dataclass(frozen=True)
class Grid:
    """
    The nodes of a surface.

    Parameters
    ----------
    nodes : int
        Along an axis; odd.
    step : float
        Between two, px.
    sigma : float
        Of the Gaussian nearest to the pulse, px.

    """

    nodes: int
    step: float
    sigma: float

    @classmethod
    def over(cls, extent: int, sigma: float, most: int) -> Grid:
        """Return the grid for windows of up to `extent` px, of `most` nodes along an axis."""
        step = SHARP_STEP if sigma < SHARP else STEP
        half = math.ceil((0.5 * extent + 1.0) / step)
        if half > most // 2:
            half = most // 2
            step = (0.5 * extent + 1.0) / half
        return cls(2 * half + 1, step, sigma)

    @cached_property
    def gaussian(self) -> Floats:
        """Return the (n, n) coefficients of the pixel-integrated Gaussian of the peak 1."""
        import scipy  # no part of a start

        middle = self.nodes // 2
        along = np.array([
            integrated_profile(1, (middle - k) * self.step, self.sigma)[0][0]
            for k in range(self.nodes)
        ])
        along /= along[middle]
        spline_of: Floats = scipy.ndimage.spline_filter(np.outer(along, along), order=3)
        return spline_of

    @cached_property
    def penalty(self) -> Floats:
        """Return D^T D of the third differences along both axes: rows of `Equations.bands`."""
        nodes = self.nodes
        bands = np.zeros((nodes * nodes, 3 * nodes + 4))
        index = np.arange(nodes * nodes).reshape(nodes, nodes)
        stencil = np.array([-1.0, 3.0, -3.0, 1.0])
        for apart, first in ((1, index[:, :-3].ravel()), (nodes, index[:-3].ravel())):
            for p in range(4):
                for q in range(p + 1):
                    bands[first + q * apart, (p - q) * apart] += stencil[p] * stencil[q]
        return bands

    @cached_property
    def edge(self) -> NDArray[np.bool_]:
        """Return which nodes are the outermost two, (n * n,)."""
        edge = np.ones((self.nodes, self.nodes), dtype=bool)
        edge[2:-2, 2:-2] = False
        return edge.ravel()


class Equations:
    """
    The normal equations of a surface, to which windows are added.

    Parameters
    ----------
    grid : Grid
        Its nodes.

    Attributes
    ----------
    bands : (n * n, 3 n + 4) array
        Row i has the matrix' elements (i, i), (i, i + 1), ...
    right : (n * n,) array
        The right side.

    """

    def __init__(self, grid: Grid) -> None:
        size = grid.nodes * grid.nodes
        self.grid = grid
        self.bands, self.right = np.zeros((size, 3 * grid.nodes + 4)), np.zeros(size)

    def add(
        self, lit: Floats, unlit: Floats | None, places: Floats, shot: float, floor: float,
        saturation: float,
    ) -> None:
        """
        Add windows.

        Parameters
        ----------
        lit, unlit : (N, h, w) arrays
            DN; unlit may be None.
        places : (5, N) array
            x, y, amplitude, background and scale of each.
        shot, floor : float
            1 / gain and the variance of a dark pixel, DN^2.
        saturation : float
            DN of a clipped pixel; infinite where none can be.

        """
        _accumulate(
            lit, lit[:0] if unlit is None else unlit, places, shot, floor, saturation,
            self.grid.nodes, self.grid.step, UNEVEN, self.bands, self.right,
        )

    def pulse(self, roughness: float) -> tuple[EffectivePsf, float]:
        """
        Return the pulse that fits best, and how rough it is beside the Gaussian.

        Parameters
        ----------
        roughness : float
            Mean square of the third differences that it may have; 0 to find out.

        Raises
        ------
        LocationError
            If the windows hold none.

        """
        bell = self.grid.gaussian
        if roughness == 0.0:
            first = self._solve(SMOOTHEST * self._information)
            roughness = _roughness(first - bell)
        return _normalised(self._solve(1.0 / roughness), self.grid), roughness

    @property
    def _information(self) -> float:
        """Return the median information on a node that is seen."""
        each = self.bands[:, 0]
        return float(np.median(each[each > 0.0]))

    def _solve(self, smoothing: float) -> Floats:
        """Return the coefficients of the fit, penalised where they depart from the Gaussian."""
        import scipy

        grid, information = self.grid, self._information
        smoothing = max(smoothing, EMPTY * information)
        matrix = self.bands + smoothing * grid.penalty
        matrix[:, 0] += EMPTY * information
        matrix[grid.edge, 0] += PINNED * information
        right = self.right + smoothing * _penalised(grid.gaussian).ravel()
        # The rows are the columns of LAPACK's lower form.
        solved: Floats = scipy.linalg.solveh_banded(
            matrix.T, right, lower=True, overwrite_ab=True, check_finite=False
        )
        return solved.reshape(grid.nodes, grid.nodes)


def _roughness(coefficients: Floats) -> float:
    """Return the mean square of the third differences where there is anything, of both axes."""
    across, down = np.diff(coefficients, 3, axis=1), np.diff(coefficients, 3, axis=0)
    bright = np.abs(coefficients) > 0.05 * np.abs(coefficients).max()
    rows, columns = np.flatnonzero(bright.any(axis=1)), np.flatnonzero(bright.any(axis=0))
    inside = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    both = np.append(across[inside].ravel(), down[inside].ravel())
    return float(np.mean(both**2))


def _penalised(coefficients: Floats) -> Floats:
    """Return D^T D c of the third differences along both axes."""
    total = np.zeros_like(coefficients)
    for turned, out in ((coefficients, total), (coefficients.T, total.T)):
        third = np.diff(turned, 3, axis=0)
        for p, weight in enumerate((-1.0, 3.0, -3.0, 1.0)):
            out[p:len(out) - 3 + p] += weight * third
    return total


def _normalised(coefficients: Floats, grid: Grid) -> EffectivePsf:
    """Return the pulse with its peak at 1."""
    import scipy

    # B-splines of 1 at a node and its neighbours; a parabola is not needed, the peak is a unit.
    weights = np.array([1.0, 4.0, 1.0]) / 6.0
    at_nodes = scipy.ndimage.convolve1d(
        scipy.ndimage.convolve1d(coefficients, weights, axis=0, mode='constant'), weights, axis=1,
        mode='constant',
    )
    peak = float(at_nodes.max())
    if not peak > 0.0:
        raise LocationError('the windows hold no pulse: what they have in common is not a light')
    return EffectivePsf(coefficients / peak, grid.step, grid.sigma)


def centre_of(pulse: EffectivePsf) -> tuple[float, float]:
    """
    Return the point about which the pulse is most symmetric, px.

    The c with the least sum (Q(c + u) - Q(c - u))^2, Q what is above a tenth of the peak, by
    Gauss-Newton from the centroid: of a round pulse the middle, also where it is dark, to the
    accuracy of a fit.
    """
    middle = pulse.coefficients.shape[0] // 2
    along = np.arange(-2 * middle, 2 * middle + 1) * (0.5 * pulse.step)
    u, v = (axis.ravel().copy() for axis in np.meshgrid(along, along))
    surface, ahead, behind = surface_of(pulse), np.empty((3, u.size)), np.empty((3, u.size))
    evaluate(surface, u, v, ahead)
    floor = FAINT * ahead[0].max()
    light = np.maximum(ahead[0] - floor, 0.0)
    centre = np.array([light @ u, light @ v]) / light.sum()
    for _ in range(CENTRING):
        for sign, out in ((1.0, ahead), (-1.0, behind)):
            evaluate(surface, centre[0] + sign * u, centre[1] + sign * v, out)
            out *= out[0] > floor
            out[0] = np.maximum(out[0] - floor, 0.0)
        slopes = ahead[1:] + behind[1:]
        step = np.linalg.solve(slopes @ slopes.T, slopes @ (behind[0] - ahead[0]))
        centre += step
        if np.hypot(*step) < CENTRED:
            break
    return float(centre[0]), float(centre[1])


@kernel
def _accumulate(
    lit: Array, unlit: Array, places: Array, shot: float, floor: float, saturation: float,
    nodes: int, step: float, uneven: float, bands: Array, right: Array,
) -> None:
    """Add windows to the normal equations of the surface."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    wv, wu, slope = np.empty(4), np.empty((width, 4)), np.empty(4)
    left = np.empty(width, np.int64)
    reach = (nodes // 2 - 1) * step
    for n in range(count):
        x, y, amplitude, background, scale = (
            places[0, n], places[1, n], places[2, n], places[3, n], places[4, n]
        )
        for i in range(width):
            left[i] = spline((i - x) / scale, step, nodes, wu[i], slope)
        for j in range(height):
            v = (j - y) / scale
            if abs(v) >= reach:
                continue
            top = spline(v, step, nodes, wv, slope)
            for i in range(width):
                if abs(i - x) >= reach * scale or lit[n, j, i] >= saturation:
                    continue
                variance = max(lit[n, j, i], 0.0) * shot + floor
                light = lit[n, j, i] - background
                if paired:
                    if unlit[n, j, i] >= saturation:
                        continue
                    light = lit[n, j, i] - unlit[n, j, i]
                    variance += max(unlit[n, j, i], 0.0) * shot + floor
                variance += (uneven * amplitude) ** 2
                weight = amplitude / variance
                u0, u1, u2, u3 = wu[i, 0], wu[i, 1], wu[i, 2], wu[i, 3]
                for a in range(4):
                    first = (top + a) * nodes + left[i]
                    along = weight * wv[a]
                    right[first] += along * u0 * light
                    right[first + 1] += along * u1 * light
                    right[first + 2] += along * u2 * light
                    right[first + 3] += along * u3 * light
                    along *= amplitude
                    for b in range(4):
                        row = bands[first + b]
                        value = along * wu[i, b]
                        own = value * wv[a]
                        for d in range(b, 4):
                            row[d - b] += own * wu[i, d]
                        for c in range(a + 1, 4):
                            down = value * wv[c]
                            k = (c - a) * nodes - b
                            row[k] += down * u0
                            row[k + 1] += down * u1
                            row[k + 2] += down * u2
                            row[k + 3] += down * u3

"""The peaking filter of an analogue camera, from pictures of a vertical edge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from blob_tracker.calibration.edge import blurred_step, EdgeError, find_edge
from blob_tracker.camera.trailing_edge import (
    fading_mean, MOST_MEMORY, MOST_PEAKING, TrailingEdge,
)
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads optimize, 25 MB, when it is first used

BEFORE, AFTER = 16, 48  # px beside the edge: three sigma of its blur, and four memories of 12 px
LEAST_LINES = 8
ROUNDS = 4  # of the filter and the places in turn; two are enough
WORST = 1e10  # condition of the normal equations, their columns of length one
STEP = 0.01  # px, of the derivative by the place


@dataclass(frozen=True)
class TrailingEdgeMeasurement:
    """
    The filter and what it was had from.

    Parameters
    ----------
    trailing_edge : TrailingEdge
        Peaking and memory with their covariance.
    edge_sigma : float
        Blur of the edge ahead of the filter, px.
    dark, bright : float
        Levels on the left and on the right of the edge, DN.
    chi2 : float
        Squared residuals over their variance, per degree of freedom: of the mean of the frames,
        whose variance is that of the scatter of the frames about it.

    """

    trailing_edge: TrailingEdge
    edge_sigma: float
    dark: float
    bright: float
    chi2: float


def measure_trailing_edge(frames: Iterable[NDArray[np.generic]]) -> TrailingEdgeMeasurement:
    """
    Measure the filter from frames of one still, straight, nearly vertical edge.

    A step from b to b + c, blurred by sigma, leaves the filter with an overshoot that fades:

        y_k = x_k + a (x_k - m_k),   m_k+1 = e m_k + (1 - e) x_k,   e = exp(-1 / tau)
        x_k = b + c [G(k + 1/2 - p) - G(k - 1/2 - p)],   G as in `edge_places`

    a, tau, sigma, b and c are fitted by least squares to the mean of the frames, in turn with the
    place p of the edge in each line, which jitter puts beside the straight line. The pictures
    are those of `calibrate jitter`.

    Parameters
    ----------
    frames : iterable of (h, w) arrays
        DN above black, 2 or more; the edge with room on its right.

    Returns
    -------
    TrailingEdgeMeasurement
        The filter, with the covariance that the scatter of the frames gives it.

    Raises
    ------
    EdgeError
        If there are too few frames, there is no vertical edge, it is clipped, or no such
        filter fits.

    """
    stack = [np.asarray(frame, dtype=float) for frame in frames]
    if len(stack) < 2:
        raise EdgeError(f'there are {len(stack)} frames; the trailing edge needs 2 or more')
    if len({frame.shape for frame in stack}) > 1:
        raise EdgeError('the frames differ in size; they must be of one camera')
    picture: NDArray[np.float64] = np.mean(stack, axis=0, dtype=np.float64)
    scatter = float(np.mean(np.var(stack, axis=0, ddof=1))) / len(stack)
    start, slope = find_edge(picture)
    straight: NDArray[np.float64] = start + slope * np.arange(float(len(picture)))
    pixels, places = _about(picture, straight)
    if pixels.min() <= 0.0:
        raise EdgeError('the picture is clipped at black beside the edge; light its dark side')
    dark, bright = float(np.median(pixels[:, :4])), float(np.median(pixels[:, -4:]))
    theta = np.array([0.3, 4.0, 1.2, dark, bright - dark, 0.5])
    # Wider than what a calibration may hold only in sigma and the levels.
    least = [0.0, 0.3, 0.2, -np.inf, -np.inf, -8.0]
    most = [MOST_PEAKING, MOST_MEMORY, 8.0, np.inf, np.inf, 8.0]
    for _ in range(ROUNDS):
        found = scipy.optimize.least_squares(
            lambda trial: (_model(trial, places, pixels.shape[1]) - pixels).ravel(), theta,
            bounds=(least, most), x_scale=np.array([1.0, 4.0, 1.0, 10.0, 100.0, 1.0]),
        )
        theta = found.x.copy()
        places, theta[5] = places + theta[5], 0.0
        # A step of Gauss and Newton for the place in each line by itself.
        steeper = _model(theta, places + STEP, pixels.shape[1])
        slopes = (steeper - _model(theta, places - STEP, pixels.shape[1])) / (2.0 * STEP)
        residuals = pixels - _model(theta, places, pixels.shape[1])
        places = places + (residuals * slopes).sum(axis=1) / (slopes**2).sum(axis=1)
    if not found.success:
        raise EdgeError(f'no peaking filter fits the edge: {found.message}')
    residuals = pixels - _model(theta, places, pixels.shape[1])
    freedom = pixels.size - theta.size - places.size
    # The place in each line is found with the filter: what it could take over is not the filter's.
    own = found.jac.reshape(*pixels.shape, theta.size)[:, :, :-1]
    shared = np.einsum('hk,hkp->hp', slopes, own) / (slopes**2).sum(axis=1)[:, None]
    own = own - slopes[:, :, None] * shared[:, None, :]
    length = np.sqrt((own**2).sum(axis=(0, 1)))
    unit = own / np.maximum(length, 1e-30)
    normal = np.einsum('hkp,hkq->pq', unit, unit)
    if not (length > 0.0).all() or np.linalg.cond(normal) > WORST:
        raise EdgeError('the edge shows no overshoot: there is no trailing edge to take off')
    # Of the residuals as they are: where the edge is steep the jitter of its frames adds to them.
    inverse = np.linalg.inv(normal) / length[:, None]
    moved = np.einsum('pq,hkq->hkp', inverse, unit)
    covariance = np.einsum('hkp,hkq,hk->pq', moved, moved, residuals**2) * pixels.size / freedom
    rest = float((residuals**2).sum()) / freedom
    peaking, memory, sigma, level, contrast, _ = (float(value) for value in theta)
    return TrailingEdgeMeasurement(
        TrailingEdge(peaking, memory, covariance[:2, :2]),
        sigma, level, level + contrast, rest / max(scatter, 1e-12),
    )


def _model(
    theta: NDArray[np.float64], places: NDArray[np.float64], count: int
) -> NDArray[np.float64]:
    """Return the (h, count) mean behind the filter."""
    peaking, memory, sigma, dark, contrast, shift = theta
    step = blurred_step(count, places + shift, sigma)[0]
    return np.asarray(dark + contrast * (step + peaking * (step - fading_mean(step, memory))))


def _about(
    picture: NDArray[np.float64], places: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the pixels beside the edge in each line that has them, and its places in them."""
    first = np.floor(places) - BEFORE
    seen = first >= 0
    reach = min(AFTER, int(np.min(picture.shape[1] - 1 - np.floor(places[seen]), initial=AFTER)))
    if seen.sum() < LEAST_LINES or reach < BEFORE:
        raise EdgeError(
            f'the edge must be seen in {LEAST_LINES} lines with {BEFORE} px on either side'
        )
    columns = first[seen].astype(int)[:, None] + np.arange(BEFORE + reach)
    pixels = np.take_along_axis(picture[seen], columns, axis=1)
    return pixels, places[seen] - first[seen]

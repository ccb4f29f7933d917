"""Place a blurred vertical edge in each line of a picture, at the limit that the noise sets."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

HALF = 12  # px on each side of the edge: three sigma of the widest blur that is taken
LEAST_LINES = 0.5  # of the picture's, in which the edge must be found
LEAST_SNR = 5.0  # contrast over noise: below it the place of an edge is guessed
STEEPEST = 0.5  # px per line: a steeper edge is not vertical
ROUNDS = 12
CLOSE_ENOUGH = 1e-5  # px: a thousandth of the noise
NARROWEST, WIDEST = 0.3, 4.0  # px, of the blur


class EdgeError(ValueError):
    """A picture without the edge that is asked for; the message says what is missing."""


def find_edge(picture: NDArray[np.float64]) -> tuple[float, float]:
    """
    Find the straight, nearly vertical edge of greatest contrast.

    The steepest place of each line votes; the line that most of them lie on, by the median of
    the slopes between distant lines (Theil and Sen), is the edge.

    Parameters
    ----------
    picture : (h, w) array
        DN.

    Returns
    -------
    float, float
        x in line 0, px, and the slope, px per line; good to a pixel.

    Raises
    ------
    EdgeError
        If there is none that runs from top to bottom, or it is not nearly vertical.

    """
    if picture.ndim != 2 or min(picture.shape) < 2 * HALF:
        raise EdgeError(
            f'a picture of an edge is {2 * HALF} x {2 * HALF} px or more, not {picture.shape}'
        )
    if not np.isfinite(picture).all():
        raise EdgeError('the picture holds NaN or infinite pixels')
    height, width = picture.shape
    smooth = cv2.GaussianBlur(picture, (9, 9), 2.0)
    steepness = np.abs(np.diff(smooth, axis=1))
    if steepness.max() <= 0.0:
        raise EdgeError('the picture is flat: it shows no edge')
    steepest = steepness.argmax(axis=1) + 0.5
    lines = np.arange(height)
    half = height // 2
    slopes = (steepest[height - half:] - steepest[:half]) / (height - half)
    slope = float(np.median(slopes))
    start = float(np.median(steepest - slope * lines))
    on_it = np.abs(steepest - start - slope * lines) < 2.0
    if on_it.mean() < LEAST_LINES:
        raise EdgeError(
            f'only {100.0 * on_it.mean():.0f} % of the lines have their steepest place on one '
            'straight line: show one vertical edge from the top of the picture to its bottom'
        )
    slope, start = (float(value) for value in np.polyfit(lines[on_it], steepest[on_it], 1))
    if abs(slope) > STEEPEST:
        raise EdgeError(
            f'the edge leans by {slope:.2f} px per line; turn it upright to {STEEPEST} or less'
        )
    ends = (start, start + slope * (height - 1))
    if min(ends) < HALF or max(ends) > width - 1 - HALF:
        raise EdgeError(
            f'the edge runs from x = {ends[0]:.0f} to {ends[1]:.0f} px; keep it {HALF} px from '
            f'the sides of the {width} px wide picture'
        )
    return start, slope


def edge_places(
    picture: NDArray[np.float64], edge: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """
    Place the edge in each line by a weighted least-squares fit of a blurred, integrated step.

    With G(t) = t Phi(t / s) + s phi(t / s), the integral of a step that a Gaussian of standard
    deviation s has blurred, the pixel k of a line is

        m_k = b + a [G(k + 1/2 - x) - G(k - 1/2 - x)]

    x, a and b are of each line, s is of the whole picture, where all lines tell of it. The
    weights are one over the variance of the pixels, which grows linearly from the dark side to
    the bright one as shot noise does, and is measured on the residuals: the fit is that of
    maximum likelihood, and its variance is the Cramer-Rao bound.

    Parameters
    ----------
    picture : (h, w) array
        DN.
    edge : (float, float)
        Of `find_edge`, within 2 px.

    Returns
    -------
    x : (h,) array
        Place of the edge, px; NaN in a line that does not show it.
    variance : (h,) array
        Of x, px^2.
    sigma : float
        Blur s of the edge, px.

    Raises
    ------
    EdgeError
        If the contrast is too low or the edge too blurred.

    """
    height = len(picture)
    expected = edge[0] + edge[1] * np.arange(height)
    first = np.clip(np.rint(expected).astype(int) - HALF, 0, picture.shape[1] - 2 * HALF - 1)
    columns = first[:, None] + np.arange(2 * HALF + 1)
    pixels = np.take_along_axis(picture, columns, axis=1)
    x = expected - first
    dark, bright = pixels[:, :4].mean(axis=1), pixels[:, -4:].mean(axis=1)
    parameters = np.stack([x, bright - dark, dark], axis=1)
    sigma = 1.5
    weights = np.ones_like(pixels)
    for weighting in range(2):
        for _ in range(ROUNDS):
            parameters, sigma, moved = _step(pixels, parameters, sigma, weights)
            if moved < CLOSE_ENOUGH:
                break
        if weighting == 0:
            variance = _variance(pixels, parameters, sigma)
            weights = 1.0 / variance
    information = _normal(_derivatives(pixels.shape[1], parameters, sigma)[:, :, :3], weights)
    with np.errstate(all='ignore'):
        covariance = np.linalg.inv(information + 1e-12 * np.eye(3))[:, 0, 0]
    place = parameters[:, 0] + first
    noise = np.sqrt(variance.mean(axis=1))
    seen = (np.abs(parameters[:, 1]) > LEAST_SNR * noise) & (np.abs(place - expected) < HALF / 2)
    seen &= np.isfinite(covariance) & (covariance > 0.0)
    if seen.mean() < LEAST_LINES:
        raise EdgeError(
            f'the edge stands out of the noise in {100.0 * seen.mean():.0f} % of the lines only; '
            'more light on its bright side, or a longer exposure'
        )
    if sigma > WIDEST - 1e-3:
        raise EdgeError(f'the edge is blurred by {sigma:.1f} px or more; focus the lens')
    return np.where(seen, place, np.nan), np.where(seen, covariance, np.nan), sigma


def blurred_step(
    count: int, places: NDArray[np.float64], sigma: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Return the mean of a blurred step from 0 to 1 over each pixel, see `edge_places`.

    Parameters
    ----------
    count : int
        Pixels in a line.
    places : (h,) array
        x of the step in each line, px.
    sigma : float
        Standard deviation of the blur, px.

    Returns
    -------
    step : (h, count) array
        G(k + 1/2 - x) - G(k - 1/2 - x).
    borders : (h, count + 1) array
        Of the pixels, from the step, in sigma.

    """
    borders = (np.arange(count + 1) - 0.5 - places[:, None]) / sigma
    phi = np.exp(-0.5 * borders**2) / np.sqrt(2.0 * np.pi)
    return np.diff(sigma * (borders * ndtr(borders) + phi), axis=1), borders


def _model(
    count: int, parameters: NDArray[np.float64], sigma: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the mean, the unit step, and the borders of the pixels from the edge in sigma."""
    step, borders = blurred_step(count, parameters[:, 0], sigma)
    return parameters[:, 2:] + parameters[:, 1:2] * step, step, borders


def _derivatives(
    count: int, parameters: NDArray[np.float64], sigma: float
) -> NDArray[np.float64]:
    """Return the (h, count, 4) derivatives of the mean by x, a, b and s."""
    _, step, borders = _model(count, parameters, sigma)
    phi = np.exp(-0.5 * borders**2) / np.sqrt(2.0 * np.pi)
    by_x = -parameters[:, 1:2] * np.diff(ndtr(borders), axis=1)
    by_sigma = parameters[:, 1:2] * np.diff(phi, axis=1)
    return np.stack([by_x, step, np.ones_like(step), by_sigma], axis=2)


def _normal(derivatives: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (h, p, p) matrices of the normal equations."""
    return np.asarray(derivatives.transpose(0, 2, 1) @ (weights[:, :, None] * derivatives))


def _step(
    pixels: NDArray[np.float64],
    parameters: NDArray[np.float64],
    sigma: float,
    weights: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float, float]:
    """Return the parameters after one step of Gauss and Newton, and how far x moved, px."""
    mean = _model(pixels.shape[1], parameters, sigma)[0]
    derivatives = _derivatives(pixels.shape[1], parameters, sigma)
    residuals = (pixels - mean) * weights
    normal = _normal(derivatives, weights)
    gradient = np.einsum('hkp,hk->hp', derivatives, residuals)
    own = normal[:, :3, :3] + 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    # The one width is eliminated last: each line's own three parameters depend on it alone.
    solved = np.linalg.solve(own, np.concatenate([gradient[:, :3, None], normal[:, :3, 3:]], 2))
    rest = gradient[:, 3] - np.einsum('hp,hp->h', normal[:, 3, :3], solved[:, :, 0])
    information = normal[:, 3, 3] - np.einsum('hp,hp->h', normal[:, 3, :3], solved[:, :, 1])
    change = rest.sum() / max(information.sum(), 1e-30)
    widened = float(np.clip(sigma + np.clip(change, -0.5, 0.5), NARROWEST, WIDEST))
    moves = solved[:, :, 0] - (widened - sigma) * solved[:, :, 1]
    moves[:, 0] = np.clip(moves[:, 0], -1.0, 1.0)  # px: a line without an edge goes nowhere
    return parameters + moves, widened, float(np.abs(moves[:, 0]).max())


def _variance(
    pixels: NDArray[np.float64], parameters: NDArray[np.float64], sigma: float
) -> NDArray[np.float64]:
    """Return the variance of each pixel, linear between the dark side and the bright one."""
    mean, step, _ = _model(pixels.shape[1], parameters, sigma)
    own = _derivatives(pixels.shape[1], parameters, sigma)[:, :, :3]
    normal = _normal(own, np.ones_like(pixels)) + 1e-9 * np.eye(3)
    # What the fit itself took of the scatter of each pixel.
    leverage = np.einsum('hkp,hpk->hk', own, np.linalg.solve(normal, own.transpose(0, 2, 1)))
    level = np.where(parameters[:, 1:2] >= 0.0, step, 1.0 - step)  # 0 dark, 1 bright
    squares = (pixels - mean) ** 2 / np.maximum(1.0 - leverage, 0.1)
    # The medians over lines: a mark on the edge must not count as noise.
    dark, bright = (
        np.median(squares[side]) / 0.455  # chi-square of one degree: its median
        for side in (level < 0.1, level > 0.9)
    )
    least = max(1e-3 * max(dark, bright), 1e-12)
    dark, bright = max(float(dark), least), max(float(bright), least)
    return dark + (bright - dark) * np.clip(level, 0.0, 1.0)

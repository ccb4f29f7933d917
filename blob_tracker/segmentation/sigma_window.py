"""A window of so many standard deviations about the blob, sized by its second moments."""

# Numba's decorators bring no types.
# mypy: disable-error-code="untyped-decorator"

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.segmentation.box import Box, box_about
from blob_tracker.segmentation.contrast import Contrast
import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

SMALLEST_HALF = 3  # px: 7 x 7 hold a blob of sigma 1 and its background
REACH = 4.0  # sigma: a Gaussian is 3e-4 of its peak there, which is background
FINEST = 0.7  # px, scale at which the search begins: the pixel itself is 0.29 wide
COARSEST = 8.0  # binned px; beyond it the pixels are binned and the search goes on
BINNING = 4  # by which they are: from 8 px to 2, well sampled still
REGION = int(REACH * COARSEST)  # binned px to either side
STEPS = 20  # the moments settle in 3 to 6
SETTLED = 0.01  # change of sigma and of place, in sigma, at which they have


class Extent(NamedTuple):
    """
    Where a blob is and how wide.

    Parameters
    ----------
    x, y : float
        Centre, px of the frame.
    sigma_x, sigma_y : float
        Standard deviations along the rows and the columns, px.
    sigma_major, sigma_minor : float
        Those along the longest and the shortest axis, px.
    snr : float
        Response of the matched filter in standard deviations of its noise.

    """

    x: float
    y: float
    sigma_x: float
    sigma_y: float
    sigma_major: float
    sigma_minor: float
    snr: float


def sigma_window(
    contrast: Contrast, column: int, row: int, largest: int, *, sigmas: float
) -> Box | None:
    """
    Return the box of +-k sigma about the blob at a peak, re-centred on the blob.

    The thesis finds that the location is best from pixels within two of its s, 2.8 sigma, of the
    mean (sections 3.6 and 5.3).

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    column, row : int
        Pixel of the peak.
    largest : int
        Greatest half-width of the box, px.
    sigmas : float
        k.

    Returns
    -------
    Box or None
        In the frame, 7 x 7 px or more but for what the frame's border cuts off. None where the
        blob would not fit into `largest`, or nothing stands out.

    """
    extent = measure_extent(contrast, column, row, largest / sigmas)
    if extent is None:
        return None
    return box_about(
        round(extent.x),
        round(extent.y),
        max(int(np.ceil(sigmas * extent.sigma_x)), SMALLEST_HALF),
        max(int(np.ceil(sigmas * extent.sigma_y)), SMALLEST_HALF),
        contrast.shape,
    )


def measure_extent(
    contrast: Contrast, column: int, row: int, largest: float
) -> Extent | None:
    """
    Measure place and width of the blob at a peak by adaptive moments.

    First the scale s is doubled from 0.7 px for as long as the response of the matched filter,

        SNR(s) = sum(w I) / (noise sqrt(sum w^2)),   w = exp(-r^2 / 2 s^2),

    grows; for a Gaussian blob its maximum is at s = sigma. Then the weighted moments are iterated
    to where the weight is the blob itself (Bernstein and Jarvis, AJ 123 (2002), section 3.1):
    with <d> and <dd> the first and second moments under w,

        c <- c + <d> (1 + s^2 / sigma^2),   1 / sigma^2 <- 1 / <dd> - 1 / s^2,   s <- sigma.

    The background is the median of the pixels at 4 s. Blobs wider than 8 px are measured on
    binned pixels, so that the time hardly depends on the width.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    column, row : int
        Pixel of the peak.
    largest : float
        Greatest sigma, px.

    Returns
    -------
    Extent or None
        None where nothing stands out at the peak, or it is wider than `largest`.

    """
    x, y, sigma = float(column), float(row), FINEST
    binning = 1
    while binning * FINEST <= largest:
        half = REGION * binning
        box = box_about(round(x), round(y), half, half, contrast.shape)
        width, height = (box.x1 - box.x0) // binning, (box.y1 - box.y0) // binning
        if min(width, height) < 3:
            return None
        signal = contrast.signal(Box(
            box.x0, box.y0, box.x0 + width * binning, box.y0 + height * binning
        ))
        if binning > 1:
            signal = np.asarray(cv2.resize(signal, (width, height), interpolation=cv2.INTER_AREA))
        # Of a binned pixel the centre is half a binned pixel from the edge.
        edge = 0.5 * (binning - 1)
        x, y, *sigmas, snr = _settle(
            signal,
            (x - box.x0 - edge) / binning,
            (y - box.y0 - edge) / binning,
            sigma / binning,
            contrast.background,
            contrast.noise / binning,
        )
        x, y = box.x0 + edge + binning * x, box.y0 + edge + binning * y
        if not snr > 0.0:
            return None
        sigma_x, sigma_y, major, minor = (binning * each for each in sigmas)
        sigma = float(np.sqrt(0.5 * (sigma_x**2 + sigma_y**2)))
        if sigma < COARSEST * binning:
            inside = 0 <= x <= contrast.shape[1] - 1 and 0 <= y <= contrast.shape[0] - 1
            fits = max(sigma_x, sigma_y) <= largest
            extent = Extent(x, y, sigma_x, sigma_y, major, minor, snr)
            return extent if inside and fits else None
        binning *= BINNING
        sigma = 0.5 * COARSEST * binning / BINNING
    return None


def compile_ahead() -> None:
    """Compile the moments, or load them from Numba's cache, before the first target needs it."""
    bell = np.exp(-((np.arange(9) - 4.0) ** 2) / 4.0)
    lit = np.round(100.0 * bell[:, None] * bell[None, :]).astype(np.uint8)
    measure_extent(Contrast(lit, np.zeros_like(lit), 0.0, 1.0), 4, 4, 4.0)


@njit(cache=True)
def _settle(
    pixels: NDArray[np.float32], x: float, y: float, sigma: float, level: float, noise: float
) -> tuple[float, float, float, float, float, float, float]:
    """
    Return x, y, sigma along x, y, the longest and shortest axis, and SNR of the blob near (x, y).

    All but the last are px of `pixels`. The SNR is 0 where there is no blob; sigma is COARSEST or
    more where it is wider than that.
    """
    best = -1.0
    scale = sigma
    while scale <= COARSEST:
        flux, norm, dx, dy, _, _, _ = _moments(pixels, x, y, scale, level)
        snr = flux / (noise * np.sqrt(norm))
        if snr <= best:
            break
        best, sigma = snr, scale
        if flux > 0.0:
            x += min(max(dx, -scale), scale)
            y += min(max(dy, -scale), scale)
        scale *= 2.0
    if best <= 0.0:
        return x, y, sigma, sigma, sigma, sigma, 0.0
    xx = yy = sigma * sigma
    mxx = myy = 0.5 * xx
    mxy = 0.0
    weight = xx
    for _ in range(STEPS):
        level = _ring(pixels, x, y, sigma)
        flux, norm, dx, dy, mxx, myy, mxy = _moments(pixels, x, y, sigma, level)
        best = flux / (noise * np.sqrt(norm))
        if best <= 0.0:
            return x, y, sigma, sigma, sigma, sigma, 0.0
        weight = sigma * sigma
        # A step is at most a doubling: what the moments say far from the blob is not exact.
        xx = _unweighted(mxx, weight)
        yy = _unweighted(myy, weight)
        new = np.sqrt(0.5 * (xx + yy))
        gain = 1.0 + weight / (new * new)
        dx = min(max(gain * dx, -sigma), sigma)
        dy = min(max(gain * dy, -sigma), sigma)
        x += dx
        y += dy
        change = max(abs(new - sigma), abs(dx), abs(dy))
        sigma = new
        if sigma >= COARSEST or change < SETTLED * sigma:
            break
    mean, half = 0.5 * (mxx + myy), np.sqrt(0.25 * (mxx - myy) ** 2 + mxy * mxy)
    major, minor = _unweighted(mean + half, weight), _unweighted(mean - half, weight)
    return x, y, np.sqrt(xx), np.sqrt(yy), np.sqrt(major), np.sqrt(minor), best


@njit(cache=True)
def _unweighted(moment: float, weight: float) -> float:
    """Return the variance of a Gaussian whose second moment under a Gaussian weight is given."""
    if moment >= 0.8 * weight:
        return 4.0 * weight
    return max(1.0 / (1.0 / max(moment, 0.05) - 1.0 / weight), 0.25 * weight, 0.1)


@njit(cache=True)
def _moments(
    pixels: NDArray[np.float32], x: float, y: float, sigma: float, level: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return sum(w I), sum(w^2), and the first and second moments under w about (x, y)."""
    half = max(REACH * sigma, 2.0)
    first, last = max(int(x - half), 0), min(int(x + half) + 2, pixels.shape[1])
    top, bottom = max(int(y - half), 0), min(int(y + half) + 2, pixels.shape[0])
    scale = -0.5 / (sigma * sigma)
    along = np.empty(max(last - first, 0))
    for i in range(first, last):
        along[i - first] = np.exp(scale * (i - x) ** 2)
    flux = norm = sx = sy = sxx = syy = sxy = 0.0
    for j in range(top, bottom):
        across = np.exp(scale * (j - y) ** 2)
        row = row_x = row_xx = row_norm = 0.0
        for i in range(first, last):
            weight = along[i - first]
            value = weight * (pixels[j, i] - level)
            d = i - x
            row += value
            row_x += value * d
            row_xx += value * d * d
            row_norm += weight * weight
        d = j - y
        flux += across * row
        norm += across * across * row_norm
        sx += across * row_x
        sxx += across * row_xx
        sy += across * row * d
        syy += across * row * d * d
        sxy += across * row_x * d
    if flux <= 0.0 or norm <= 0.0:
        return flux, max(norm, 1e-12), 0.0, 0.0, 0.0, 0.0, 0.0
    sx /= flux
    sy /= flux
    return flux, norm, sx, sy, sxx / flux, syy / flux, sxy / flux


@njit(cache=True)
def _ring(pixels: NDArray[np.float32], x: float, y: float, sigma: float) -> float:
    """Return the median of the pixels on the border of the box of 4 sigma about (x, y)."""
    half = max(REACH * sigma, 3.0)
    left, right = max(int(x - half), 0), min(int(x + half) + 1, pixels.shape[1] - 1)
    top, bottom = max(int(y - half), 0), min(int(y + half) + 1, pixels.shape[0] - 1)
    ring = np.empty(2 * (max(right - left, 0) + max(bottom - top, 0) + 2))
    count = 0
    for i in range(left, right + 1):
        ring[count] = pixels[top, i]
        ring[count + 1] = pixels[bottom, i]
        count += 2
    for j in range(top + 1, bottom):
        ring[count] = pixels[j, left]
        ring[count + 1] = pixels[j, right]
        count += 2
    return np.median(ring[:count])

"""A picture of how a blob was placed in its window, for people."""

from __future__ import annotations

from dataclasses import replace
import functools
import math
from typing import Any

from blob_tracker.drawing import (
    blank, CLIPPED, Colour, FOUND, GAP_PX, in_grey, LINE_PX, nearest_pixel, PAPER, paragraphs,
    Picture, REJECTED, side_by_side, stack, TEXT, text_width, titled, write,
)
from blob_tracker.location.noise import noise_of_sum, pixel_variance
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.types import Bearing, Location, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

CENTRE: Colour = (0, 255, 255)
WIDTH: Colour = (255, 190, 90)
COVARIANCE: Colour = (255, 120, 255)

PANEL_PX = 288  # px of the side of a window
CROSS_PX = 9  # px of an arm
LEAST_RANGE_DN = 8.0  # DN from black to white
STRETCH_SIGMA = 5.0  # standard deviations of a pixel from grey to white
LEGIBLE_PX = PANEL_PX / 8  # px of the longer half-axis of the covariance, at most


def draw(
    window: Window,
    noise: SensorNoise,
    location: Location | None = None,
    bearing: Bearing | None = None,
    reason: str = '',
    name: str = '',
) -> Picture:
    """
    Draw a window: lit, unlit, their difference with what was found there, and what is left.

    In the difference a cross is the centre, a circle has the fitted sigma as its radius, and an
    ellipse is the covariance (one sigma along each axis), magnified as the words below say. The
    residual is lit less unlit less the pulse (pixel-integrated, Smith et al., Nature Methods 7
    (2010), eq. 2) less its mean, in standard deviations of each pixel: noise where the pulse
    fits. Clipped pixels are red.

    Parameters
    ----------
    window : Window
        Of any size and depth.
    noise : SensorNoise
        Of a pixel of one frame, as it was placed with.
    location : Location or None
        Where the blob is; None if it was not placed.
    bearing : Bearing or None
        Its direction.
    reason : str
        Why it was not placed.
    name : str
        Of the light, where there are several.

    Returns
    -------
    (h, w, 3) uint8 array
        Blue, green and red; 600 to 1192 px wide.

    """
    window = _seen(window)
    lit = _numbers(window.lit)
    unlit = None if window.unlit is None else _numbers(window.unlit)
    height, width = lit.shape
    scale = PANEL_PX / max(height, width)
    if scale >= 1.0:
        scale = math.floor(scale)
    clipped = lit >= (math.inf if window.saturation is None else window.saturation)
    levels = lit if unlit is None else np.stack([lit, unlit])
    black, white = _range(levels)
    panels = [titled(_red(in_grey(lit, black, white, scale), clipped),
                     f'lit, {black:.0f} to {white:.0f} DN', PANEL_PX)]
    difference = lit
    if unlit is not None:
        panels.append(
            titled(in_grey(unlit, black, white, scale), 'unlit, the same levels', PANEL_PX)
        )
        difference = lit - unlit
    if location is None:
        if unlit is not None:
            low, high = _range(difference)
            panels.append(titled(in_grey(difference, low, high, scale),
                                 f'lit less unlit, {low:.0f} to {high:.0f} DN', PANEL_PX))
    else:
        panels += _found(window, difference, clipped, noise, location, scale)
    row = functools.reduce(side_by_side, panels)
    lines = _in_words(window, location, bearing, reason, name)
    words = paragraphs(lines, max(row.shape[1], 2 * PANEL_PX + GAP_PX))
    return np.pad(
        stack([row, words]), [(GAP_PX, 0), (GAP_PX, GAP_PX), (0, 0)], constant_values=PAPER[0]
    )


def _seen(window: Window) -> Window:
    """Return a window that is dark where its pixels do not see the light."""
    if window.sites is None:
        return window
    lit, unlit = (
        None if pixels is None else np.where(window.sites, pixels, pixels[window.sites].min())
        for pixels in (window.lit, window.unlit)
    )
    assert lit is not None
    return replace(window, lit=lit, unlit=unlit)


def _numbers(pixels: NDArray[Any]) -> NDArray[np.float64]:
    """Return pixels as numbers that can be drawn."""
    return np.clip(np.nan_to_num(pixels.astype(np.float64)), -1e9, 1e9)


def _range(pixels: NDArray[np.float64]) -> tuple[float, float]:
    """Return the levels that are shown black and white, DN."""
    low = float(pixels.min())
    return low, max(float(pixels.max()), low + LEAST_RANGE_DN)


def _red(shown: Picture, clipped: NDArray[np.bool_]) -> Picture:
    """Mark the clipped pixels."""
    import cv2  # no part of a start

    if clipped.any():
        size = (shown.shape[1], shown.shape[0])
        where = cv2.resize(clipped.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
        shown[where > 0] = CLIPPED
    return shown


def _found(
    window: Window,
    difference: NDArray[np.float64],
    clipped: NDArray[np.bool_],
    noise: SensorNoise,
    location: Location,
    scale: float,
) -> list[Picture]:
    """Return the difference with what was found in it, and what is left."""
    import cv2

    binning = np.array(window.binning, dtype=float)
    x, y = (np.array([location.x - window.x0, location.y - window.y0]) + 0.5) / binning - 0.5
    low, high = _range(difference)
    shown = _red(in_grey(difference, low, high, scale), clipped)
    place = nearest_pixel((x + 0.5) * scale - 0.5), nearest_pixel((y + 0.5) * scale - 0.5)
    cv2.circle(shown, place, max(nearest_pixel(location.sigma * scale), 1), WIDTH, 1, cv2.LINE_AA)
    variances, axes = np.linalg.eigh(location.covariance / np.outer(binning, binning))
    half = scale * np.sqrt(variances)  # the shorter one first
    magnified = _round_factor(LEGIBLE_PX / max(float(half[1]), 1e-9))
    angle = math.degrees(math.atan2(axes[1, 1], axes[0, 1]))
    size = (nearest_pixel(half[1] * magnified), nearest_pixel(half[0] * magnified))
    cv2.ellipse(shown, place, size, angle, 0.0, 360.0, COVARIANCE, 1, cv2.LINE_AA)
    for colour, thickness in ((PAPER, 3), (CENTRE, 1)):  # light on light is not seen
        cv2.drawMarker(shown, place, colour, cv2.MARKER_CROSS, 2 * CROSS_PX, thickness)
    name = 'lit' if window.unlit is None else 'lit less unlit'
    fitted = titled(shown, f'{name}, {low:.0f} to {high:.0f} DN', PANEL_PX)
    noise = replace(noise, read_noise=math.hypot(noise.read_noise, window.added_noise))
    total = noise_of_sum(noise, window.looks)
    variance = pixel_variance(_numbers(window.lit), total)
    if window.unlit is not None:
        variance = variance + pixel_variance(_numbers(window.unlit), total)
    height, width = difference.shape
    along_x, along_y = (
        integrated_profile(count, centre, location.sigma)[0]
        for count, centre in ((width, x), (height, y))
    )
    out = clipped if window.sites is None else clipped | ~window.sites
    left = np.where(out, 0.0, difference - location.amplitude * np.outer(along_y, along_x))
    weight = np.where(out, 0.0, 1.0 / variance)
    left -= (weight * left).sum() / max(float(weight.sum()), 1e-12)
    left = np.where(out, 0.0, left / np.sqrt(variance))
    remainder = _red(in_grey(left, -STRETCH_SIGMA, STRETCH_SIGMA, scale), clipped)
    legend = blank(LINE_PX, PANEL_PX)
    left_edge = 0
    for word, colour in (
        ('centre', CENTRE), ('sigma', WIDTH), (f'covariance x {magnified:g}', COVARIANCE),
    ):
        write(legend, word, left_edge, 0, colour)
        left_edge += text_width(word) + 2 * GAP_PX
    return [
        np.vstack([fitted, legend]),
        titled(
            remainder,
            f'residual, -{STRETCH_SIGMA:g} to {STRETCH_SIGMA:g} times its noise',
            PANEL_PX,
        ),
    ]


def _round_factor(factor: float) -> float:
    """Return the greatest of 1, 2, 5, 10, 20 ... that is not above a factor; or 1."""
    factor = min(max(factor, 1.0), 1e9)
    power = 10.0 ** math.floor(math.log10(factor))
    return power * max(step for step in (1.0, 2.0, 5.0) if step * power <= factor)


def _in_words(
    window: Window, location: Location | None, bearing: Bearing | None, reason: str, name: str
) -> list[tuple[str, Colour]]:
    """Return the numbers in lines of text."""
    height, width = window.lit.shape
    summed = f', the sum of {window.looks} frames' if window.looks > 1 else ''
    where = f'{name} window of {width} x {height} px at ({window.x0}, {window.y0}){summed}'.strip()
    if location is None:
        return [(f'not located: {reason}', REJECTED), (where, TEXT)]
    lines = []
    (xx, xy), (_, yy) = location.covariance
    lines.append((
        f'x {location.x:.3f} +- {math.sqrt(xx):.3f} px, y {location.y:.3f} +- '
        f'{math.sqrt(yy):.3f} px, correlation {xy / math.sqrt(xx * yy):.2f}', FOUND,
    ))
    if bearing is not None:
        azimuth, elevation = np.sqrt(bearing.covariance.diagonal())
        lines.append((
            f'azimuth {bearing.azimuth:.3f} +- {azimuth:.3f} mrad, elevation '
            f'{bearing.elevation:.3f} +- {elevation:.3f} mrad', FOUND,
        ))
    lines.append((
        f'SNR {location.snr:.1f}, chi-square {location.chi2:.2f} per degree of freedom, sigma '
        f'{location.sigma:.2f} px, peak {location.amplitude:.1f} DN above '
        f'{location.background:.1f} DN', TEXT,
    ))
    lines.append((
        f'{location.saturated} saturated pixels; {where}',
        CLIPPED if location.saturated else TEXT,
    ))
    return lines

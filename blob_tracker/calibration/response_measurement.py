"""What was measured of a camera's response, and the noise of its pixels before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

from blob_tracker.calibration.frame_pair import LEAST_VARIANCE_DN2
from blob_tracker.calibration.noise_line import fit_noise_line, NoiseLine, QUANTISATION
from blob_tracker.camera.response import linear_full_scale, Response
from blob_tracker.types import Pixels, SensorNoise
import cv2
import numpy as np
from numpy.typing import NDArray

CORRELATED = 0.05  # between neighbours' noise, as in photon transfer
BOX_PX = 5  # px of the box that tells the level of a pixel without its noise
BINS = 24  # of level, in which the variance is told
FEWEST_PIXELS = 400  # of a bin: its variance to 7 %
LIKE_GAMMA = (0.2, 0.9)  # of full scale, between which an exponent is told

Array = NDArray[np.float64]


class ResponseError(ValueError):
    """Frames that tell no response; the message says why and what would."""


@dataclass(frozen=True)
class ResponseMeasurement:
    """
    The response of a camera and how well it is known.

    Parameters
    ----------
    response : Response
        For the parameter `response_url`.
    black_level : (float, float)
        Linear DN of a pixel without light, and its standard deviation.
    exponent : float
        Of the power of the light that the response is nearest to; 1 of a linear camera.
    levels, residuals : (n,) arrays
        Raw DN of the points that it was fitted to, and by how much they are off.
    variances : (3, m) array
        Raw DN, variance in raw DN^2, and variance of that over its square.
    linear_variances : (3, m) array
        The same in linear DN.
    line : NoiseLine or None
        Through the latter; None if no frames come in pairs.
    warnings : tuple of str
        What to know before one relies on it.

    """

    response: Response
    black_level: tuple[float, float]
    exponent: float
    levels: Array
    residuals: Array
    variances: Array
    linear_variances: Array
    line: NoiseLine | None
    warnings: tuple[str, ...]

    @property
    def noise(self) -> SensorNoise | None:
        """Noise of the linear pixels; None if no frames come in pairs."""
        line, black = self.line, self.black_level[0]
        if line is None or line.slope <= 0.0:
            return None
        dark = line.foot + line.slope * black - QUANTISATION
        return SensorNoise(line.gain, sqrt(max(dark, 0.0)), black)


def measured(
    response: Response, black: tuple[float, float], levels: Array, residuals: Array,
    pairs: Sequence[tuple[Pixels, Pixels]], warnings: list[str],
) -> ResponseMeasurement:
    """
    Return what was measured, with the noise of the frames that come in pairs.

    Parameters
    ----------
    response : Response
        That was found.
    black : (float, float)
        Linear DN of a pixel without light, and its standard deviation.
    levels, residuals : (n,) arrays
        Raw DN of the points, and by how much they are off.
    pairs : sequence of pairs of (h, w) arrays
        Frames of one light and scene, raw DN.
    warnings : list of str
        What is known so far.

    """
    raw, linear, line = np.empty((3, 0)), np.empty((3, 0)), None
    step = linear_full_scale(response.saturation) / response.saturation  # linear DN to a raw one
    if black[1] > step:
        warnings.append(
            f'the level of no light is known to {black[1] / step:.0f} raw DN only, and with it '
            'the dark end of the curve: leave out frames with the cap on if some of their pixels '
            'are 0, and add darker exposures'
        )
    if pairs:
        raw, linear = variances_of(pairs, response)
        if linear.shape[1] > 2 and np.ptp(linear[0]) > 0.0:
            line = fit_noise_line(*linear)
        # A camera that does it does it at every level.
        alike = float(np.median([_correlation(*each, response.saturation) for each in pairs]))
        if alike < -CORRELATED:
            warnings.append(
                f"neighbours' noise is correlated ({alike:+.2f}): the camera sharpens. That moves "
                'no light, but draws a dark ring about it, which no response undoes: switch '
                'sharpness off'
            )
        elif alike > CORRELATED:
            warnings.append(
                f"neighbours' noise is correlated ({alike:+.2f}): the frames were compressed, "
                'demosaiced or cleared of noise, and their variance is not that of a pixel'
            )
    return ResponseMeasurement(
        response, black, _exponent(response, black[0]), levels, residuals, raw, linear, line,
        tuple(warnings),
    )


def variances_of(
    pairs: Sequence[tuple[Pixels, Pixels]], response: Response
) -> tuple[Array, Array]:
    """
    Return the temporal variance over the level, of raw pixels and of linear ones.

    Parameters
    ----------
    pairs : sequence of pairs of (h, w) arrays
        Frames of one light and scene, raw DN.
    response : Response
        Makes them linear.

    Returns
    -------
    raw, linear : (3, m) arrays
        Level, variance, and the variance of that over its square, of each level of each pair.

    """
    raw: list[tuple[float, float, float]] = []
    linear: list[tuple[float, float, float]] = []
    for pair in pairs:
        level = cv2.blur(np.add(*pair, dtype=np.float32) * 0.5, (BOX_PX, BOX_PX))
        first, second = pair
        bins = np.minimum(level / response.saturation * BINS, BINS - 1).astype(int)
        usable = (np.maximum(first, second) < response.saturation) & (np.minimum(*pair) > 0)
        both = [np.asarray(each, dtype=np.float64) for each in pair]
        lights = [response.linear_pixels(each).astype(np.float64) for each in pair]
        for k in np.unique(bins):
            inside = bins == k
            count = int(inside.sum())
            if count < FEWEST_PIXELS or not usable[inside].all():
                continue
            found = [_variance(a[inside], b[inside]) for a, b in (both, lights)]
            if found[0][1] > LEAST_VARIANCE_DN2:
                raw.append(found[0])
                linear.append(found[1])
    return (
        np.array(raw, dtype=float).reshape(-1, 3).T, np.array(linear, dtype=float).reshape(-1, 3).T
    )


def _variance(first: Array, second: Array) -> tuple[float, float, float]:
    """Return level, variance, and the variance of that over its square."""
    difference = first - second
    difference -= difference.mean()
    square = float((difference**2).mean())
    kurtosis = float((difference**4).mean()) / square**2 if square > 0.0 else 3.0
    level = 0.5 * float(first.mean() + second.mean())
    return level, 0.5 * square, max(kurtosis - 1.0, 0.5) / first.size


def _correlation(first: Pixels, second: Pixels, full: int) -> float:
    """Return the correlation of neighbours' noise, the worse of right and below."""
    level = cv2.blur(np.add(first, second, dtype=np.float32) * 0.5, (BOX_PX, BOX_PX))
    difference = np.subtract(first, second, dtype=np.float32)
    # The lamp flickers from one to the other.
    level -= level.mean()
    difference -= difference.mean()
    difference -= float((difference * level).sum() / max((level**2).sum(), 1.0)) * level
    low, high = (extreme(first, second) for extreme in (np.minimum, np.maximum))
    usable = (high < full) & (low > 0)
    difference[~usable] = 0.0
    square = float((difference**2).sum()) / max(int(usable.sum()), 1)
    if square < LEAST_VARIANCE_DN2:
        return 0.0
    right, below = (
        float((difference[a] * difference[b]).sum()) / max(int((usable[a] & usable[b]).sum()), 1)
        for a, b in (
            (np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1]),
        )
    )
    return max(right, below, key=abs) / square


def _exponent(response: Response, black: float) -> float:
    """Return the exponent of the power of the light that is nearest to a response."""
    low, high = (each * response.saturation for each in LIKE_GAMMA)
    raw = np.linspace(low, high, 32)
    light = np.interp(raw, response.levels, response.linear) - black
    start = float(np.interp(black, response.linear, response.levels))
    inside = (light > 0.0) & (raw > start)
    slope = np.polyfit(np.log(light[inside]), np.log(raw[inside] - start), 1)[0]
    return float(slope)


def full_scale_of(highest: int) -> int:
    """Return the full scale of the fewest bits that have this value."""
    return int(2 ** next(bits for bits in (8, 10, 12, 14, 16) if highest < 2**bits) - 1)


def monotone(curve: Array) -> Array:
    """Return a curve without what rounding makes fall."""
    grown = np.maximum.accumulate(curve)
    grown[0] = 0.0
    return np.asarray(grown)

"""Statistics of two frames of the same light."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.calibration.noise_line import QUANTISATION
from blob_tracker.types import Pixels
import numpy as np

CLIPPED = 0.0005  # part of the pixels: clipped, it takes as much of the variance; more is too much
LEAST_VARIANCE_DN2 = 0.24  # below it rounding hides the noise (EMVA 1288, section 6.6)
PILED_UP = 0.01  # part of the pixels at the highest value of all that makes it the clipped level
# Of noise and non-uniformity together that spread the pixels over the steps of rounding: the
# 1/12 is then right to 2 exp(-2 pi^2 0.45) = 0.3 %.
LEAST_SPREAD_DN2 = 0.45
BOX_PX = 5  # of the box filter that takes off what the light is uneven by (EMVA 1288, 8.1)


class PhotonTransferError(ValueError):
    """Frames that give no photon transfer; the message says why and what would."""


@dataclass(frozen=True)
class Pair:
    """
    Statistics of two frames of the same light.

    Parameters
    ----------
    dark : bool
        Whether there was none.
    exposure : float or None
        What the light is proportional to: photons, or time; None if it is not known.
    mean : float
        DN.
    variance : float
        Temporal, DN^2: half the variance of the difference of the two (EMVA 1288, eq. 18 to 20,
        in which the change of the mean drops out).
    kurtosis : float
        Of the difference; 3 where the noise is Gaussian.
    spatial_variance : float
        DN^2, of the mean of many frames, without what is smooth over 5 px.
    correlation : float
        Of a pixel's noise with that of its neighbour, the worse of right and below.
    highest : int
        DN of the brightest pixel.
    at_highest, at_zero : float
        Part of the pixels that are at `highest`, and at 0 DN.
    count : int
        Pixels.
    step : int
        Greatest common divisor of the pixels' values, DN.

    """

    dark: bool
    exposure: float | None
    mean: float
    variance: float
    kurtosis: float
    spatial_variance: float
    correlation: float
    highest: int
    at_highest: float
    at_zero: float
    count: int
    step: int

    @property
    def scatter(self) -> float:
        """Variance of the variance over its square."""
        return max(self.kurtosis - 1.0, 0.5) / self.count

    @property
    def shows_noise(self) -> bool:
        """Whether rounding and 0 DN leave the noise as it is."""
        spread = self.variance - QUANTISATION + self.spatial_variance
        return (
            self.at_zero < CLIPPED
            and self.variance > LEAST_VARIANCE_DN2
            and spread > LEAST_SPREAD_DN2
        )


def pair_of(
    first: Pixels, second: Pixels, *, dark: bool = False, exposure: float | None = None
) -> Pair:
    """
    Return the statistics of two frames of the same light.

    Parameters
    ----------
    first, second : (h, w) uint8 or uint16 arrays
        DN.
    dark : bool
        Whether there was no light.
    exposure : float, optional
        What the light is proportional to.

    Raises
    ------
    PhotonTransferError
        If the two differ in size or type.

    """
    import cv2  # no part of a start

    if first.shape != second.shape or first.dtype != second.dtype or first.size < 256:
        raise PhotonTransferError(
            f'a pair is {first.shape[1]} x {first.shape[0]} {first.dtype} and '
            f'{second.shape[1]} x {second.shape[0]} {second.dtype}; both frames must be of one '
            'size and depth, and of 256 pixels or more'
        )
    a, b = first.astype(np.float64), second.astype(np.float64)
    difference = a - b
    difference -= difference.mean()
    square = float((difference**2).mean())
    kurtosis, correlation = 3.0, 0.0
    if square > 0.0:
        kurtosis = float((difference**4).mean()) / square**2
        right = float((difference[:, 1:] * difference[:, :-1]).mean()) / square
        below = float((difference[1:] * difference[:-1]).mean()) / square
        correlation = max(right, below, key=abs)
    # White non-uniformity loses 1 / 25 of its variance to the box.
    flat_a, flat_b = (each - cv2.blur(each, (BOX_PX, BOX_PX)) for each in (a, b))
    spatial = float((flat_a * flat_b).mean()) / (1.0 - 1.0 / BOX_PX**2)
    highest = int(max(first.max(), second.max()))
    return Pair(
        dark=dark,
        exposure=0.0 if dark and exposure is None else exposure,
        mean=0.5 * float(a.mean() + b.mean()),
        variance=0.5 * square * a.size / (a.size - 1),
        kurtosis=kurtosis,
        spatial_variance=spatial,
        correlation=correlation,
        highest=highest,
        at_highest=0.5 * float((first == highest).mean() + (second == highest).mean()),
        at_zero=0.5 * float((first == 0).mean() + (second == 0).mean()),
        count=a.size,
        step=int(np.gcd.reduce(first, axis=None)),
    )

"""Take off the bias that follows the sub-pixel phase, learned from the located positions alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

from blob_tracker.location.estimates import Estimates
from blob_tracker.types import LocationError
import numpy as np
from numpy.typing import ArrayLike, NDArray

LEAST_POSITIONS = 100  # positions: the correction's standard error is then 0.022 px
# 2 J1(1), J1 the Bessel function: the harmonic of a bias of 1 / 2 pi px, which stands still with
# the true phase where it is steepest. Beyond it two true places are located at one.
STEEPEST = 0.88
GAP = 10.0  # even phases leave a gap of (ln M + GAP) / M px with the probability exp(-GAP)


@dataclass(frozen=True)
class PhaseCorrection:
    """
    The first harmonic of the density of located phases, along x and along y.

    Parameters
    ----------
    x, y : (float, float)
        a and b of `learn_phase_correction`, no unit.
    count : int
        Positions that it was learned from.

    Examples
    --------
    Of 400 positions:

    >>> correction = PhaseCorrection(x=(-0.3, 0.0), y=(0.0, 0.0), count=400)
    >>> round(correction.standard_error, 3)  # px
    0.011

    """

    x: tuple[float, float]
    y: tuple[float, float]
    count: int

    @property
    def standard_error(self) -> float:
        """Return the standard error of the correction, px: the same at all phases, in x and y."""
        return 1.0 / (math.pi * math.sqrt(2.0 * self.count))


def learn_phase_correction(x: ArrayLike, y: ArrayLike) -> PhaseCorrection:
    r"""
    Learn the bias against sub-pixel phase from where M blobs were located, without their truth.

    Let the true phases t of many blobs be spread evenly over the pixel, and let a method locate
    each at the phase f(t) = t + bias(t). The density p of the located phases is then the slope
    of the inverse map, p(f) = dt / df, and its integral the inverse map itself: equalising the
    histogram of the phases takes the bias off, up to a constant. Of the density

        p(f) = 1 + a cos 2 pi f + b sin 2 pi f + ...
        a = 2 mean(cos 2 pi f),   b = 2 mean(sin 2 pi f)

    the first harmonic is kept, which is nearly all of a smooth bias:

        t = f + (a sin 2 pi f - b cos 2 pi f) / 2 pi

    Left over of a sine of A px is its second harmonic, some pi A^2 px (0.01 px where A is 0.06).
    Var a = Var b = 2 / M, so the correction's standard error is 1 / (pi sqrt(2 M)) =
    0.225 / sqrt(M) px: a few hundred positions, of one lens, one method and one range of SNR.
    Noise of s px damps a and b by exp(-2 (pi s)^2), 5 % at 0.05 px.

    The phases alone cannot tell a target that drifts over a short way from a bias: L px leave a
    harmonic of up to 1 / (pi^2 L) px. Learn from stars all over the frame, or from a target
    that crosses some tens of pixels.

    Parameters
    ----------
    x, y : (M,) arrays
        Located positions, px of the image that was located in. Whole pixels do not matter:
        coordinates of windows will do as well as those of the frame.

    Returns
    -------
    PhaseCorrection
        For `correct_phase`.

    Raises
    ------
    LocationError
        If there are fewer than 100 positions, where they are not two (M,) arrays of finite
        numbers, or where a pixel-phase bias cannot have made their phases: a still target,
        positions that are locked to the grid, a part of the pixel in which none lies.

    Notes
    -----
    Anderson and King, PASP 112 (2000) 1360, describe the bias, their pixel-phase error, and its
    cause: a wrong model of an undersampled pulse. The equation here is no more than the change
    of variables of a density, p(f) df = dt.

    Examples
    --------
    Phases of a method that errs by 0.05 px times the sine of the phase:

    >>> true = np.linspace(0.0, 21.0, 400, endpoint=False)
    >>> located = true + 0.05 * np.sin(2.0 * np.pi * true)
    >>> correction = learn_phase_correction(located, located)
    >>> round(correction.standard_error, 3)  # px
    0.011
    >>> round(correction.x[0], 2)
    -0.31

    """
    axes = {'x': np.asarray(x, dtype=float), 'y': np.asarray(y, dtype=float)}
    shapes = axes['x'].shape, axes['y'].shape
    if axes['x'].ndim != 1 or shapes[0] != shapes[1]:
        raise LocationError(f'x is {shapes[0]} and y {shapes[1]}; both must be (M,)')
    count = axes['x'].size
    if count < LEAST_POSITIONS:
        raise LocationError(
            f'{count} positions are too few to learn a phase correction from; '
            f'it takes {LEAST_POSITIONS} or more'
        )
    if not all(np.isfinite(axis).all() for axis in axes.values()):
        raise LocationError('positions to learn from hold NaN or infinity; leave those out')
    return PhaseCorrection(_first_harmonic(axes['x'], 'x'), _first_harmonic(axes['y'], 'y'), count)


def correct_phase(estimates: Estimates, correction: PhaseCorrection) -> Estimates:
    r"""
    Return the estimates with the phase correction applied, and the covariance that then holds.

    Along each axis, with J = 1 + a cos 2 pi x + b sin 2 pi x the slope of the correction and s
    its standard error,

        x' = x + (a sin 2 pi x - b cos 2 pi x) / 2 pi
        Cov' = J Cov J + s^2 I

    The s^2 is an error that all positions of one phase have in common: averaging over them does
    not lessen it. A blob on the very edge of its window may be moved across it, by 0.14 px
    at most.

    Parameters
    ----------
    estimates : Estimates
        N locations by the method, on pulses of the shape, that the correction was learned from.
    correction : PhaseCorrection
        From `learn_phase_correction`.

    Returns
    -------
    Estimates
        Positions in px and covariance in px^2 corrected, the rest unchanged.

    Examples
    --------
    A method that errs by 0.05 px times the sine of the phase, a quarter of a pixel from the grid:

    >>> from blob_tracker.location import locate_batch
    >>> from blob_tracker.types import SensorNoise
    >>> y, x = np.mgrid[:15, :15]
    >>> pulse = 150.0 * np.exp(-((x - 7.25) ** 2 + (y - 7.0) ** 2) / (2.0 * 2.0**2))
    >>> estimates = locate_batch([40.0 + pulse], noise=SensorNoise(gain=40.0, read_noise=0.7))
    >>> correction = PhaseCorrection(x=(-0.3, 0.0), y=(0.0, 0.0), count=400)
    >>> corrected = correct_phase(estimates, correction)
    >>> round(float(estimates.x[0]), 2), round(float(corrected.x[0]), 2)  # px
    (7.25, 7.2)

    """
    with np.errstate(invalid='ignore'):  # what has failed may hold anything
        x, slope_x = _apply(estimates.x, correction.x)
        y, slope_y = _apply(estimates.y, correction.y)
        slopes = np.stack([slope_x, slope_y], axis=1)
        covariance = estimates.covariance * slopes[:, :, None] * slopes[:, None, :]
    return replace(
        estimates, x=x, y=y, covariance=covariance + correction.standard_error**2 * np.eye(2)
    )


def _apply(
    position: NDArray[np.float64], harmonic: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corrected positions, px, and the slope of the correction."""
    a, b = harmonic
    sine, cosine = np.sin(2.0 * np.pi * position), np.cos(2.0 * np.pi * position)
    moved = position + (a * sine - b * cosine) / (2.0 * np.pi)
    return moved, 1.0 + a * cosine + b * sine


def _first_harmonic(position: NDArray[np.float64], axis: str) -> tuple[float, float]:
    """Return a and b, or raise LocationError where they cannot be those of a bias."""
    turn = 2.0 * np.pi * position
    a, b = 2.0 * float(np.cos(turn).mean()), 2.0 * float(np.sin(turn).mean())
    strength = math.hypot(a, b)
    if strength > STEEPEST:
        raise LocationError(
            f'the positions are locked to the pixel grid along {axis}: their first harmonic is '
            f'{strength:.2f}, a bias alone makes {STEEPEST} at most; '
            'let the target move over many pixels'
        )
    phases = np.sort(np.mod(_apply(position, (a, b))[0], 1.0))
    gap = float(np.diff(phases, append=phases[0] + 1.0).max())
    limit = (math.log(position.size) + GAP) / position.size
    if gap > limit:
        raise LocationError(
            f'the positions leave {gap:.2f} px of the pixel empty along {axis}, {limit:.2f} px '
            'at most if they are spread evenly; let the target move over many pixels'
        )
    return a, b

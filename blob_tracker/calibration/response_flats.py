"""The response of a camera from pairs of flat frames: photon transfer, taken backwards."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from blob_tracker.calibration.frame_pair import (
    CLIPPED, LEAST_VARIANCE_DN2, Pair, pair_of, PILED_UP,
)
from blob_tracker.calibration.noise_line import QUANTISATION
from blob_tracker.calibration.response_measurement import (
    full_scale_of, measured, monotone, ResponseError, ResponseMeasurement,
)
from blob_tracker.camera.response import linear_full_scale, Response
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads interpolate when it is first used

KNOTS = 65  # of the response that is written
LEAST_SPAN = 0.5  # of the levels up to saturation that the tiles have to cover
READ_NOISE_E = 5.0  # e-, of the sensors of webcams: 2 to 10
READ_NOISE_DOUBT = 0.5  # of it
FEWEST_FLATS = 6  # levels of light, between which the variance is interpolated

Array = NDArray[np.float64]


def response_of_flats(
    flats: Sequence[tuple[Pixels, Pixels]], *, dark: tuple[Pixels, Pixels] | None = None,
    saturation: int | None = None, read_noise: float = READ_NOISE_E, camera: str = '',
    pixel_format: str = '', sensor: tuple[int, int] | None = None,
) -> ResponseMeasurement:
    r"""
    Return the response from pairs of flat frames whose light is not known.

    A sensor has the variance N + r^2 of N electrons and the read noise r. The response makes of
    it d'(N)^2 (N + r^2) in raw DN, so that along the levels

        A(d) = integral of (v(d) - 1/12)^(-1/2) from the level of no light,    N = r A + A^2 / 4

    with v the variance of a pixel over its level. The light does not enter, nor its time. That
    leaves r open: it bends the response where it is dark, and is taken from the data sheet.

    Parameters
    ----------
    flats : sequence of pairs of (h, w) arrays
        Raw DN, the two of a pair of one light: six lights or more, from dark to clipped.
    dark : pair of arrays, optional
        The same with the cap on: the level of no light. 0 DN if left out.
    saturation : int, optional
        DN of a clipped pixel, where it is known.
    read_noise : float
        r, electrons.
    camera, pixel_format : str
        For the file.
    sensor : (int, int), optional
        Width and height of the full, unbinned sensor, px; if left out, those of the frames.

    Raises
    ------
    ResponseError
        If the lights are too few, all is clipped, or rounding hides the noise.

    Examples
    --------
    Ten lights on a sensor of 20 electrons a DN, whose camera has a gamma of 0.5:

    >>> random = np.random.default_rng(4)
    >>> flats = []
    >>> for level in (2.0, 5.0, 10.0, 20.0, 35.0, 55.0, 80.0, 120.0, 170.0, 300.0):
    ...     light = random.normal(level, np.sqrt(level / 20.0 + 0.09), (2, 120, 160))
    ...     raw = 255.0 * np.sqrt(np.clip(light, 0.0, 255.0) / 255.0)
    ...     flats.append(tuple(raw.round().astype(np.uint8)))
    >>> found = response_of_flats(flats, read_noise=6.0)
    >>> round(found.exponent, 1)
    0.5

    """
    if not flats:
        raise ResponseError('there are no flat frames; pairs at six lights or more are needed')
    pairs = sorted((pair_of(*each) for each in flats), key=lambda each: each.mean)
    full, seen = _clipped_in(pairs, saturation)
    lights = [
        each for each in pairs
        if each.at_zero < CLIPPED and (each.highest < full or each.at_highest < CLIPPED)
    ]
    if not lights:
        raise ResponseError(f'every pair is clipped at {full} DN or at 0; change the light')
    lights = [each for each in lights if each.variance > LEAST_VARIANCE_DN2]
    level = np.array([each.mean for each in lights])
    if level.size < FEWEST_FLATS or np.ptp(level) < LEAST_SPAN * full:
        reach = f' from {level.min():.0f} to {level.max():.0f} DN' if lights else ''
        raise ResponseError(
            f'{level.size} of {len(pairs)} lights show their noise beside the rounding{reach}, '
            f'which are too few for the response; take {FEWEST_FLATS} or more, from dark to '
            f"{full} DN, raise the camera's gain, or take exposures of a still scene"
        )
    black = 0.0 if dark is None else pair_of(*dark).mean
    variance = np.array([each.variance for each in lights])
    scatter = np.array([each.scatter for each in lights])
    knots = np.linspace(0.0, full, KNOTS)
    electrons = _electrons(knots, level, variance, black, read_noise)
    scale = linear_full_scale(full) / electrons[-1]
    curve = scale * electrons
    # What each variance, and the read noise, would move.
    changes = []
    for k in range(level.size):
        moved = variance.copy()
        moved[k] *= 1.0 + sqrt(scatter[k])
        changes.append(_electrons(knots, level, moved, black, read_noise))
    changes += [
        _electrons(knots, level, variance, black, each * read_noise)
        for each in (1.0 - READ_NOISE_DOUBT, 1.0 + READ_NOISE_DOUBT)
    ]
    off = np.array([each / each[-1] * linear_full_scale(full) - curve for each in changes])
    off[-2:] /= sqrt(2.0)
    width, height = sensor or flats[0][0].shape[::-1]
    response = Response(
        knots, monotone(curve), np.sqrt((off**2).sum(axis=0)), width, height,
        8 * flats[0][0].dtype.itemsize, camera, pixel_format,
        f'{len(pairs)} pairs of flat frames, read noise {read_noise:g} e-',
    )
    warnings = [
        f'a read noise of {read_noise:g} e- was assumed: --read-noise has that of the data sheet, '
        'and exposures of a still scene need none'
    ]
    if dark is None:
        warnings.append('no dark frames: the level without light is taken as 0 DN')
    if not seen and saturation is None:
        warnings.append(f'no pixel is clipped; the saturation of {full} DN is what they suggest')
    at_black = float(np.interp(black, knots, response.linear))
    return measured(response, (at_black, 0.0), level, np.zeros(level.size), flats, warnings)


def _electrons(
    knots: Array, level: Array, variance: Array, black: float, read_noise: float
) -> Array:
    """Return the electrons at the knots, of a variance over its level; less than 0 below black."""
    # The deviation changes less than the variance, and goes on as at the first and last level.
    fine = np.linspace(0.0, knots[-1], 16 * (knots.size - 1) + 1)
    deviation = np.sqrt(variance - QUANTISATION)
    inside = np.clip(fine, level[0], level[-1])
    slope = 1.0 / scipy.interpolate.PchipInterpolator(level, deviation)(inside)
    stable = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(fine))])
    stable = (stable - np.interp(black, fine, stable))[::16]
    above = np.maximum(stable, 0.0)
    electrons = read_noise * stable + 0.25 * above**2
    return np.asarray(electrons - electrons[0])


def _clipped_in(pairs: Sequence[Pair], given: int | None) -> tuple[int, bool]:
    """Return the same of flat pairs, whose bright pixels are many."""
    highest = max(each.highest for each in pairs)
    if given is not None:
        return given, highest >= given
    seen = any(each.highest == highest and each.at_highest > PILED_UP for each in pairs)
    return (highest, True) if seen else (full_scale_of(highest), False)

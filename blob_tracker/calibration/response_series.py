"""The response of a camera from exposures of one still scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

from blob_tracker.calibration.frame_pair import CLIPPED
from blob_tracker.calibration.response_measurement import (
    full_scale_of, measured, monotone, ResponseError, ResponseMeasurement,
)
from blob_tracker.camera.response import linear_full_scale, Response
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads optimize when it is first used

NODES = 25  # of the slope, evenly from 0 DN to saturation
SMOOTH = 0.3  # sigma of the slope's second difference, over its mean: ten times that of a gamma
KNOTS = 65  # of the response that is written
TILE = 4  # px a side: 16 pixels have a quarter of the noise
MOST_TILES = 1500
FEWEST_TILES = 40
FEWEST_EXPOSURES = 3  # two leave every curve whose ripples have the period of their ratio
LEAST_RANGE = 2.0  # of the longest exposure over the shortest
LEAST_SPAN = 0.5  # of the levels up to saturation that the tiles have to cover
STEPS = 6  # of Gauss and Newton; after 4 it stands still
TILE_DN = 0.25  # DN, at least: noise of a pixel over 16 of them
LEAST_SLOPE = 0.003  # of the mean: g has an inverse
EXPOSURE_SIGMA = 0.01  # relative: what the times of cameras and the light of lamps are true to
LEAST_RISE = 0.004  # of full scale, from one exposure to the next
OFF = 0.1  # relative, by which a whole frame may be off its exposure
MOVED = 0.012  # of full scale: rms of the tiles about the curve, that noise does not reach

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shot:
    """
    Frames of one exposure.

    Parameters
    ----------
    exposure : float
        Its time, in any unit; 0 of dark frames.
    mean : (h, w) float32 array
        Of all of its frames, DN.
    frames : tuple of (h, w) arrays
        The first one or two of them.
    sensor : (int, int) or None
        Width and height of the full, unbinned sensor, px; None if it is as large as they are.

    Examples
    --------
    Of a single frame, exposed for 10 ms:

    >>> frame = np.full((480, 640), 40, np.uint8)
    >>> shot = Shot(0.01, frame.astype(np.float32), (frame,))
    >>> shot.exposure, shot.mean.shape  # s
    (0.01, (480, 640))

    """

    exposure: float
    mean: NDArray[np.float32]
    frames: tuple[Pixels, ...]
    sensor: tuple[int, int] | None = None


@dataclass(frozen=True)
class Tiles:
    """
    Patches of the scene in all exposures.

    Parameters
    ----------
    levels : (n, j) array
        Mean of each in each exposure, raw DN.
    usable : (n, j) bool array
        Whether no pixel of it is clipped there, at either end.
    exposures : (j,) array
        Times.

    """

    levels: Array
    usable: NDArray[np.bool_]
    exposures: Array


def measure_response(
    shots: Sequence[Shot], *, saturation: int | None = None, camera: str = '',
    pixel_format: str = '',
) -> ResponseMeasurement:
    r"""
    Return the response from exposures of one still scene.

    A patch p of the scene is seen at the level d_pj in the exposure t_j, and the inverse h of the
    response makes of it the light, which is proportional to the time:

        h(d_pj) - b = E_p t_j

    (Mitsunaga and Nayar, CVPR 1999; Debevec and Malik, SIGGRAPH 1997, take the logarithm, which
    has no place for the level b of no light). The slope h' is linear between 25 nodes and
    nowhere below 0. Slope, b, E_p and what each exposure is off by are those that leave the least
    squares of d - g(E t + b) in raw DN, by Gauss and Newton: as least squares of h itself they
    would be biased, since the noisy levels are on both sides. Where there are no points
    the slope goes on straight.

    The covariance is the inverse of the information. It has in it that exposures, of the camera
    and of the lamp, are true to 1 % only: a power of h with the same power of the times is told
    from h by nothing else.

    Parameters
    ----------
    shots : sequence of Shot
        Three exposures or more, and dark frames where there are any.
    saturation : int, optional
        DN of a clipped pixel, where it is known.
    camera, pixel_format : str
        For the file.

    Raises
    ------
    ResponseError
        If exposures are too few or equal, all is clipped, the scene moves or the levels are
        too few, or automatic exposure is on.

    Examples
    --------
    A still scene in six exposures and in the dark, seen by a camera with a gamma of 0.5:

    >>> random = np.random.default_rng(7)
    >>> scene = np.tile(np.linspace(0.5, 15.0, 160), (120, 1))
    >>> shots = []
    >>> for exposure in (0.0, 1.0, 2.0, 4.0, 7.0, 11.0, 17.0):
    ...     light = random.normal(exposure * scene, 0.3 + 0.1 * exposure, (2, *scene.shape))
    ...     raw = 255.0 * np.sqrt(np.clip(light, 0.0, 255.0) / 255.0)
    ...     frames = raw.round().astype(np.uint8)
    ...     shots.append(Shot(exposure, frames.mean(axis=0, dtype=np.float32), tuple(frames)))
    >>> found = measure_response(shots)
    >>> round(found.exponent, 1)
    0.5

    """
    shots = sorted(shots, key=lambda each: each.exposure)
    _check_exposures(shots)
    full, seen = _clipped_at(shots, saturation)
    tiles = _tiles_of(shots, full)
    _check_rise(tiles, full)
    fit = _fit(tiles, full)
    _check_fit(fit, tiles.exposures, full)
    knots = np.linspace(0.0, full, KNOTS)
    parts = _integral(knots, full)
    curve = parts @ fit.slopes
    # Of the light above black, which is what a place is told by.
    sigma = np.sqrt(np.einsum('ki,ij,kj->k', parts, fit.covariance[:NODES, :NODES], parts))
    scale = linear_full_scale(full) / full
    width, height = shots[0].sensor or shots[0].mean.shape[::-1]
    response = Response(
        knots, monotone(scale * curve), scale * sigma, width, height,
        8 * shots[0].frames[0].dtype.itemsize, camera, pixel_format,
        f'{len(shots)} exposures of a still scene',
    )
    warnings = []
    if not seen and saturation is None:
        warnings.append(f'no pixel is clipped; the saturation of {full} DN is what they suggest')
    highest = float(tiles.levels[tiles.usable].max())
    if highest < 0.9 * full:
        warnings.append(
            f'no patch is brighter than {highest:.0f} of {full} DN: above it the response is '
            'drawn on straight; expose longer as well'
        )
    if len({round(float(np.log(b / a)), 2) for a, b in zip(*_steps_of(tiles.exposures))}) == 1:
        warnings.append(
            'each exposure is the same multiple of the one before: a ripple of that period is not '
            'seen by them; take evenly spaced times (2, 4, 6, 8 ...) rather than doubled ones'
        )
    black_sigma = scale * sqrt(fit.covariance[NODES, NODES])
    if shots[0].exposure > 0.0 and black_sigma > scale:
        warnings.append(
            'the level without light is known to a few DN only: take a frame with the cap on as '
            'well, of exposure 0'
        )
    pairs = [each for each in shots if len(each.frames) > 1]
    return measured(
        response, (scale * fit.black, black_sigma),
        tiles.levels[tiles.usable], fit.off,
        [(each.frames[0], each.frames[1]) for each in pairs], warnings,
    )


def _check_exposures(shots: Sequence[Shot]) -> None:
    """Refuse exposures that tell nothing of the response."""
    times = sorted({each.exposure for each in shots if each.exposure > 0.0})
    if len(times) < 2:
        raise ResponseError(
            'all exposures are equal; take eight or so of a still scene, evenly spaced from dark '
            'to clipped'
        )
    if len(times) < FEWEST_EXPOSURES or times[-1] < LEAST_RANGE * times[0]:
        raise ResponseError(
            f'{len(times)} exposures from {times[0]:g} to {times[-1]:g} are too few for the '
            f'response; take {FEWEST_EXPOSURES} or more, the longest {LEAST_RANGE:g} times the '
            'shortest at least'
        )
    first = shots[0].frames[0]
    for each in shots:
        if each.mean.shape != first.shape or each.frames[0].dtype != first.dtype:
            raise ResponseError(
                f'the frames differ in size or depth: {first.shape[1]} x {first.shape[0]} '
                f'{first.dtype} and {each.mean.shape[1]} x {each.mean.shape[0]} '
                f'{each.frames[0].dtype}'
            )


def _clipped_at(shots: Sequence[Shot], given: int | None) -> tuple[int, bool]:
    """Return the DN of a clipped pixel, and whether such pixels were seen."""
    highest = max(int(frame.max()) for each in shots for frame in each.frames)
    if given is not None:
        return given, highest >= given
    piled = max(
        float((frame == highest).mean()) for each in shots for frame in each.frames
    )
    return (highest, True) if piled > CLIPPED else (full_scale_of(highest), False)


def _tiles_of(shots: Sequence[Shot], full: int) -> Tiles:
    """Return the evenest patches of the scene, of all its levels."""
    rows, columns = (size // TILE for size in shots[0].mean.shape)

    def blocks(image: NDArray[np.generic]) -> NDArray[np.generic]:
        return image[:rows * TILE, :columns * TILE].reshape(rows, TILE, columns, TILE)

    levels, usable, rough = [], [], []
    for each in shots:
        level = np.asarray(blocks(each.mean), dtype=np.float64)
        inside = np.ones((rows, columns), dtype=bool)
        for frame in each.frames:
            part = np.asarray(blocks(frame))
            inside &= (part.max(axis=(1, 3)) < full) & (part.min(axis=(1, 3)) > 0)
        levels.append(level.mean(axis=(1, 3)).ravel())
        usable.append(inside.ravel())
        rough.append(np.where(usable[-1], level.std(axis=(1, 3)).ravel(), np.nan))
    level, inside = np.array(levels).T, np.array(usable).T
    seen = inside.sum(axis=1) >= 2
    if not inside.any():
        raise ResponseError(
            f'every frame is clipped at {full} DN or at 0; expose shorter, or light the scene'
        )
    if int(seen.sum()) < FEWEST_TILES:
        raise ResponseError(
            f'{int(seen.sum())} patches of the scene are neither clipped at {full} DN nor at 0 in '
            f'two exposures; {FEWEST_TILES} are needed: set the exposures closer together'
        )
    roughness = np.nanmean(np.array(rough).T[seen], axis=1)
    even = np.flatnonzero(seen)[roughness <= np.median(roughness)]
    # Evenly over the levels: a bright lamp on few patches tells what a wall does not.
    spread = np.nanmean(np.where(inside[even], level[even], np.nan), axis=1)
    order = even[np.argsort(spread, kind='stable')]
    wanted = np.linspace(spread.min(), spread.max(), MOST_TILES // 2)
    apart = order[np.minimum(np.searchsorted(np.sort(spread), wanted), order.size - 1)]
    some = order[np.linspace(0, order.size - 1, MOST_TILES // 2).astype(int)]
    chosen = np.unique(np.concatenate([apart, some]))
    tiles = Tiles(level[chosen], inside[chosen], np.array([each.exposure for each in shots]))
    covered = tiles.levels[tiles.usable]
    if np.ptp(covered) < LEAST_SPAN * full:
        raise ResponseError(
            f'the levels reach from {covered.min():.0f} to {covered.max():.0f} of {full} DN, '
            'which is too little for the response; expose longer and shorter'
        )
    return tiles


def _check_rise(tiles: Tiles, full: int) -> None:
    """Refuse frames that do not get brighter with the exposure."""
    for k in range(1, tiles.exposures.size):
        both = tiles.usable[:, k] & tiles.usable[:, k - 1]
        before, after = tiles.exposures[k - 1], tiles.exposures[k]
        if not both.any() or after == before:
            continue
        rise = float(np.median(tiles.levels[both, k] - tiles.levels[both, k - 1]))
        if rise < LEAST_RISE * full * min(after / max(before, 1e-9) - 1.0, 1.0):
            raise ResponseError(
                f'the frames of the exposure {after:g} are no brighter than those of {before:g} '
                f'({rise:+.1f} DN): automatic exposure or gain is on, the exposures are not in '
                'this order, or the light changed'
            )


def _slopes_at(levels: Array, full: int) -> Array:
    """Return the (n, NODES) part that each node has in the slope at these levels."""
    place = np.clip(levels / full, 0.0, 1.0) * (NODES - 1)
    return np.maximum(1.0 - np.abs(place[:, None] - np.arange(NODES)), 0.0)


def _integral(levels: Array, full: int) -> Array:
    """Return the (n, NODES) part that each node's slope has in h at these levels."""
    step = full / (NODES - 1)
    away = np.clip(levels, 0.0, full)[:, None] / step - np.arange(NODES)
    rising = 0.5 * np.clip(away + 1.0, 0.0, 1.0) ** 2
    falling = 0.5 - 0.5 * (1.0 - np.clip(away, 0.0, 1.0)) ** 2
    whole = rising + falling
    whole[:, 0] -= 0.5  # the half of the first one that lies below 0 DN
    return np.asarray(step * whole)


class _Fit(NamedTuple):
    """Slopes at the nodes, of mean 1; the level of no light in that scale; and how well known."""

    slopes: Array
    black: float
    gains: Array  # by which each exposure is off, relative
    covariance: Array  # of slopes and black level
    off: Array  # of each point from the curve, raw DN


def _fit(tiles: Tiles, full: int) -> _Fit:
    """Return the likeliest response by Gauss and Newton, from a start in which levels are true."""
    rows, columns = np.nonzero(tiles.usable)
    levels, times = tiles.levels[rows, columns], tiles.exposures[columns]
    count, shots = tiles.levels.shape
    fine = np.linspace(0.0, full, 4 * full + 1 if full < 1024 else 4097)
    prior = _prior(full, shots)
    slopes, gains, black = np.ones(NODES), np.zeros(shots), 0.0
    on_curve, light = levels, np.zeros(levels.size)
    deviation = TILE_DN
    # The middle one of all patches in the darkest exposure: single ones have noise.
    first = np.searchsorted(rows, np.arange(count))  # point of each patch, which has two or more
    darkest = np.array([np.median(levels[columns == columns.min()]) + 1.0])
    for _ in range(STEPS):
        slope = np.maximum(_slopes_at(on_curve, full) @ slopes, LEAST_SLOPE)
        weight = 1.0 / (slope * deviation)
        design = np.zeros((levels.size, NODES + 1 + shots))
        design[:, :NODES], design[:, NODES] = _integral(on_curve, full), -1.0
        design[np.arange(levels.size), NODES + 1 + columns] = -light
        known = slope * (on_curve - levels) - light * gains[columns]
        seen = weight * times * (1.0 + gains[columns])
        norm = np.maximum(np.bincount(rows, seen**2, count), 1e-30)
        weighted = weight[:, None] * np.column_stack([design, known])
        # What each patch's own light takes out of its points.
        share = np.add.reduceat(seen[:, None] * weighted, first)
        left = weighted - seen[:, None] * (share / norm[:, None])[rows]
        q, triangle = np.linalg.qr(np.concatenate([left, prior]))
        lower = np.concatenate([np.full(NODES, LEAST_SLOPE), [0.0], np.full(shots, -0.5)])
        highest = float(_integral(darkest, full)[0] @ slopes)  # that no light may have
        upper = np.concatenate([np.full(NODES, np.inf), [highest], np.full(shots, 0.5)])
        found = scipy.optimize.lsq_linear(
            triangle[:, :-1], triangle[:, -1], bounds=(lower, upper), method='bvls'
        ).x
        slopes, black = found[:NODES], float(found[NODES])
        told = _integral(on_curve, full) @ slopes - black - slope * (on_curve - levels)
        told -= light * (found[NODES + 1:] - gains)[columns]
        radiance = np.bincount(rows, seen * weight * told, count) / norm
        gains = found[NODES + 1:]
        light = radiance[rows] * times
        curve = _integral(fine, full) @ slopes
        on_curve = np.interp(black + light * (1.0 + gains[columns]), curve, fine)
        deviation = max(float(np.std(levels - on_curve)), TILE_DN)
    free = (found > lower) & (found < upper)
    covariance = np.zeros((found.size, found.size))
    inverse = np.linalg.pinv(triangle[:, :-1][:, free])
    covariance[np.ix_(free, free)] = inverse @ inverse.T
    return _Fit(slopes, black, gains, covariance[:NODES + 1, :NODES + 1], levels - on_curve)


def _prior(full: int, shots: int) -> Array:
    """Return rows for what is known beforehand, with their right side last."""
    rows = np.zeros((NODES - 1 + shots, NODES + 2 + shots))
    for k in range(NODES - 2):
        rows[k, k:k + 3] = np.array([1.0, -2.0, 1.0]) / SMOOTH
    rows[NODES - 2, :NODES] = 1e5 / full * _integral(np.array([float(full)]), full)[0]
    rows[NODES - 2, -1] = 1e5
    for k in range(shots):
        rows[NODES - 1 + k, NODES + 1 + k] = 1.0 / EXPOSURE_SIGMA
    return rows


def _check_fit(fit: _Fit, exposures: Array, full: int) -> None:
    """Refuse a series that no response explains."""
    worst = int(np.abs(fit.gains).argmax())
    if abs(fit.gains[worst]) > OFF:
        raise ResponseError(
            f'the frames of the exposure {exposures[worst]:g} are {fit.gains[worst]:+.0%} off the '
            'others: automatic exposure or gain is on, an exposure is not what it is said to '
            'be, or the lamp changed'
        )
    spread = sqrt(float((fit.off**2).mean()))
    if spread > MOVED * full:
        raise ResponseError(
            f'the patches of the scene are {spread:.1f} DN rms off any response: the scene or the '
            'camera moved, or the camera treats parts of the picture differently (local contrast)'
        )


def _steps_of(exposures: Array) -> tuple[Array, Array]:
    """Return each exposure and the next longer one."""
    times = np.unique(exposures[exposures > 0.0])
    return times[:-1], times[1:]

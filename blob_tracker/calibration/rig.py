"""Poses and clocks of any number of cameras, from one light that is waved before them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

from blob_tracker.calibration.light_path import covered, LightPath
from blob_tracker.calibration.path_equations import tally, without_strays
from blob_tracker.calibration.rays import DARK_S, Rays
from blob_tracker.calibration.rig_equations import Equations, Measured, Unknown
from blob_tracker.calibration.rig_start import meeting_points, RigError, Start, start_rig
from blob_tracker.calibration.scatter import variance_factor
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_SECONDS = 5.0  # s of the light seen by two cameras
KNOTS = 1.5  # intervals of the slowest camera between two knots: six numbers for three unknown
LONGEST_S = 3600.0  # s: stamps further apart are of other clocks, or none
LONGEST = 2.5  # intervals of a camera across which its rays are interpolated for the start
MOST_LEFT_OUT = 0.2  # of a camera's rays: with more, it is not the light that is odd
RESTRAINT = 0.3  # of the path's extent: third differences of its knots are far less
VAGUE, WORTHLESS = 0.02, 0.05  # of the distance: a camera's position that is known no better
LONGEST_WAND_M = 20.0


@dataclass(frozen=True)
class RigCalibration:
    """
    Where the cameras of a rig are.

    Parameters
    ----------
    names : tuple of str
        Of the cameras.
    rotations : (n, 3, 3) array
        Take components in each camera's optical frame to those in the first one's.
    positions : (n, 3) array
        Of the optical centres in the first camera's optical frame, m; in units of the distance of
        the first two that were placed if nothing tells the scale.
    offsets : (n,) array
        By which each clock is ahead of the first one's, s.
    covariance : (7 n, 7 n) array
        Of each camera's turn about its own axes (rad), position and clock, in that order; 0 for
        the first camera.
    residuals : (n,) array
        rms of each camera's residuals over their standard deviations, 1 where these are right:
        each ray has its share of the degrees of freedom.
    used, left_out : (n,) arrays
        How many rays of each camera were used, and how many were left out since they pass by.
    chi2 : float
        Squared residuals over their variances.
    freedom : int
        Its degrees of freedom.
    factor : float
        By which the covariance was multiplied, since the scatter said so.
    path : (m, 3) array
        Where the lights were, in the unit of the positions.
    is_metric : bool
        Whether the scale is known.
    notes : tuple of str
        What is to be known of it, a sentence each.

    Examples
    --------
    Two cameras, 2 m apart, whose places are known to 3 mm:

    >>> found = RigCalibration(
    ...     ('left', 'right'), np.stack([np.eye(3)] * 2), np.array([[0.0] * 3, [2.0, 0.0, 0.0]]),
    ...     np.array([0.0, 0.002]), np.diag([0.0] * 7 + [1e-6] * 3 + [9e-6] * 3 + [1e-10]),
    ...     residuals=np.ones(2), used=np.array([600, 590]), left_out=np.array([0, 10]),
    ...     chi2=2380.0, freedom=2300, factor=1.0, path=np.zeros((0, 3)), is_metric=True, notes=(),
    ... )
    >>> found.position_sigmas.round(4).tolist()  # m
    [0.0, 0.003]
    >>> found.offset_sigmas.round(6).tolist()  # s
    [0.0, 1e-05]

    """

    names: tuple[str, ...]
    rotations: Array
    positions: Array
    offsets: Array
    covariance: Array
    residuals: Array
    used: NDArray[np.intp]
    left_out: NDArray[np.intp]
    chi2: float
    freedom: int
    factor: float
    path: Array
    is_metric: bool
    notes: tuple[str, ...]

    @property
    def rotation_sigmas(self) -> Array:
        """Return the standard deviation of each turn about an axis, rms of three, rad, (n,)."""
        return self._sigmas(0)

    @property
    def position_sigmas(self) -> Array:
        """Return the standard deviation of each position along an axis, rms of three, (n,)."""
        return self._sigmas(3)

    @property
    def offset_sigmas(self) -> Array:
        """Return the standard deviation of each clock's offset, s, (n,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[6::7]))

    def _sigmas(self, first: int) -> Array:
        variances = np.diag(self.covariance).reshape(-1, 7)[:, first:first + 3]
        return np.asarray(np.sqrt(variances.mean(axis=1)))


def calibrate_rig(
    rays: Sequence[Sequence[Rays]],
    names: Sequence[str],
    *,
    baseline: tuple[str, str, float, float] | None = None,
    wand: tuple[float, float] | None = None,
    most_offset: float = 0.2,
) -> RigCalibration:
    """
    Place cameras by the rays to one light, or to the two ends of a wand, that moved before them.

    Camera i, turned by R_i, at p_i, with a clock that is d_i ahead, sees at its time t the light
    in the direction

        h(R_i^T (X(t - d_i) - p_i)),    h(p) = (atan2(p_x, p_z), atan2(-p_y, hypot(p_x, p_z)))

    where X is a cubic spline. All R_i, p_i, d_i and the coefficients of X are those of maximum
    likelihood, by Levenberg-Marquardt steps; since a ray has to do with four coefficients, the
    equations of X are banded and are eliminated (Triggs et al., Bundle Adjustment - A Modern
    Synthesis, 1999, section 6; a path in continuous time as in Furgale, Rehder & Siegwart,
    Unified Temporal and Spatial Calibration for Multi-Sensor Systems, IROS 2013). The covariance
    is the inverse of the reduced information. No two cameras need to see at one instant.

    Parameters
    ----------
    rays : sequence of sequences of Rays
        Of each camera, to each of one or two lights.
    names : sequence of str
        Of the cameras; the first one's frame and clock are those of the result.
    baseline : (str, str, float, float), optional
        Two cameras, how far apart they are, m, and the standard deviation of that.
    wand : (float, float), optional
        How far apart two lights are, m, and the standard deviation of that.
    most_offset : float
        Greatest offset between two clocks that is looked for, s.

    Returns
    -------
    RigCalibration
        With sigmas that hold for these rays; without a baseline or a wand it has no scale.

    Raises
    ------
    RigError
        If there are fewer than two cameras, too few rays, no such rig, or a length that is
        invalid.

    Examples
    --------
    Two cameras, 2 m apart, the second with a clock that is 2 ms ahead, before which a wand of
    0.5 m is waved for 12 s:

    >>> from blob_tracker.simulation.waved_light import RigCamera, WavedLight
    >>> random = np.random.default_rng(1)
    >>> wand = WavedLight(random, wand=0.5)
    >>> cameras = RigCamera((-1.0, 0.0, 0.0)), RigCamera((1.0, 0.0, 0.0), offset=0.002)
    >>> rays = [
    ...     [Rays(*wand.seen(camera, end, 12.0, 1e-4, random)) for end in (0, 1)]
    ...     for camera in cameras
    ... ]
    >>> found = calibrate_rig(rays, ('left', 'right'), wand=(0.5, 1e-4))
    >>> round(float(np.linalg.norm(found.positions[1])), 2)  # m
    2.0
    >>> round(float(1e3 * found.offsets[1]), 1)  # ms
    2.0

    """
    _check(rays, names, baseline, wand)
    interval = _interval(rays, names)
    even = [[each.without_leaps() for each in of_camera] for of_camera in rays]
    start = start_rig(even, names, longest=LONGEST * interval, most_offset=most_offset)
    spacing = KNOTS * interval
    lights = range(len(rays[0]))
    path = covered(
        [
            [of_camera[light].times - offset
             for of_camera, offset in zip(rays, start.offsets, strict=True)]
            for light in lights
        ],
        spacing,
    )
    if path.intervals.sum() * spacing < LEAST_SECONDS:
        raise RigError(
            f'two cameras saw the light together for {path.intervals.sum() * spacing:.2f} s only, '
            f'in pieces long enough; {LEAST_SECONDS:g} s are the least, half a minute is good'
        )
    measured = Measured.of(rays)
    unknown = _first_path(even, start, path, LONGEST * interval)
    scale_pair = _scale_pair(baseline, names, start)
    if wand is None:
        equations = Equations(measured, path, scale_pair, None, RESTRAINT)
    else:
        unknown = unknown.scaled(wand[0] / unknown.rod_length())
        equations = Equations(measured, path, None, wand[0], RESTRAINT)
    try:
        unknown, chi2, weight = without_strays(equations, unknown)
    except np.linalg.LinAlgError:
        raise RigError(
            'the rays determine no rig: are their covariances right, and do the clocks run evenly?'
        ) from None
    by_ray = equations.chi2_of_rays(unknown)
    freedom = equations.freedom(unknown, weight)
    used, left_out, sums = tally(measured.camera, by_ray, weight, len(names))
    _check_left_out(used, left_out, names)
    factor = variance_factor(chi2, freedom, known=True)
    degrees = used * max(freedom, 1) / used.sum()
    covariance = factor * equations.covariance(unknown, weight)
    relative = 0.0
    if baseline is not None:
        one, other = scale_pair
        length = float(np.linalg.norm(unknown.positions[one] - unknown.positions[other]))
        unknown = unknown.scaled(baseline[2] / length)
        covariance = _in_metres(covariance, baseline[2] / length)
        relative = baseline[3] / baseline[2]
    elif wand is not None:
        relative = wand[1] / wand[0]
    along = np.zeros((len(names), 7))
    along[:, 3:6] = unknown.positions
    covariance = covariance + relative**2 * np.outer(along.ravel(), along.ravel())
    result = RigCalibration(
        names=tuple(names),
        rotations=unknown.rotations,
        positions=unknown.positions,
        offsets=unknown.offsets,
        covariance=covariance,
        residuals=np.sqrt(sums / np.maximum(degrees, 1.0)),
        used=used,
        left_out=left_out,
        chi2=chi2,
        freedom=freedom,
        factor=factor,
        path=unknown.middles(path),
        is_metric=baseline is not None or wand is not None,
        notes=(),
    )
    _check_distances(result)
    return replace(result, notes=tuple(_notes(result)))


def _check(
    rays: Sequence[Sequence[Rays]], names: Sequence[str],
    baseline: tuple[str, str, float, float] | None, wand: tuple[float, float] | None,
) -> None:
    if len(names) < 2:
        raise RigError(f'{len(names)} camera; a rig has two or more')
    if len(set(names)) < len(names):
        raise RigError(f'two cameras have one name: {", ".join(names)}')
    if wand is not None and len(rays[0]) != 2:
        raise RigError(f'a wand has two lights; there are rays of {len(rays[0])}')
    if wand is not None and baseline is not None:
        raise RigError('give the length of the wand or that of a baseline, not both')
    for what, length in (('wand', wand), ('baseline', baseline and baseline[2:])):
        if length and what == 'wand' and length[0] > LONGEST_WAND_M:
            raise RigError(f'a wand of {length[0]:g} m; its length is in metres')
        if length and not (0.0 < length[0] < math.inf and 0.0 <= length[1] < length[0]):
            raise RigError(
                f'the {what} is {length[0]:g} m long with a deviation of {length[1]:g} m; a '
                'length is above 0 and above its standard deviation'
            )
    if baseline is not None:
        for name in baseline[:2]:
            if name not in names:
                raise RigError(f'no camera is called {name}; there are {", ".join(names)}')
        if baseline[0] == baseline[1]:
            raise RigError(f'a baseline is between two cameras, not {baseline[0]} and itself')


def _interval(rays: Sequence[Sequence[Rays]], names: Sequence[str]) -> float:
    """Return the time between two rays of the slowest camera, s."""
    longest = 0.0
    for of_camera, name in zip(rays, names, strict=True):
        if min(len(each.times) for each in of_camera) < 2:
            raise RigError(f'{name} has no rays of the light, or of one light of the wand')
        own = float(np.nanmean([each.interval() for each in of_camera]))
        if np.isnan(own):
            raise RigError(f'{name} has rays more than {DARK_S:g} s apart only')
        longest = max(longest, own)
    times = np.concatenate([each.times for of_camera in rays for each in of_camera])
    if np.ptp(times) > LONGEST_S:
        raise RigError(
            f'the stamps of the rays are {np.ptp(times):.6g} s apart: are they of one recording, '
            'and the clocks set? Some may be 0'
        )
    return longest


def _first_path(
    rays: Sequence[Sequence[Rays]], start: Start, path: LightPath, longest: float
) -> Unknown:
    """Return the unknown as they begin, with the path through the points that the start tells."""
    lights = []
    for light in range(len(rays[0])):
        times = np.unique(np.concatenate(
            [each[light].times - offset for each, offset in zip(rays, start.offsets, strict=True)]
        ))
        seen = np.stack([
            each[light].at(times + offset, longest) @ rotation.T
            for each, offset, rotation in zip(rays, start.offsets, start.rotations, strict=True)
        ], axis=1)
        places = meeting_points(seen, start.positions)
        known = np.isfinite(places[:, 0])
        if not known.any():
            raise RigError('the rays of the light meet nowhere ahead of the cameras')
        lights.append((times[known], places[known]))
    return Unknown.through(path, lights, start.rotations, start.positions, start.offsets)


def _scale_pair(
    baseline: tuple[str, str, float, float] | None, names: Sequence[str], start: Start
) -> tuple[int, int]:
    """Return the cameras whose distance is kept while all else is fitted."""
    if baseline is not None:
        return names.index(baseline[0]), names.index(baseline[1])
    return 0, int(np.argmax(np.linalg.norm(start.positions, axis=1)))


def _check_left_out(
    used: NDArray[np.intp], left_out: NDArray[np.intp], names: Sequence[str]
) -> None:
    for name, kept, gone in zip(names, used.tolist(), left_out.tolist(), strict=True):
        if gone > MOST_LEFT_OUT * (kept + gone):
            raise RigError(
                f'{gone} of {kept + gone} rays of {name} pass the light by more than their '
                'covariance allows: is it the same light, and is the lens calibrated? A light '
                'that is waved faster than the cameras can follow does it too'
            )


def _check_distances(result: RigCalibration) -> None:
    """Refuse cameras so near together, for the light's distance, that none is placed."""
    others = np.linalg.norm(result.positions[:, None] - result.positions, axis=2)
    np.fill_diagonal(others, np.inf)
    for name, sigma, distance in zip(
        result.names[1:], result.position_sigmas[1:], others.min(axis=1)[1:], strict=True
    ):
        if not sigma < WORTHLESS * distance:
            raise RigError(
                f'{name} stands {distance:.3g} from the next camera, and its position is known to '
                f'{sigma:.2g} only: put the cameras further apart, or wave the light nearer'
            )


def _in_metres(covariance: Array, scale: float) -> Array:
    """Return the covariance with positions in another unit."""
    factors = np.ones(len(covariance)).reshape(-1, 7)
    factors[:, 3:6] = scale
    return np.asarray(covariance * np.outer(factors.ravel(), factors.ravel()))


def _notes(result: RigCalibration) -> list[str]:
    notes = []
    if not result.is_metric:
        notes.append(
            'the scale is unknown: positions are in units of a distance between two cameras; give '
            'a wand of two lights, or the distance of two cameras'
        )
    if result.factor > 1.0:
        notes.append(
            f'the residuals are {result.factor**0.5:.2f} times what the covariances of the rays '
            'say, and the sigmas were grown by it: a lens that is not calibrated well, a light '
            'that moved too fast for the frame rate, or a clock that is not even'
        )
    distances = np.linalg.norm(result.positions - result.positions[0], axis=1)
    for name, sigma, distance in zip(
        result.names[1:], result.position_sigmas[1:], distances[1:], strict=True
    ):
        if sigma > VAGUE * distance:
            notes.append(
                f'the position of {name} is known to {100.0 * sigma / distance:.1f} % of its '
                'distance only: wave the light longer, nearer and through more of both pictures'
            )
    for name, gone in zip(result.names, result.left_out.tolist(), strict=True):
        if gone:
            notes.append(f'rays of {name} left out since they pass the light by: {gone}')
    return notes

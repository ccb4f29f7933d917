"""Where the lights of a body are, from turning it before one camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

from blob_tracker.calibration.body_equations import Equations, loose, Measured, Unknown
from blob_tracker.calibration.body_start import (
    BodyCalibrationError, is_flat, LEAST_LIGHTS, Start, start_body,
)
from blob_tracker.calibration.light_path import covered, LightPath
from blob_tracker.calibration.path_equations import GATE, tally, without_strays
from blob_tracker.calibration.rays import Rays
from blob_tracker.calibration.scatter import variance_factor
from blob_tracker.constellation.body import in_line
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

KNOTS = 1.5  # intervals of the slowest light between two knots: 12 numbers for 6 unknown, or more
LONGEST = 2.5  # intervals of a light across which its rays are interpolated for the start
LEAST_SECONDS = 3.0  # s in which four lights are seen
MOST_LENGTH_M = 5.0  # of a body that somebody turns
RESTRAINT = 0.3  # rad, and of the distance: third differences of the knots are far less
MOST_LEFT_OUT = 0.2  # of a light's rays: with more it is not rigid with the others
AMBIGUOUS = 25.0  # of chi-square, as by five sigma
VAGUE, WORTHLESS = 0.01, 0.05  # of the body's size: a place that is known no better


@dataclass(frozen=True)
class BodyCalibration:
    """
    Where the lights of a body are.

    Parameters
    ----------
    names : tuple of str
        Of the lights.
    places : (n, 3) array
        In the body's frame, m; in units of the first distance from the camera if no length is
        given.
    covariance : (3 n, 3 n) array
        Of the places among each other: of their errors those parts are left out that shift or
        turn all of them, which are in the pose, and that of the length that was measured.
    size_sigma : float
        Standard deviation of the size by that length, over the size; 0 if none is given.
    frame : (str, str, str)
        The lights that make the frame: its origin, one on its x axis, and one on the side of its
        y axis.
    residuals : (n,) array
        rms of each light's residuals over their standard deviations, 1 where these are right:
        over its share of the degrees of freedom, by the number of its rays.
    used, left_out : (n,) arrays
        How many rays of each light were used, and how many were left out since they pass by.
    chi2 : float
        Squared residuals over their variances.
    freedom : int
        Its degrees of freedom.
    factor : float
        By which the covariance was multiplied, since the scatter said so.
    turned : float
        Greatest angle between two turns of the body, rad.
    is_metric : bool
        Whether the size is known.
    notes : tuple of str
        What is to be known of it, a sentence each.

    """

    names: tuple[str, ...]
    places: Array
    covariance: Array
    size_sigma: float
    frame: tuple[str, str, str]
    residuals: Array
    used: NDArray[np.intp]
    left_out: NDArray[np.intp]
    chi2: float
    freedom: int
    factor: float
    turned: float
    is_metric: bool
    notes: tuple[str, ...]

    @property
    def sigmas(self) -> Array:
        """Return the standard deviation of each place along an axis, rms of three, (n,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance).reshape(-1, 3).mean(axis=1)))


def calibrate_body(
    rays: Sequence[Rays],
    names: Sequence[str],
    *,
    distance: tuple[str, str, float, float] | None = None,
    frame: Sequence[str] = (),
) -> BodyCalibration:
    """
    Find the lights of a rigid body by the rays of one camera before which it is turned.

    Light k at X_k of the body is seen at the time t in the direction

        h(R(t) X_k + p(t)),    h(x) = (atan2(x_1, x_3), atan2(-x_2, hypot(x_1, x_3)))

    where p is a cubic spline and R(t) the turn by a cubic spline of unit quaternions, of length 1
    again. All X_k and the coefficients of both are those of maximum likelihood, by
    Levenberg-Marquardt steps; a ray has to do with four coefficients, and their equations are
    banded and are eliminated, as in `calibrate_rig`. So no two lights need to be seen at one
    instant. The covariance is the inverse of the reduced information in the inner gauge (Triggs
    et al., Bundle Adjustment - A Modern Synthesis, 1999, section 9): rays tell neither where the
    body's own frame is nor its size.

    Parameters
    ----------
    rays : sequence of Rays
        Of each light, by one camera and its clock.
    names : sequence of str
        Of the lights.
    distance : (str, str, float, float), optional
        Two lights, how far apart they are, m, and the standard deviation of that.
    frame : sequence of str, optional
        Three lights: the origin, one on the x axis, and one on the side of y. If it is left out,
        the two of `distance`, or the first two, and the light that is furthest from their
        line.

    Returns
    -------
    BodyCalibration
        With sigmas that hold for these rays; without a distance it has no size.

    Raises
    ------
    BodyCalibrationError
        If there are fewer than four lights, they are in one line or were never seen together,
        the body is not rigid, was turned too little or is too far away, or a length is invalid.

    """
    _check(rays, names, distance, frame)
    interval = max(each.interval() for each in rays)
    path = covered([[each.times for each in rays]], KNOTS * interval, LEAST_LIGHTS)
    if path.intervals.sum() * path.spacing < LEAST_SECONDS:
        raise BodyCalibrationError(
            f'{LEAST_LIGHTS} lights were seen together for '
            f'{path.intervals.sum() * path.spacing:.2f} s only; {LEAST_SECONDS:g} s are the '
            'least, half a minute is good'
        )
    equations = Equations(
        Measured.along(list(rays), path), path, np.array([RESTRAINT, RESTRAINT])
    )
    found = sorted(
        (_adjusted(equations, each, path) for each in start_body(rays, names, LONGEST * interval)),
        key=lambda each: _cost(equations.chi2_of_rays(each[0])),
    )
    unknown, chi2, weight = found[0]
    of_rays = equations.chi2_of_rays(unknown)
    for other, _, _ in found[1:]:
        lead = _cost(equations.chi2_of_rays(other)) - _cost(of_rays)
        if lead < AMBIGUOUS and _is_mirrored(unknown.places, other.places):
            raise BodyCalibrationError(
                'a body and its mirror image explain the rays alike: it is too far away for its '
                'size; bring it nearer to the camera'
            )
    freedom = equations.freedom(unknown, weight)
    used, left_out, sums = tally(equations.measured.light, of_rays, weight, len(names))
    _check_left_out(used, left_out, names)
    factor = variance_factor(chi2, freedom, known=True)
    degrees = used * max(freedom, 1) / used.sum()
    result = BodyCalibration(
        tuple(names), unknown.places, factor * equations.linear(unknown, weight).covariance(),
        0.0, _frame(frame, distance, unknown.places, names),
        np.sqrt(sums / np.maximum(degrees, 1.0)),
        used, left_out, chi2, freedom, factor, _turned(unknown.turns), distance is not None, (),
    )
    result = _framed(_sized(result, distance))
    _check_places(result)
    return replace(result, notes=tuple(_notes(result)))


def _adjusted(
    equations: Equations, start: Start, path: LightPath
) -> tuple[Unknown, float, Array]:
    """Return the body of least chi-square from a start, that, and the weights of the rays."""
    unknown = Unknown.through(path, start.places, start.times, start.turns, start.positions)
    try:
        return without_strays(equations, unknown)
    except np.linalg.LinAlgError:
        raise BodyCalibrationError(
            'the rays determine no body: are their covariances right, and was it turned?'
        ) from None


def _cost(of_rays: Array) -> float:
    """Return chi-square, of which a ray that passes by has a fixed part."""
    return float(np.nansum(np.minimum(of_rays, GATE)))


def _is_mirrored(places: Array, other: Array) -> bool:
    """Tell whether places are turned inside out, rather than the same in another frame."""
    one, its = places - places.mean(axis=0), other - other.mean(axis=0)
    return bool(np.linalg.det(one.T @ its) < 0.0 and not is_flat(one))


def _turned(turns: Array) -> float:
    """Return the greatest angle between two turns of a body, rad."""
    some = turns[np.linspace(0, len(turns) - 1, min(len(turns), 200)).astype(np.intp)]
    return float(2.0 * np.arccos(np.clip(np.abs(some @ some.T).min(), 0.0, 1.0)))


def _frame(
    frame: Sequence[str], distance: tuple[str, str, float, float] | None, places: Array,
    names: Sequence[str],
) -> tuple[str, str, str]:
    """Return the lights that make the frame."""
    if frame:
        origin, along, beside = frame
    else:
        origin, along = distance[:2] if distance else names[:2]
        zero, one = (places[names.index(each)] for each in (origin, along))
        away = np.linalg.norm(np.cross(places - zero, one - zero), axis=1)
        beside = names[int(np.argmax(away))]
    three = places[[names.index(each) for each in (origin, along, beside)]]
    if in_line(three):
        raise BodyCalibrationError(
            f'{origin}, {along} and {beside} are in one line and make no frame: name three '
            'others with --frame'
        )
    return origin, along, beside


def _sized(
    result: BodyCalibration, distance: tuple[str, str, float, float] | None
) -> BodyCalibration:
    """Return it in metres."""
    free = loose(result.places)
    rigid = np.eye(len(free)) - free[:, :6] @ free[:, :6].T
    whole = np.eye(len(free)) - free @ free.T
    covariance = whole @ result.covariance @ whole
    if distance is None:
        return replace(result, covariance=covariance)
    one, other = (result.names.index(name) for name in distance[:2])
    between = result.places[one] - result.places[other]
    length = float(np.linalg.norm(between))
    factor = distance[2] / length
    beside = (result.places - result.places.mean(axis=0)).ravel()
    # Places that err along the line of the two err all in their size.
    along = np.zeros(len(free))
    along[3 * one:3 * one + 3], along[3 * other:3 * other + 3] = between, -between
    sizing = np.eye(len(free)) - np.outer(beside, along / length**2)
    covariance = factor**2 * rigid @ sizing @ covariance @ sizing.T @ rigid
    return replace(
        result, places=factor * result.places, covariance=covariance,
        size_sigma=distance[3] / distance[2],
    )


def _framed(result: BodyCalibration) -> BodyCalibration:
    """Return it in the frame of its three lights."""
    origin, along, beside = (result.places[result.names.index(name)] for name in result.frame)
    x = (along - origin) / np.linalg.norm(along - origin)
    z = np.cross(x, beside - origin)
    z /= np.linalg.norm(z)
    axes = np.stack([x, np.cross(z, x), z])
    turn = np.kron(np.eye(len(result.names)), axes)
    return replace(
        result, places=(result.places - origin) @ axes.T,
        covariance=turn @ result.covariance @ turn.T,
    )


def _check(
    rays: Sequence[Rays], names: Sequence[str],
    distance: tuple[str, str, float, float] | None, frame: Sequence[str],
) -> None:
    if len(names) < LEAST_LIGHTS:
        raise BodyCalibrationError(
            f'{len(names)} lights: {", ".join(names)}; a body needs {LEAST_LIGHTS} or more'
        )
    if len(set(names)) < len(names):
        raise BodyCalibrationError(f'two lights have one name: {", ".join(names)}')
    for each, name in zip(rays, names, strict=True):
        if not math.isfinite(each.interval()):
            raise BodyCalibrationError(f'{name} has hardly any rays: {len(each.times)}')
    if frame and len(set(frame)) != 3:
        raise BodyCalibrationError(
            f'{", ".join(frame)}: a frame is made of three lights, its origin, one on x and one '
            'on the side of y'
        )
    for name in [*frame, *(distance[:2] if distance else ())]:
        if name not in names:
            raise BodyCalibrationError(f'no light is called {name}; there are {", ".join(names)}')
    check_distance(distance)


def check_distance(distance: tuple[str, str, float, float] | None) -> None:
    """Refuse what cannot be the distance of two lights, before the body is turned."""
    if distance is None:
        return
    if distance[0] == distance[1]:
        raise BodyCalibrationError(f'a distance is between two lights, not {distance[0]} alone')
    if MOST_LENGTH_M < distance[2] < math.inf:
        raise BodyCalibrationError(
            f'the distance is {distance[2]:g} m, on a body that is turned before a camera: it is '
            f'{MOST_LENGTH_M:g} m at most; give it in metres, not millimetres'
        )
    if not (0.0 < distance[2] < math.inf and 0.0 <= distance[3] < distance[2]):
        raise BodyCalibrationError(
            f'the distance is {distance[2]:g} m with a deviation of {distance[3]:g} m; a length '
            'is above 0 and above its standard deviation'
        )


def _check_left_out(
    used: NDArray[np.intp], left_out: NDArray[np.intp], names: Sequence[str]
) -> None:
    """Refuse a light that is not where it should be too often."""
    shares = left_out / np.maximum(used + left_out, 1)
    odd = int(np.argmax(shares))
    if shares[odd] > MOST_LEFT_OUT:
        raise BodyCalibrationError(
            f'{names[odd]} is not rigid with the other lights, or its rays are of another light: '
            f'{left_out[odd]} of its {used[odd] + left_out[odd]} rays pass it by more than their '
            'covariance allows; fix it, or leave it out with --lights'
        )


def _check_places(result: BodyCalibration) -> None:
    """Refuse lights in one line, and places that are hardly known."""
    if in_line(result.places):
        raise BodyCalibrationError(
            'the lights are in one line: the rotation about that line cannot be seen; put one '
            'light beside it'
        )
    size = _size(result)
    worst = int(np.argmax(result.sigmas))
    if not result.sigmas[worst] < WORTHLESS * size:
        raise BodyCalibrationError(
            f'the body was turned too little, or it is too far away: the position of '
            f'{result.names[worst]} is known to {100.0 * result.sigmas[worst] / size:.0f} % of '
            f'its size only after {math.degrees(result.turned):.0f} degrees; turn it by 30 '
            'degrees and more to either side, and up and down'
        )


def _size(result: BodyCalibration) -> float:
    """Return the greatest distance of two lights."""
    return float(np.linalg.norm(result.places[:, None] - result.places, axis=2).max())


def _notes(result: BodyCalibration) -> list[str]:
    notes = []
    if not result.is_metric:
        notes.append(
            'the size is unknown: positions are in units of a distance from the camera; measure '
            'the distance between two lights'
        )
    if result.factor > 1.0:
        notes.append(
            f'the residuals are {result.factor**0.5:.2f} times what the covariances of the rays '
            'say, and the sigmas were grown by it: a lens that is not calibrated well, a body '
            'that bends, or one that was turned too fast for the frame rate'
        )
    size = _size(result)
    for name, sigma in zip(result.names, result.sigmas, strict=True):
        if sigma > VAGUE * size:
            notes.append(
                f'the position of {name} is known to {100.0 * sigma / size:.1f} % of the size of '
                'the body only: turn it further, and so that this light is seen longer'
            )
    for name, gone in zip(result.names, result.left_out.tolist(), strict=True):
        if gone:
            notes.append(f'rays of {name} left out since they pass it by: {gone}')
    return notes

"""The pose of a body whose lights are known by name: all poses that the bearings leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
import math
from typing import NamedTuple

from blob_tracker.constellation.body import Body, IN_LINE, LEAST_LIGHTS
from blob_tracker.constellation.errors import (
    ConstellationError, Inconsistent, TooFewLights,
)
from blob_tracker.constellation.search import climb, exchanges, NONE, search, spread
from blob_tracker.constellation.valley import far_end
from blob_tracker.kernel import Array, kernel
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray

PRICE = 50.0  # chi-square of a bearing that is another light's: fits with and without it are told
AMBIGUOUS = 25.0  # of chi-square: poses that differ by less are both kept, as by five sigma
# Threes of rays that are tried, starts from which the likelihood is climbed, and whether bearings
# may be of other lights: at first, and where that leads to no good fit.
FIRST, MORE = (5, 4, False), (40, 16, True)
MANY, FIRST_OF_MANY = 8, (5, 2, False)  # of so many lights hardly any start is wrong
MOST_TURN_SIGMA = 0.3  # rad: beyond it the error of a turn is not Gaussian
NS = 1e-9  # s
STILL: Array = np.zeros(6)  # m/s, rad/s


@dataclass(frozen=True)
class Pose:
    """
    Where a body is, how it is turned and how it moves, in the camera's optical frame.

    Parameters
    ----------
    rotation : (3, 3) array
        Takes components in the body's frame to those in the optical frame.
    position : (3,) array
        Of the body's origin, m.
    covariance : (6, 6) array
        Of the position, m, and of turns about the optical axes, rad.
    twist : (6,) array
        Velocity of the origin, m/s, and angular rate, rad/s.
    twist_covariance : (6, 6) array
        Where all bearings are of one instant it is what was known before.
    chi2 : float
        Squared residuals over their variance.
    degrees_of_freedom : int
        Mean of `chi2`: two of each bearing, less six.
    outliers : tuple of str
        Lights whose bearings are not of them, and not used.
    stamp_ns : int
        Of the latest bearing, ns of ROS time.

    Examples
    --------
    A body 2 m before the camera and at rest, and how well its distance and its turns are known:

    >>> pose = Pose(
    ...     np.eye(3), np.array([0.2, 0.1, 2.0]), np.diag([1e-8, 1e-8, 1e-6, 1e-6, 1e-6, 1e-7]),
    ...     np.zeros(6), np.eye(6), chi2=4.2, degrees_of_freedom=4, outliers=(), stamp_ns=0,
    ... )
    >>> np.sqrt(pose.covariance.diagonal()).round(4)[2:4].tolist()  # m, rad
    [0.001, 0.001]
    >>> pose.cost
    4.2

    """

    rotation: Array
    position: Array
    covariance: Array
    twist: Array
    twist_covariance: Array
    chi2: float
    degrees_of_freedom: int
    outliers: tuple[str, ...]
    stamp_ns: int

    @property
    def cost(self) -> float:
        """Chi-square, and what bearings of other lights cost: the less the likelier."""
        return self.chi2 + PRICE * len(self.outliers)


class _Seen(NamedTuple):
    """The bearings as arrays, see `likelihood.fit`."""

    places: Array
    variances: Array
    rays: Array
    bases: Array
    noise: Array
    apart: Array


class _Motion(NamedTuple):
    """What is known of the twist before: deviations, zero for none, and mean; `likelihood.fit`."""

    rates: Array
    expected: Array


def poses(
    body: Body,
    bearings: Sequence[tuple[str, Bearing]],
    *,
    speed_sigma: float = 3.0,
    rate_sigma: float = 3.0,
    gate_sigma: float = 5.0,
    twist: Array = STILL,
) -> list[Pose]:
    """
    Return the poses of a body that bearings of its lights leave, the likeliest first.

    Three rays have up to four poses (`three_rays`), and lights in a plane two that nearly fit.
    Several threes are tried, the best are taken to the greatest likelihood of all bearings
    (`likelihood.fit`), and whatever is less likely than the best by no more than `AMBIGUOUS` is
    returned with it: a single pose is one that is told from all others. One light in five may be
    another's.

    Bearings with stamps of their own are of a body that moves evenly: its twist is fitted with
    the pose. The covariance is the inverse Fisher information; the error of a light's place is in
    it.

    Parameters
    ----------
    body : Body
        Its lights.
    bearings : sequence of (str, Bearing)
        Names of lights and where they are seen, one of each.
    speed_sigma, rate_sigma : float
        How fast the body moves, m/s, and turns, rad/s, along each axis: standard deviations.
    gate_sigma : float
        How improbable chi2 may be, as a Gaussian deviate beyond +-gate_sigma.
    twist : (6,) array
        Velocity, m/s, and rate, rad/s, that these are about: what poses before it tell.

    Returns
    -------
    list of Pose
        One, or more where the bearings do not tell them apart.

    Raises
    ------
    TooFewLights
        If there are fewer than three lights, or those seen are in one line.
    Inconsistent
        If no pose explains the bearings.
    ConstellationError
        If a name is not the body's or there twice, or a bearing can be none.

    Examples
    --------
    Four lights of a body whose origin is 2 m before the camera, and which is not turned:

    >>> places = np.array([[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.1, 0.1], [0, 0, 0.2]])
    >>> body = Body(('port', 'starboard', 'tail', 'mast'), places, np.zeros(4))
    >>> x, y, z = (places + [0.2, 0.1, 2.0]).T
    >>> azimuths, elevations = 1e3 * np.arctan2(x, z), 1e3 * np.arctan2(-y, np.hypot(x, z))
    >>> seen = [
    ...     (name, Bearing(*angles, 0.01 * np.eye(2)))
    ...     for name, *angles in zip(body.names, azimuths, elevations)
    ... ]
    >>> [pose] = poses(body, seen)
    >>> pose.position.round(3).tolist()  # m
    [0.2, 0.1, 2.0]
    >>> np.sqrt(pose.covariance.diagonal())[:3].round(4).tolist()  # m
    [0.0003, 0.0002, 0.0011]

    """
    names = [name for name, _ in bearings]
    seen, stamp_ns = _seen(body, bearings)
    if len(names) < LEAST_LIGHTS:
        raise TooFewLights(f'{len(names)} lights are seen; a pose needs three or more')
    if spread(seen.places, np.empty(3)) < IN_LINE**2:
        raise TooFewLights(
            f'the lights that are seen, {", ".join(names)}, are in one line; its rotation about '
            'that line cannot be seen'
        )
    known = np.array([speed_sigma, rate_sigma])
    motion = _Motion(known if np.ptp(seen.apart) > 0.0 else np.zeros(2), twist)
    first = FIRST if len(names) < MANY else FIRST_OF_MANY
    found = _fits(seen, names, motion, first, gate_sigma, stamp_ns)
    if not found or found[0].chi2 > found[0].degrees_of_freedom + AMBIGUOUS:
        found = _fits(seen, names, motion, MORE, gate_sigma, stamp_ns)
    # Stamps apart and few lights: what the body may do meanwhile makes wrong ones fit.
    if not found or (found[0].outliers and motion.rates[0] > 0.0 and len(names) < MANY):
        _check_names(
            seen, names, motion, gate_sigma, found[0].cost + AMBIGUOUS if found else math.inf)
    if not found:
        raise Inconsistent(
            'no pose of the body explains the bearings: lights have the names of others, or '
            'their positions on the body or the calibration of the camera are wrong'
        )
    best = found[0]
    if np.sqrt(best.covariance.diagonal()[3:].max()) > MOST_TURN_SIGMA:
        raise Inconsistent(
            'how the body is turned is known to no better than '
            f'{np.sqrt(best.covariance.diagonal()[3:].max()):.1f} rad; it is too far away for '
            'its size'
        )
    likely = [each for each in found if each.cost <= best.cost + AMBIGUOUS]
    if len(likely) == 1:
        likely += _in_one_valley(seen, names, motion, best)
    likely = [_in_metres(each, body.size_sigma) for each in likely]
    if motion.rates[0] > 0.0:
        return likely
    before = np.diag(np.repeat(known**2, 3))  # of one instant the bearings add nothing
    return [replace(each, twist=twist, twist_covariance=before) for each in likely]


def pose_near(
    body: Body,
    bearings: Sequence[tuple[str, Bearing]],
    rotation: Array,
    position: Array,
    *,
    speed_sigma: float = 3.0,
    rate_sigma: float = 3.0,
    gate_sigma: float = 5.0,
    twist: Array = STILL,
    odd: bool = False,
) -> Pose | None:
    """
    Return the pose that bearings leave near another one, the last one say; None if there is none.

    No other is looked for: `poses` tells whether there are others.

    Parameters
    ----------
    body, bearings, speed_sigma, rate_sigma, gate_sigma, twist
        As `poses` has them.
    rotation, position : (3, 3), (3,) arrays
        Of the other one.
    odd : bool
        Whether one light in five may be another's.

    Raises
    ------
    ConstellationError
        If a name is not the body's or there twice, or a bearing can be none.

    Examples
    --------
    From a pose that is 0.1 m off:

    >>> places = np.array([[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.1, 0.1], [0, 0, 0.2]])
    >>> body = Body(('port', 'starboard', 'tail', 'mast'), places, np.zeros(4))
    >>> x, y, z = (places + [0.2, 0.1, 2.0]).T
    >>> azimuths, elevations = 1e3 * np.arctan2(x, z), 1e3 * np.arctan2(-y, np.hypot(x, z))
    >>> seen = [
    ...     (name, Bearing(*angles, 0.01 * np.eye(2)))
    ...     for name, *angles in zip(body.names, azimuths, elevations)
    ... ]
    >>> pose = pose_near(body, seen, np.eye(3), np.array([0.2, 0.1, 2.1]))
    >>> pose.position.round(3).tolist()  # m
    [0.2, 0.1, 2.0]

    """
    seen, stamp_ns = _seen(body, bearings)
    names = [name for name, _ in bearings]
    moves = np.ptp(seen.apart) > 0.0 if names else np.False_
    rates = np.array([speed_sigma, rate_sigma]) if moves else np.zeros(2)
    start, place, motion = rotation.copy(), position.copy(), twist.copy()
    covariance, used = np.empty((12, 12)), np.empty(len(names))
    cost = climb(
        *seen, rates, twist, _gates(gate_sigma, len(names)), odd, start, place, motion, used,
        covariance, NONE,
    )
    if not cost < math.inf:
        return None
    return _in_metres(
        _pose(names, start, place, motion, covariance, used, cost, moves, stamp_ns),
        body.size_sigma,
    )


def _in_metres(pose: Pose, size_sigma: float) -> Pose:
    """Return it with the error of the body's size in its covariances: all lengths err alike."""
    if size_sigma == 0.0:
        return pose
    covariance, of_twist = pose.covariance.copy(), pose.twist_covariance.copy()
    covariance[:3, :3] += size_sigma**2 * np.outer(pose.position, pose.position)
    of_twist[:3, :3] += size_sigma**2 * np.outer(pose.twist[:3], pose.twist[:3])
    return replace(pose, covariance=covariance, twist_covariance=of_twist)


def _seen(body: Body, bearings: Sequence[tuple[str, Bearing]]) -> tuple[_Seen, int]:
    """Return bearings as arrays about the latest stamp, once each is seen to be one."""
    index = {name: place for place, name in enumerate(body.names)}
    names = [name for name, _ in bearings]
    for name in names:
        if name not in index:
            raise ConstellationError(f'the body has no light {name}: {", ".join(body.names)}')
    if len(set(names)) < len(names):
        raise ConstellationError(f'a light has two bearings: {", ".join(names)}')
    numbers = [index[name] for name in names]
    count = len(names)
    angles = np.array([(each.azimuth, each.elevation) for _, each in bearings]).reshape(-1, 2)
    noise = np.array([each.covariance for _, each in bearings], dtype=float).reshape(-1, 2, 2)
    rays, bases = np.empty((count, 3)), np.empty((count, 3, 2))
    unsound = _spherical(MRAD * angles, MRAD**2 * noise, noise, rays, bases)
    if unsound < count:
        raise ConstellationError(
            f'the bearing of {names[unsound]} or its covariance is not finite, or the covariance '
            'not positive definite'
        )
    stamps = [each.stamp_ns for _, each in bearings]
    latest = max(stamps, default=0)
    apart = NS * np.array([each - latest for each in stamps], dtype=float)
    seen = _Seen(body.places[numbers], body.sigmas[numbers]**2, rays, bases, noise, apart)
    return seen, latest


@kernel
def _spherical(
    angles: Array, covariances: Array, noise: Array, rays: Array, bases: Array
) -> int:
    """Fill in rays, bases and noise as `likelihood.fit` has them; return how many are sound."""
    for k in range(len(angles)):
        sine, cosine = np.sin(angles[k, 0]), np.cos(angles[k, 0])
        rise, level = np.sin(angles[k, 1]), np.cos(angles[k, 1])
        rays[k, 0], rays[k, 1], rays[k, 2] = level * sine, -rise, level * cosine
        bases[k, 0, 0], bases[k, 1, 0], bases[k, 2, 0] = cosine, 0.0, -sine
        bases[k, 0, 1], bases[k, 1, 1], bases[k, 2, 1] = -rise * sine, -level, -rise * cosine
        noise[k, 0, 0] = covariances[k, 0, 0] * level**2
        noise[k, 0, 1] = covariances[k, 0, 1] * level
        noise[k, 1, 0] = covariances[k, 1, 0] * level
        noise[k, 1, 1] = covariances[k, 1, 1]
        determinant = noise[k, 0, 0] * noise[k, 1, 1] - noise[k, 0, 1] * noise[k, 1, 0]
        known = np.isfinite(rays[k]).all() and np.isfinite(noise[k]).all()
        if not (known and noise[k, 0, 0] > 0.0 and determinant > 0.0):
            return k
    return len(angles)


def _fits(
    seen: _Seen, names: list[str], motion: _Motion, effort: tuple[int, int, bool],
    gate_sigma: float, stamp_ns: int,
) -> list[Pose]:
    """Return the poses of greatest likelihood that the bearings allow, the likeliest first."""
    triples, starts, odd = effort
    count, most = len(names), starts + 1
    rotations, positions, twists = np.empty((most, 3, 3)), np.empty((most, 3)), np.empty((most, 6))
    covariances, used, costs = np.empty((most, 12, 12)), np.empty((most, count)), np.empty(most)
    number = search(
        *seen, *motion, _triples(count, triples), PRICE, _gates(gate_sigma, count), odd,
        rotations, positions, twists, covariances, used, costs,
    )
    moves = motion.rates[0] > 0.0
    return [
        _pose(
            names, rotations[each], positions[each], twists[each], covariances[each], used[each],
            costs[each], moves, stamp_ns,
        )
        for each in np.argsort(costs[:number], kind='stable').tolist()
    ]


def _pose(
    names: list[str], rotation: Array, position: Array, twist: Array, covariance: Array,
    used: Array, cost: float, moves: np.bool_, stamp_ns: int,
) -> Pose:
    """Return what a search has found."""
    outliers = tuple(name for name, one in zip(names, used.tolist(), strict=True) if not one)
    return Pose(
        rotation, position, covariance[:6, :6], twist,
        covariance[6:, 6:] if moves else np.zeros((6, 6)), float(cost),
        2 * (len(names) - len(outliers)) - 6, outliers, stamp_ns,
    )


def _check_names(
    seen: _Seen, names: list[str], motion: _Motion, gate_sigma: float, most: float
) -> None:
    """Refuse bearings that two exchanged names, or a mirror image of the body, explain as well."""
    count = len(names)
    costs = np.empty((count, count))
    exchanges(
        *seen, *motion, _triples(count, FIRST[0]), PRICE, _gates(gate_sigma, count), costs)
    best = np.unravel_index(np.argmin(costs), costs.shape)
    if costs[best] < math.inf and costs[best] + PRICE <= most:
        one, other = (names[each] for each in best)
        raise Inconsistent(
            f"{one} and {other} are exchanged: the bearing of each fits the other's position; "
            'correct their names in the body file, or their codes'
        )
    mirrored = _fits(
        seen._replace(places=seen.places * [-1.0, 1.0, 1.0]), names, motion, FIRST, gate_sigma, 0)
    if mirrored and mirrored[0].cost + PRICE <= most:
        raise Inconsistent(
            'the bearings fit a mirror image of the body: an axis of its file has the wrong '
            'sign, for the axes are right-handed'
        )


def _in_one_valley(
    seen: _Seen, names: list[str], motion: _Motion, pose: Pose
) -> list[Pose]:
    """
    Return a far end of the valley of the likelihood in which a pose lies, if it has one.

    Its covariance does not tell how long the valley is.
    """
    used = np.array([float(name not in pose.outliers) for name in names])
    rotation, position, twist = pose.rotation.copy(), pose.position.copy(), pose.twist.copy()
    if not far_end(*seen, used, *motion, rotation, position, twist, AMBIGUOUS):
        return []
    return [replace(pose, rotation=rotation, position=position, twist=twist)]


@cache
def _triples(count: int, most: int) -> NDArray[np.int64]:
    """Return threes of so many bearings, spread over all that there are."""
    every = np.array(list(combinations(range(count), 3)))
    return np.random.default_rng(1).permutation(every)[:most]


@cache
def _gates(gate_sigma: float, count: int) -> Array:
    """Return the greatest chi-square of a bearing, and that of a pose of one to `count`."""
    import scipy  # no part of a start

    improbable = math.erfc(gate_sigma / math.sqrt(2.0))  # a Gaussian deviate beyond +-gate_sigma
    degrees = [2, *(max(2 * each - 6, 1) for each in range(1, count + 1))]
    return np.asarray(scipy.special.chdtri(degrees, improbable))

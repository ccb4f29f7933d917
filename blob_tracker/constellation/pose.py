"""The pose of a body whose lights are known by name: all poses that the bearings leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
import math
from typing import NamedTuple

from blob_tracker.constellation.body import Body, in_line, LEAST_LIGHTS
from blob_tracker.constellation.candidates import candidates
from blob_tracker.constellation.errors import (
    ConstellationError, Inconsistent, TooFewLights,
)
from blob_tracker.constellation.likelihood import fit, linearise
from blob_tracker.kernel import Array
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads its parts when they are first used; stats takes a second

PRICE = 50.0  # chi-square of a bearing that is another light's: fits with and without it are told
AMBIGUOUS = 25.0  # of chi-square: poses that differ by less are both kept, as by five sigma
OUTLIERS = 5  # of so many lights one may be another's
# Threes of rays that are tried, starts from which the likelihood is climbed, and whether bearings
# may be of other lights: at first, and where that leads to no good fit.
FIRST, MORE = (5, 4, False), (40, 16, True)
ROUNDS = 4  # in which bearings of other lights settle
SAME_RAD = 1e-3  # poses that are turned less apart are one
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
    if in_line(seen.places):
        raise TooFewLights(
            f'the lights that are seen, {", ".join(names)}, are in one line; its rotation about '
            'that line cannot be seen'
        )
    known = np.array([speed_sigma, rate_sigma])
    motion = _Motion(known if np.ptp(seen.apart) > 0.0 else np.zeros(2), twist)
    found = _fits(seen, names, motion, FIRST, gate_sigma, stamp_ns)
    if not found or found[0].chi2 > found[0].degrees_of_freedom + AMBIGUOUS:
        found = _fits(seen, names, motion, MORE, gate_sigma, stamp_ns)
    if not found:
        mirrored = seen._replace(places=seen.places * [-1.0, 1.0, 1.0])
        if _fits(mirrored, names, motion, FIRST, gate_sigma, stamp_ns):
            raise Inconsistent(
                'the bearings fit a mirror image of the body: an axis of its file has the '
                'wrong sign, for the axes are right-handed'
            )
        raise Inconsistent(
            'no pose of the body explains the bearings: lights have the names of others, or '
            'their places on the body or the calibration of the camera are wrong'
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
) -> Pose | None:
    """
    Return the pose that bearings leave near another one, the last one say; None if there is none.

    No other is looked for: `poses` tells whether there are others.

    Parameters
    ----------
    body, bearings, speed_sigma, rate_sigma, gate_sigma, twist
        As `poses` has them; no bearing may be of another light.
    rotation, position : (3, 3), (3,) arrays
        Of the other one.

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
    moved = np.ptp(seen.apart) > 0.0 if len(bearings) else False
    rates = np.array([speed_sigma, rate_sigma]) if moved else np.zeros(2)
    pose = _climbed(
        seen, [name for name, _ in bearings], _Motion(rates, twist), rotation.copy(),
        position.copy(), False, (), gate_sigma, stamp_ns,
    )
    return pose and _in_metres(pose, body.size_sigma)


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
    angles = MRAD * np.array(
        [[each.azimuth, each.elevation] for _, each in bearings]
    ).reshape(-1, 2)
    noise = MRAD**2 * np.array([each.covariance for _, each in bearings]).reshape(-1, 2, 2)
    level = np.cos(angles[:, 1])
    noise[:, 0] *= level[:, None]
    noise[:, :, 0] *= level[:, None]
    determinants = noise[:, 0, 0] * noise[:, 1, 1] - noise[:, 0, 1] * noise[:, 1, 0]
    sound = (
        np.isfinite(angles).all(axis=1) & np.isfinite(noise).all(axis=(1, 2))
        & (noise[:, 0, 0] > 0.0) & (determinants > 0.0)
    )
    for name, fine in zip(names, sound, strict=True):
        if not fine:
            raise ConstellationError(
                f'the bearing of {name} or its covariance is not finite, or the covariance not '
                'positive definite'
            )
    rays, bases = rays_of(angles)
    stamps = [each.stamp_ns for _, each in bearings]
    latest = max(stamps, default=0)
    apart = NS * np.array([each - latest for each in stamps], dtype=float)
    seen = _Seen(body.places[numbers], body.sigmas[numbers]**2, rays, bases, noise, apart)
    return seen, latest


def rays_of(angles: Array) -> tuple[Array, Array]:
    """Return unit vectors, and what is along azimuth and elevation across them."""
    sines, cosines = np.sin(angles), np.cos(angles)
    (sine, rise), (cosine, level) = sines.T, cosines.T
    rays = np.stack([level * sine, -rise, level * cosine], axis=1)
    bases = np.empty((len(angles), 3, 2))
    bases[:, 0, 0], bases[:, 1, 0], bases[:, 2, 0] = cosine, 0.0, -sine
    bases[:, 0, 1], bases[:, 1, 1], bases[:, 2, 1] = -rise * sine, -level, -rise * cosine
    return rays, bases


def _fits(
    seen: _Seen, names: list[str], motion: _Motion, effort: tuple[int, int, bool],
    gate_sigma: float, stamp_ns: int,
) -> list[Pose]:
    """Return the poses of greatest likelihood that the bearings allow, the likeliest first."""
    triples, most, others = effort
    starts, positions = np.empty((most, 3, 3)), np.empty((most, 3))
    # What a body that moves does meanwhile is not in the pose of three rays.
    speed2, rate2 = motion.rates**2 + (motion.expected**2).reshape(2, 3).sum(axis=1) * (
        motion.rates > 0.0)
    doubt = seen.variances + (speed2 + rate2 * np.sum(seen.places**2, 1)) * seen.apart**2
    count = candidates(
        seen.places, doubt, *seen[2:], motion.expected, _triples(len(names), triples), PRICE,
        starts, positions,
    )
    found: list[Pose] = []
    tried = [(starts[i], positions[i]) for i in range(count)]
    tried += [_mirrored(seen.places, *each) for each in tried[:1]]
    for start, position in tried:
        pose = _climbed(
            seen, names, motion, start.copy(), position.copy(), others, found, gate_sigma, stamp_ns
        )
        if pose is not None:
            found.append(pose)
    return sorted(found, key=lambda pose: pose.cost)


def _climbed(
    seen: _Seen, names: list[str], motion: _Motion, rotation: Array, position: Array,
    others: bool, found: Sequence[Pose], gate_sigma: float, stamp_ns: int,
) -> Pose | None:
    """Return the pose of greatest likelihood from a start; None if it is none, or found."""
    count = len(names)
    used, chi2 = np.ones(count), np.empty(count)
    information, twist = np.zeros((12, 12)), motion.expected.copy()
    first = rotation.copy(), position.copy()
    most = _most(gate_sigma, 2)
    cost = fit(*seen, used, *motion, rotation, position, twist, information, chi2)
    if others and count >= OUTLIERS and cost > _most(gate_sigma, 2 * count - 6):
        rotation, position = first  # the outlier has drawn the fit away
        twist[:] = motion.expected
        used = _inliers(seen, motion, rotation, position, twist, information, chi2)
        for _ in range(ROUNDS):
            cost = fit(*seen, used, *motion, rotation, position, twist, information, chi2)
            now = (chi2 < most).astype(float)
            if (now == used).all():
                break
            if now.sum() < count - count // OUTLIERS:
                return None
            used = now
        else:
            return None
    inside = int(used.sum())
    degrees = 2 * inside - 6
    if not cost <= _most(gate_sigma, max(degrees, 1)):  # nor NaN
        return None
    flat = rotation.ravel()
    if any(3.0 - flat @ each.rotation.ravel() < SAME_RAD**2 for each in found):
        return None
    along = np.sum(seen.rays * (seen.places @ rotation.T + position), axis=1)
    if along[used > 0.0].min() < 0.0:
        return None
    size = 12 if motion.rates[0] > 0.0 else 6
    try:
        whole = np.asarray(np.linalg.inv(information[:size, :size]), dtype=np.float64)
    except np.linalg.LinAlgError:
        return None
    return Pose(
        rotation, position, whole[:6, :6], twist,
        whole[6:, 6:] if size == 12 else np.zeros((6, 6)),
        cost, degrees,
        tuple(name for name, one in zip(names, used, strict=True) if not one), stamp_ns,
    )


def _inliers(
    seen: _Seen, motion: _Motion, rotation: Array, position: Array, twist: Array,
    information: Array, chi2: Array,
) -> Array:
    """Return which bearings count: all but the one in five that fits a start the least."""
    fit(
        *seen, np.zeros(len(chi2)), np.zeros(2), motion.expected, rotation.copy(),
        position.copy(), twist, information, chi2,
    )
    used = np.ones(len(chi2))
    worst = np.argsort(chi2)[len(chi2) - len(chi2) // OUTLIERS:]
    used[worst] = 0.0
    return used


def _mirrored(
    places: Array, rotation: Array, position: Array
) -> tuple[Array, Array]:
    """
    Return the other pose in which lights in a plane look nearly the same.

    Depths about the middle are turned over: R' = (I - 2 v v^T) R (I - 2 n n^T) with the line of
    sight v and the body's thinnest direction n.
    """
    middle = places.sum(axis=0) / len(places)
    beside = places - middle
    thin = np.linalg.eigh(beside.T @ beside)[1][:, 0]
    centre = rotation @ middle + position
    sight = centre / math.sqrt(centre @ centre)
    turned = rotation - (2.0 * sight)[:, None] * (sight @ rotation)
    other = turned - (turned @ (2.0 * thin))[:, None] * thin
    return other, centre - other @ middle


def _in_one_valley(
    seen: _Seen, names: list[str], motion: _Motion, pose: Pose
) -> list[Pose]:
    """
    Return the mirrored pose where it is as likely, and no maximum of its own.

    Seen nearly from the front both are in one valley of the likelihood, whose length the
    covariance at its bottom does not tell.
    """
    rotation, position = _mirrored(seen.places, pose.rotation, pose.position)
    used = np.array([float(name not in pose.outliers) for name in names])
    cost = linearise(
        *seen, used, *motion, rotation, position, pose.twist, np.empty((12, 12)), np.empty(12),
        np.empty(len(names)),
    )
    if not cost <= pose.chi2 + AMBIGUOUS:
        return []
    turned = scipy.spatial.transform.Rotation.from_matrix(rotation @ pose.rotation.T)
    way = np.concatenate([position - pose.position, turned.as_rotvec()])
    if way @ np.linalg.solve(pose.covariance, way) < AMBIGUOUS:
        return []
    return [replace(pose, rotation=rotation, position=position, chi2=float(cost))]


@cache
def _triples(count: int, most: int) -> NDArray[np.int64]:
    """Return threes of so many bearings, spread over all that there are."""
    every = np.array(list(combinations(range(count), 3)))
    return np.random.default_rng(1).permutation(every)[:most]


@cache
def _most(gate_sigma: float, degrees: int) -> float:
    """Return the chi-square that is as improbable as a Gaussian deviate beyond +-gate_sigma."""
    return float(scipy.special.chdtri(degrees, math.erfc(gate_sigma / math.sqrt(2.0))))

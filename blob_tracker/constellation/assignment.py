"""Which light of a body each bearing is of, where the lights have no names of their own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import combinations
from typing import Any, NamedTuple

from blob_tracker.constellation.body import Body
from blob_tracker.constellation.errors import ConstellationError, Inconsistent, TooFewLights
from blob_tracker.constellation.pose import AMBIGUOUS, Pose, pose_near, poses, PRICE
from blob_tracker.constellation.three_rays import MOST, three_rays
from blob_tracker.kernel import Array, kernel
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray

LEAST_BEARINGS = 4  # three fit each three lights of the body
NEAR = 0.05  # of the angle that the lights span: a pose of three rays is not exact
TRIPLES, KEPT = 6, 24  # threes of bearings that are tried, assignments that are looked at closely
MOST_LIGHTS = 16  # of a body: 3360 ordered threes, 10 ms each three of bearings
MOST_BEARINGS = 24
FAR = 0.5  # of the least angle between two lights, by which one may be off its prediction


class Assigned(NamedTuple):
    """
    A pose, and which bearing is of which light.

    Parameters
    ----------
    pose : Pose
        Of the body.
    names : tuple of str
        Light of each bearing; '' of one that is none of the body's.

    Examples
    --------
    A bearing that is none of the body's lights has no name:

    >>> pose = Pose(
    ...     np.eye(3), np.array([0.2, 0.1, 2.0]), np.eye(6), np.zeros(6), np.eye(6), chi2=0.0,
    ...     degrees_of_freedom=2, outliers=(), stamp_ns=0,
    ... )
    >>> found = Assigned(pose, ('mast', 'port', '', 'tail'))
    >>> found.cost > found.pose.cost
    True

    """

    pose: Pose
    names: tuple[str, ...]

    @property
    def cost(self) -> float:
        """Cost of the pose, and of the bearings that are no light's: the less the likelier."""
        return self.pose.cost + PRICE * self.names.count('')


def assigned(
    body: Body,
    bearings: Sequence[Bearing],
    *,
    speed_sigma: float = 3.0,
    rate_sigma: float = 3.0,
    gate_sigma: float = 5.0,
) -> list[Assigned]:
    """
    Return the poses of a body, and the light of each bearing, the likeliest first.

    Three bearings are taken for each three lights; each pose of them says where the others would
    be, and the bearings that are there have their names (as Faessler et al., A Monocular Pose
    Estimation System based on Infrared LEDs, ICRA 2014, section III-C, who count them). The best
    assignments are judged by the likelihood of all bearings, as those of named lights are.

    Parameters
    ----------
    body : Body
        Its lights, 16 at most.
    bearings : sequence of Bearing
        One of each light that is seen, in any order; some may be none of the body's.
    speed_sigma, rate_sigma, gate_sigma
        As `poses` has them.

    Returns
    -------
    list of Assigned
        One, or more where the bearings do not tell them apart: of a symmetric body always.

    Raises
    ------
    TooFewLights
        If there are fewer than four bearings.
    Inconsistent
        If no assignment explains four of them.
    ConstellationError
        If there are too many, or one is invalid.

    Examples
    --------
    Four lights and a lamp, in any order:

    >>> places = np.array([[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.1, 0.1], [0, 0, 0.2]])
    >>> body = Body(('port', 'starboard', 'tail', 'mast'), places, np.zeros(4))
    >>> x, y, z = (places[[3, 2, 0, 1]] + [0.2, 0.1, 2.0]).T
    >>> azimuths, elevations = 1e3 * np.arctan2(x, z), 1e3 * np.arctan2(-y, np.hypot(x, z))
    >>> seen = [Bearing(*angles, 0.01 * np.eye(2)) for angles in zip(azimuths, elevations)]
    >>> [found] = assigned(body, [*seen, Bearing(250.0, 120.0, 0.01 * np.eye(2))])
    >>> found.names
    ('mast', 'tail', 'port', 'starboard', '')

    """
    if len(bearings) < LEAST_BEARINGS:
        raise TooFewLights(
            f'{len(bearings)} lights without names are seen; {LEAST_BEARINGS} are needed to tell '
            'which is which'
        )
    if len(body.names) > MOST_LIGHTS or len(bearings) > MOST_BEARINGS:
        raise ConstellationError(
            f'{len(bearings)} bearings without names, of a body of {len(body.names)} lights: more '
            f'than {MOST_BEARINGS} of {MOST_LIGHTS} are too many to be distinguished'
        )
    rays = _directions(bearings)
    if not np.isfinite(rays).all():
        raise ConstellationError('a bearing is not finite')
    span = float(np.arccos(np.clip((rays @ rays.T).min(), -1.0, 1.0)))
    lights = np.empty((KEPT, len(bearings)), dtype=np.int64)
    count = _assignments(
        body.places, rays, _spread(len(bearings)), (NEAR * span)**2, lights, np.empty(KEPT))
    options: dict[str, Any] = {
        'speed_sigma': speed_sigma, 'rate_sigma': rate_sigma, 'gate_sigma': gate_sigma,
    }
    found: list[Assigned] = []
    for chosen in lights[:count]:
        names = tuple(body.names[light] if light >= 0 else '' for light in chosen.tolist())
        named = [(name, each) for name, each in zip(names, bearings, strict=True) if name]
        try:
            found += [Assigned(pose, names) for pose in poses(body, named, **options)]
        except ConstellationError:
            continue
    if not found:
        raise Inconsistent(
            'no assignment of the bearings to the lights of the body explains '
            f'{LEAST_BEARINGS} of them: the positions in the body file or the calibration of the '
            'camera are wrong, or the lights are others'
        )
    found.sort(key=lambda each: each.cost)
    return [each for each in found if each.cost <= found[0].cost + AMBIGUOUS]


def named_by(body: Body, bearings: Sequence[Bearing], pose: Pose) -> list[tuple[str, Bearing]]:
    """
    Return the bearings that are where a pose has lights, with their names.

    Parameters
    ----------
    body : Body
        Its lights.
    bearings : sequence of Bearing
        In any order.
    pose : Pose
        Of a moment before.

    Returns
    -------
    list of (str, Bearing)
        Each light once; those whose bearings are off by less than half the least angle between
        two lights, so that no two can be exchanged.

    """
    import scipy  # no part of a start

    points = body.places @ pose.rotation.T + pose.position
    expected = points / np.linalg.norm(points, axis=1, keepdims=True)
    seen = _directions(bearings)
    between = np.linalg.norm(expected[:, None] - expected, axis=2)
    near = FAR * float(between[np.triu_indices(len(expected), 1)].min())
    apart = np.linalg.norm(expected[:, None] - seen, axis=2)
    lights, chosen = scipy.optimize.linear_sum_assignment(np.minimum(apart, near))
    return [
        (body.names[light], bearings[each])
        for light, each in zip(lights.tolist(), chosen.tolist(), strict=True)
        if apart[light, each] < near
    ]


class Assignment:
    """
    Give bearings without names the names of a body's lights, one sighting after the other.

    The first time by `assigned`, then by where the last pose has the lights, as long as that
    leads to a good pose.

    Parameters
    ----------
    body : Body
        Its lights.
    longest : float
        Time after which the last pose says nothing more, s.

    Examples
    --------
    Four lights in another order than that of the body:

    >>> places = np.array([[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.1, 0.1], [0, 0, 0.2]])
    >>> body = Body(('port', 'starboard', 'tail', 'mast'), places, np.zeros(4))
    >>> x, y, z = (places[[3, 2, 0, 1]] + [0.2, 0.1, 2.0]).T
    >>> azimuths, elevations = 1e3 * np.arctan2(x, z), 1e3 * np.arctan2(-y, np.hypot(x, z))
    >>> seen = [Bearing(*angles, 0.01 * np.eye(2)) for angles in zip(azimuths, elevations)]
    >>> [name for name, _ in Assignment(body, longest=0.5).name(seen)]
    ['mast', 'tail', 'port', 'starboard']

    """

    def __init__(self, body: Body, longest: float) -> None:
        self._body, self._longest = body, longest
        self._last: Pose | None = None

    def name(self, bearings: Sequence[Bearing], **options: Any) -> list[tuple[str, Bearing]]:
        """
        Return the bearings that are lights of the body, with their names.

        Raises
        ------
        ConstellationError
            If they are not told, or more than one way.

        """
        latest = max((each.stamp_ns for each in bearings), default=0)
        last = self._last
        if last is not None and 0.0 < 1e-9 * (latest - last.stamp_ns) <= self._longest:
            named = named_by(self._body, bearings, last)
            if len(named) == len(bearings) and len(named) >= LEAST_BEARINGS:
                near = pose_near(
                    self._body, named, last.rotation, last.position, **options)
                if near is not None:
                    self._last = near
                    return named
        self._last = None
        found = assigned(self._body, bearings, **options)
        ways = {each.names for each in found}
        if len(ways) > 1:
            raise Inconsistent(
                f'{len(ways)} assignments of the lights explain the bearings: the body looks the '
                'same from several sides, or too few of its lights are seen; put them so that no '
                'two distances are alike'
            )
        if len(found) == 1:
            self._last = found[0].pose
        return [
            (name, each) for name, each in zip(found[0].names, bearings, strict=True) if name
        ]


def _directions(bearings: Sequence[Bearing]) -> Array:
    """Return the unit vectors onto what is seen, (m, 3)."""
    azimuth, elevation = MRAD * np.array(
        [(each.azimuth, each.elevation) for each in bearings]).reshape(-1, 2).T
    level = np.cos(elevation)
    return np.stack([level * np.sin(azimuth), -np.sin(elevation), level * np.cos(azimuth)], 1)


@cache
def _spread(count: int) -> NDArray[np.int64]:
    """Return threes of so many bearings, so many that one in five may be of no light."""
    every = np.array(list(combinations(range(count), 3)))
    return np.random.default_rng(1).permutation(every)[:TRIPLES]


@kernel
def _assignments(
    places: Array, rays: Array, triples: NDArray[np.int64], near2: float,
    assignments: NDArray[np.int64], scores: Array,
) -> int:
    """
    Find the best assignments of bearings to lights; return how many are filled.

    Parameters
    ----------
    places : (n, 3) array
        Of the lights, m.
    rays : (m, 3) array
        Unit vectors.
    triples : (t, 3) int array
        The bearings that are taken together.
    near2 : float
        Squared distance on the unit sphere within which a light is where a bearing is; also the
        price of a bearing that is none.
    assignments : (k, m) int array
        Are filled with the light of each bearing, -1 of none, the best first.
    scores : (k,) array
        Are filled with the sums of squared distances.

    """
    lights, count = len(places), len(rays)
    rotations, positions = np.empty((MOST, 3, 3)), np.empty((MOST, 3))
    chosen, three = np.empty(count, dtype=np.int64), np.empty(3, dtype=np.int64)
    expected = np.empty((lights, 3))
    taken = np.empty(lights, dtype=np.bool_)
    kept = 0
    for triple in triples:
        for i in range(lights):
            for j in range(lights):
                for k in range(lights):
                    if i == j or j == k or i == k:
                        continue
                    three[0], three[1], three[2] = i, j, k
                    number = three_rays(places[three], rays[triple], rotations, positions)
                    for each in range(number):
                        score, least = _matched(
                            places, rays, rotations[each], positions[each], near2, triple, three,
                            expected, taken, chosen,
                        )
                        if least < 4:
                            continue
                        kept = _put(chosen, score, assignments, scores, kept)
    return kept


@kernel
def _matched(
    places: Array, rays: Array, rotation: Array, position: Array, near2: float,
    triple: NDArray[np.int64], three: NDArray[np.int64], expected: Array,
    taken: NDArray[np.bool_], chosen: NDArray[np.int64],
) -> tuple[float, int]:
    """Give each bearing the light that a pose has there; return the score and how many have."""
    for light in range(len(places)):
        size = 0.0
        for a in range(3):
            value = position[a]
            for b in range(3):
                value += rotation[a, b] * places[light, b]
            expected[light, a] = value
            size += value * value
        size = np.sqrt(size) + 1e-300
        for a in range(3):
            expected[light, a] /= size
        taken[light] = False
    for bearing in range(len(rays)):
        chosen[bearing] = -1
    for a in range(3):
        chosen[triple[a]] = three[a]
        taken[three[a]] = True
    score, matched = 0.0, 3
    for bearing in range(len(rays)):
        best, light_there = near2, chosen[bearing]
        for light in range(len(places)):
            if taken[light] and light != light_there:
                continue
            if light_there >= 0 and light != light_there:
                continue
            apart = 0.0
            for a in range(3):
                apart += (expected[light, a] - rays[bearing, a])**2
            if apart < best:
                best = apart
                if chosen[bearing] != light:
                    chosen[bearing] = light
        if light_there < 0 and chosen[bearing] >= 0:
            taken[chosen[bearing]] = True
            matched += 1
        score += best
    return score, matched


@kernel
def _put(
    chosen: NDArray[np.int64], score: float, assignments: NDArray[np.int64], scores: Array,
    kept: int,
) -> int:
    """Put an assignment among the best in order, once; return how many they are."""
    for i in range(kept):
        if (assignments[i] == chosen).all():
            if score >= scores[i]:
                return kept
            for j in range(i, kept - 1):
                assignments[j], scores[j] = assignments[j + 1], scores[j + 1]
            kept -= 1
            break
    place = kept
    while place > 0 and scores[place - 1] > score:
        place -= 1
    if place == len(scores):
        return kept
    kept = min(kept + 1, len(scores))
    for j in range(kept - 1, place, -1):
        assignments[j], scores[j] = assignments[j - 1], scores[j - 1]
    assignments[place], scores[place] = chosen, score
    return kept

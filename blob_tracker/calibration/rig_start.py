"""Where the cameras of a rig are, roughly: what the adjustment of all rays starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from blob_tracker.calibration.rays import Rays
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_SHARED = 60  # instants that a pair of cameras must both have seen the light at
MOST_SHARED = 400  # of them are looked at: more tell a start nothing
DRAWS, DRAWN = 500, 14  # samples of rays: fewer rays are too noisy, more seldom without a stray
STRAY = 4.0  # times the median distance: such a ray is not of the light
REFINED, ROUNDS = 8, 4  # the best samples, and how often each is fitted again without strays
FLAT = np.diag([1.0, 1.0, 0.0])  # the singular values of an essential matrix
OFFSET_STEP = 0.005  # s: a hand's light moves by some mrad
LOOKED_AT = 6  # offsets that a first look likes best
PLANAR = 1e-3  # of the second singular value over the first: two answers, or none
ASTRAY_RAD = 0.03  # median distance of rays from each other: they are not of one light


class RigError(ValueError):
    """Rays from which no rig can be told; the message says what is wrong and what is right."""


@dataclass
class Start:
    """
    Poses and clocks of a rig, up to its size.

    Parameters
    ----------
    rotations : (n, 3, 3) array
        Take components in each camera's optical frame to those in the first one's.
    positions : (n, 3) array
        Of the optical centres in the first camera's frame.
    offsets : (n,) array
        By which each clock is ahead of the first one's, s.

    """

    rotations: Array
    positions: Array
    offsets: Array


def start_rig(
    rays: Sequence[Sequence[Rays]], names: Sequence[str], *, longest: float, most_offset: float
) -> Start:
    """
    Place cameras one after the other by the rays that they share.

    The first camera and the one that shares most with it come from the essential matrix, by eight
    points or more (Hartley & Zisserman, Multiple View Geometry, 2nd ed., sections 9.6 and 11.2,
    with unit vectors in place of pixels, so that any lens will do). Each other camera comes from
    the directions in which it sees places that those before it have told (the same book, section
    7.1). The offset of a clock is that of a grid at which the rays meet best.

    Parameters
    ----------
    rays : sequence of sequence of Rays
        Of each camera, to each light.
    names : sequence of str
        Of the cameras.
    longest : float
        Greatest time between two rays that are interpolated, s.
    most_offset : float
        Greatest offset of a clock that is looked for, s.

    Returns
    -------
    Start
        In units of the distance between the first two cameras that were placed.

    Raises
    ------
    RigError
        If cameras saw too little together, or nothing that their poses can be told from.

    """
    count = len(rays)
    start = Start(
        np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)), np.zeros(count)
    )
    placed = [0]
    grid = _offsets(most_offset)
    shared = {other: _shared(rays[0], rays[other], longest) for other in range(1, count)}
    second = max(shared, key=lambda other: shared[other])
    _check_shared(shared[second], names[0], names[second])
    rotation, position, offset = _best_pair(rays[0], rays[second], grid, longest, names, second)
    start.rotations[second], start.positions[second] = rotation, position
    start.offsets[second] = offset
    placed.append(second)
    while len(placed) < count:
        points = [_points(rays, start, placed, light, longest) for light in range(len(rays[0]))]
        waiting = [number for number in range(count) if number not in placed]
        known = {
            number: len(_seen_of(rays[number], points, 0.0, longest)[0]) for number in waiting
        }
        after = max(waiting, key=lambda number: known[number])
        _check_shared(known[after], ' and '.join(names[each] for each in placed), names[after])
        _place(rays[after], points, after, start, grid, longest, names)
        placed.append(after)
    return start


def relative_pose(one: Array, other: Array) -> tuple[Array, Array, float]:
    """
    Return the pose of a second camera in a first one's frame, from directions of the same points.

    With its rotation R and position p, rays d and d' to one point have d . (p x R d') = 0.

    Parameters
    ----------
    one, other : (n, 3) arrays
        Unit vectors in each camera's optical frame, n of 8 or more.

    Returns
    -------
    (3, 3) array, (3,) array, float
        R; p, of length 1; and the median distance of the rays from meeting, rad.

    Raises
    ------
    RigError
        If the points lie in a plane or on a line, or are all far away.

    """
    products = (one[:, :, None] * other[:, None, :]).reshape(-1, 9)
    left, across = _essential(products[_draws(len(one))])
    apart = _distance(left @ FLAT @ across, one, other)
    best = apart[np.argsort(np.median(apart, axis=1))[:REFINED]]
    fits = [_fitted(products, one, other, begun) for begun in best]
    apart, kept, (left, across) = min(fits, key=lambda fit: float(np.median(fit[0])))
    sizes = np.linalg.svd(products[kept], compute_uv=False)
    if sizes[-2] < PLANAR * sizes[0]:
        raise RigError(
            'the light was moved along a line or in a plane only, or stayed in one place: wave it '
            'through the whole space that the cameras see, nearer and further too'
        )
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    choices = []
    for way in (turn, turn.T):
        rotation = left @ way @ across
        rotation *= np.sign(np.linalg.det(rotation))
        choices += [(rotation, left[:, 2]), (rotation, -left[:, 2])]
    ahead = [_ahead(one[kept], other[kept], *choice) for choice in choices]
    rotation, position = choices[int(np.argmax(ahead))]
    return rotation, position, float(np.median(apart))


def resected(points: Array, directions: Array) -> tuple[Array, Array, float]:
    """
    Return the pose of a camera that sees known points in known directions.

    d x (A X + b) = 0 is solved for A and b; A over its size is nearest to R^T.

    Parameters
    ----------
    points, directions : (n, 3) arrays
        Places and the unit vectors to them in the camera's optical frame, n of 6 or more.

    Returns
    -------
    (3, 3) array, (3,) array, float
        Rotation, position, and the median angle between seen and expected, rad.

    """
    middle, size = points.mean(axis=0), float(points.std())
    scaled = (points - middle) / size
    rows = _rows(scaled, directions)
    draws = _draws(len(points))
    tried = _pose(rows[draws].reshape(len(draws), -1, 12))
    apart = _off(*tried, scaled, directions)
    best = apart[int(np.argmin(np.median(apart, axis=1)))]
    rotation, position, apart = _refined(rows, scaled, directions, best)
    return rotation, middle + size * position, float(np.median(apart))


def meeting_points(directions: Array, centres: Array) -> Array:
    """
    Return the points nearest to rays, by least squares of the distances.

    Parameters
    ----------
    directions : (n, c, 3) array
        Of n instants and c cameras, in one frame; NaN where a camera saw nothing.
    centres : (c, 3) array
        Of the cameras.

    Returns
    -------
    (n, 3) array
        NaN where fewer than two cameras saw it, it is behind one of them, or a ray passes it by
        far more than most do.

    """
    seen = np.isfinite(directions[:, :, 0])
    rays = np.where(seen[:, :, None], directions, 0.0)
    across = np.eye(3) * seen[:, :, None, None] - rays[..., :, None] * rays[..., None, :]
    enough = seen.sum(axis=1) >= 2
    places = np.full((len(directions), 3), np.nan)
    right = np.einsum('nkab,kb->na', across[enough], centres)
    places[enough] = np.linalg.solve(
        across[enough].sum(axis=1) + 1e-12 * np.eye(3), right[:, :, None]
    )[:, :, 0]
    with np.errstate(invalid='ignore', divide='ignore'):
        toward = places[:, None, :] - centres
        depths = (toward * rays).sum(axis=2)
        places[((depths <= 0.0) & seen).any(axis=1)] = np.nan
        passed = np.linalg.norm(toward - depths[..., None] * rays, axis=2) / depths
    passed = np.where(seen, passed, 0.0).max(axis=1)
    known = np.isfinite(places[:, 0])
    if known.any():
        places[known & (passed > STRAY * np.median(passed[known]))] = np.nan
    return places


def _draws(count: int) -> NDArray[np.intp]:
    """Return samples of which some hold no stray, (DRAWS, DRAWN)."""
    return np.random.default_rng(0).integers(0, count, (DRAWS, DRAWN))


def _fitted(
    products: Array, one: Array, other: Array, apart: Array
) -> tuple[Array, NDArray[np.bool_], tuple[Array, Array]]:
    """Return distances, rays and essential matrix of a fit that leaves out strays by and by."""
    for _ in range(ROUNDS):
        kept = apart <= STRAY * np.median(apart)
        sides = _essential(products[kept])
        apart = _distance(sides[0] @ FLAT @ sides[1], one, other)
    return apart, kept, sides


def _essential(products: Array) -> tuple[Array, Array]:
    """Return U and V^T of the essential matrix by products of directions, (..., m, 9)."""
    right = np.linalg.svd(products, full_matrices=True)[2][..., -1, :]
    left, _, across = np.linalg.svd(right.reshape(*right.shape[:-1], 3, 3))
    return left, across


def _rows(points: Array, directions: Array) -> Array:
    """Return the equations d x (A X + b) = 0, three for each point, (n, 3, 12)."""
    x, y, z = directions.T
    none = np.zeros_like(x)
    cross = np.array([[none, -z, y], [z, none, -x], [-y, x, none]]).transpose(2, 0, 1)
    whole = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    return (cross[:, :, :, None] * whole[:, None, None, :]).reshape(-1, 3, 12)


def _refined(
    rows: Array, points: Array, directions: Array, apart: Array
) -> tuple[Array, Array, Array]:
    """Return rotation, position and angles of a fit that leaves out strays by and by."""
    for _ in range(ROUNDS):
        kept = apart <= STRAY * np.median(apart)
        rotation, position = _pose(rows[kept].reshape(-1, 12))
        apart = _off(rotation, position, points, directions)
    return rotation, position, apart


def _pose(rows: Array) -> tuple[Array, Array]:
    """Return rotation and position by rows of d x (A X + b) = 0, (..., m, 12)."""
    right = np.linalg.svd(rows, full_matrices=False)[2][..., -1, :]
    solution = right.reshape(*right.shape[:-1], 3, 4)
    solution = solution * np.sign(np.linalg.det(solution[..., :3]))[..., None, None]
    left, sizes, across = np.linalg.svd(solution[..., :3])
    rotation = np.swapaxes(left @ across, -1, -2)
    size = np.maximum(sizes.mean(axis=-1), 1e-12)[..., None]
    return rotation, -np.einsum('...ab,...b->...a', rotation, solution[..., 3]) / size


def _off(rotation: Array, position: Array, points: Array, directions: Array) -> Array:
    """Return the angles between the directions seen and expected, rad, (..., n)."""
    toward = (points - position[..., None, :]) @ rotation
    cosine = (toward * directions).sum(axis=-1) / np.linalg.norm(toward, axis=-1)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _offsets(most: float) -> Array:
    """Return the offsets that are tried, the nearest first, s."""
    steps = np.arange(0.0, most + 1e-9, OFFSET_STEP)
    return np.concatenate([steps[:1], np.stack([steps[1:], -steps[1:]], axis=1).ravel()])


def _common(one: Sequence[Rays], other: Sequence[Rays], offset: float, longest: float) -> tuple[
    Array, Array
]:
    """Return directions of two cameras at the same instants, of all lights."""
    ones, others = [np.empty((0, 3))], [np.empty((0, 3))]
    for mine, its in zip(one, other, strict=True):
        if len(mine.times) and len(its.times) > 1:
            seen = its.at(mine.times + offset, longest)
            both = np.isfinite(seen[:, 0])
            ones.append(mine.directions[both])
            others.append(seen[both])
    return _some(np.concatenate(ones), np.concatenate(others))


def _some(one: Array, other: Array) -> tuple[Array, Array]:
    """Return rows of two arrays, evenly taken, no more than a start needs."""
    chosen = np.linspace(0, len(one) - 1, min(len(one), MOST_SHARED)).astype(int)
    return one[chosen], other[chosen]


def _shared(one: Sequence[Rays], other: Sequence[Rays], longest: float) -> int:
    return len(_common(one, other, 0.0, longest)[0])


def _check_shared(shared: int, name: str, other: str) -> None:
    if shared < LEAST_SHARED:
        raise RigError(
            f'{name} and {other} saw the light together {shared} times only; wave it for half a '
            f'minute where they both see it ({LEAST_SHARED} times are the least), with clocks '
            'that are nearly the same'
        )


def _best_pair(
    one: Sequence[Rays], other: Sequence[Rays], grid: Array, longest: float,
    names: Sequence[str], second: int,
) -> tuple[Array, Array, float]:
    """Return pose and offset of a second camera."""
    found: list[tuple[float, float, Array, Array]] = []
    refusal: RigError | None = None
    looks: list[tuple[float, float]] = []
    for offset in grid.tolist():
        seen = _common(one, other, offset, longest)
        if len(seen[0]) >= LEAST_SHARED:
            products = (seen[0][:, :, None] * seen[1][:, None, :]).reshape(-1, 9)
            fit = _fitted(products, *seen, np.zeros(len(products)))
            looks.append((float(np.median(fit[0])), offset))
    for _, offset in sorted(looks)[:LOOKED_AT]:
        seen = _common(one, other, offset, longest)
        try:
            rotation, position, apart = relative_pose(*seen)
        except RigError as error:
            refusal = error
            continue
        found.append((apart, offset, rotation, position))
    if not found and refusal is not None:
        raise refusal
    apart, offset, rotation, position = min(found, key=lambda each: each[0])
    _check_astray(apart, names[0], names[second])
    return rotation, position, offset


def _check_astray(apart: float, name: str, other: str) -> None:
    if apart > ASTRAY_RAD:
        raise RigError(
            f'the rays of {name} and {other} do not meet, wherever the cameras are put: they are '
            f'{1e3 * apart:.0f} mrad from it in the median; are both of the same light, are the '
            'clocks further apart than was looked for (--most-offset), and the lenses calibrated?'
        )


def _points(
    rays: Sequence[Sequence[Rays]], start: Start, placed: Sequence[int], light: int,
    longest: float,
) -> tuple[Array, Array]:
    """Return instants of the first clock and where the light was then, as far as it is known."""
    times = np.unique(np.concatenate(
        [rays[camera][light].times - start.offsets[camera] for camera in placed]
    ))
    seen = np.full((len(times), len(placed), 3), np.nan)
    for column, camera in enumerate(placed):
        if len(rays[camera][light].times) > 1:
            local = rays[camera][light].at(times + start.offsets[camera], longest)
            seen[:, column] = local @ start.rotations[camera].T
    places = meeting_points(seen, start.positions[np.array(placed)])
    known = np.isfinite(places[:, 0])
    return times[known], places[known]


def _seen_of(
    rays: Sequence[Rays], points: Sequence[tuple[Array, Array]], offset: float, longest: float
) -> tuple[Array, Array]:
    """Return known places and the directions in which a camera saw them."""
    places, directions = [np.empty((0, 3))], [np.empty((0, 3))]
    for mine, (times, known) in zip(rays, points, strict=True):
        seen = (
            mine.at(times + offset, longest) if len(mine.times) > 1 and len(times)
            else np.full((len(times), 3), np.nan)
        )
        both = np.isfinite(seen[:, 0])
        places.append(known[both])
        directions.append(seen[both])
    return np.concatenate(places), np.concatenate(directions)


def _place(
    rays: Sequence[Rays], points: Sequence[tuple[Array, Array]], camera: int, start: Start,
    grid: Array, longest: float, names: Sequence[str],
) -> None:
    """Fill in pose and offset of a further camera."""
    looks: list[tuple[float, float]] = []
    for offset in grid.tolist():
        places, directions = _some(*_seen_of(rays, points, offset, longest))
        if len(places) >= LEAST_SHARED:
            scaled = (places - places.mean(axis=0)) / places.std()
            fit = _refined(
                _rows(scaled, directions), scaled, directions, np.zeros(len(places))
            )
            looks.append((float(np.median(fit[2])), offset))
    found: list[tuple[float, float, Array, Array]] = []
    for _, offset in sorted(looks)[:LOOKED_AT]:
        places, directions = _some(*_seen_of(rays, points, offset, longest))
        rotation, position, apart = resected(places, directions)
        found.append((apart, offset, rotation, position))
    apart, start.offsets[camera], start.rotations[camera], start.positions[camera] = min(
        found, key=lambda each: each[0]
    )
    _check_astray(apart, 'the other cameras', names[camera])


def _distance(essential: Array, one: Array, other: Array) -> Array:
    """Return the angles by which rays pass each other, rad, to first order, (..., n)."""
    planes, its_planes = other @ np.swapaxes(essential, -1, -2), one @ essential
    size = np.sqrt((planes**2).sum(axis=-1) + (its_planes**2).sum(axis=-1))
    return np.asarray(np.abs((one * planes).sum(axis=-1)) / np.maximum(size, 1e-300))


def _ahead(one: Array, other: Array, rotation: Array, position: Array) -> int:
    """Return how many points are ahead of both cameras."""
    turned = other @ rotation.T
    cosine = (one * turned).sum(axis=1)
    near, far = one @ position, turned @ position
    # Depths of the nearest points on both rays, times 1 - cosine^2.
    return int(((near - cosine * far > 0.0) & (cosine * near - far > 0.0)).sum())

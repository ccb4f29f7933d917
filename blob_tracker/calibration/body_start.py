"""Where the lights of a body are, roughly: what the adjustment of all rays starts from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from blob_tracker.calibration.body_equations import Equations, Measured, Unknown
from blob_tracker.calibration.path_equations import adjusted, GATE, MEDIAN_OF_TWO
from blob_tracker.calibration.rays import Rays
from blob_tracker.constellation import Body, ConstellationError, Pose, pose_near, poses
from blob_tracker.constellation.body import IN_LINE
from blob_tracker.tracking.rays import angles_of
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

LEAST_LIGHTS = 4  # three are seen alike from every side, so to say: no views tell their places
LEAST_TOGETHER = 20  # instants at which the same lights are seen
TAKEN = 40  # of them: more tell a start nothing
ROUNDS = 6  # of the fit, each with the weights of the one before
STILL = 0.03  # of the size of the picture of the lights, by which its shape changes
ASTRAY = 0.02  # of that size: so far off is no noise, but another body
PLAIN = 3.0  # times the scatter of the other: so much is no noise
BETTER = 3.0  # times nearer are the others without the light that is not rigid
FLAT = 0.2  # of the second singular value of the pictures over the first
WIDEST, WIDEST_STEP = 4, 2  # pictures that a flat body is begun with, and of them every second
LEAST_PLACED = 20  # instants at which a further light is seen with a body that is placed
IN_PLANE = 0.03  # of the singular values of places
MOST_FAILED = 0.3  # of the instants: with more the body is none, or it is far too far away
DOUBT = 5e-3  # of the body's size: what the places of a start may be off
FAR_SIGMA = 30.0  # that a ray may be off the start, interpolated as it is


class BodyCalibrationError(ValueError):
    """Rays from which no body can be told; the message says what is wrong and what is right."""


@dataclass(frozen=True)
class Start:
    """
    A body and its poses, up to its size.

    Parameters
    ----------
    places : (n, 3) array
        Of the lights.
    times : (m,) array
        At which it is placed, s.
    turns : (m, 4) array
        Quaternions (x, y, z, w).
    positions : (m, 3) array
        Of its origin.
    scatter : float
        Median of the residuals over their standard deviations.

    """

    places: Array
    times: Array
    turns: Array
    positions: Array
    scatter: float


def start_body(rays: Sequence[Rays], names: Sequence[str], longest: float) -> list[Start]:
    """
    Return a body with its poses, and its mirror image if that is likely as well.

    At instants at which the same lights are seen their pictures are those of a parallel
    projection, nearly: a product of the first two rows of the body's turns and of its places, of
    rank three (Tomasi & Kanade, Int. J. Computer Vision 9 (1992) 137; the size of each picture
    beside it as in Poelman & Kanade, PAMI 19 (1997) 206). Such pictures tell depth from minus
    depth by nothing: both are adjusted to the rays themselves, which do. The other lights follow
    from where they are seen once the body is placed.

    Parameters
    ----------
    rays : sequence of Rays
        Of each light.
    names : sequence of str
        Of the lights.
    longest : float
        Greatest time between two rays that are interpolated, s.

    Raises
    ------
    BodyCalibrationError
        If the lights were not seen together, not turned, in one line or not rigid.

    """
    times, seen = _together(rays, longest)
    lights = _most_seen(np.isfinite(seen[..., 0]), names)
    known = np.flatnonzero(np.isfinite(seen[:, lights, 0]).all(axis=1))
    taken = known[np.linspace(0, len(known) - 1, min(TAKEN, len(known))).astype(np.intp)]
    views = seen[taken][:, lights]
    noise = np.stack([rays[light].covariance.mean(axis=0) for light in lights])
    flat, _ = _pictures(views)
    _check_pictures(flat)
    starts = _fits(views, noise)
    _check_rigid(starts[0], views, noise, [names[light] for light in lights])
    return [
        _whole(start, lights, times, seen, rays, names)
        for start in starts if start.scatter <= PLAIN * starts[0].scatter
    ]


def _together(rays: Sequence[Rays], longest: float) -> tuple[Array, Array]:
    """Return instants, (m,), and the directions of all lights at them, (m, n, 3); or NaN."""
    begin = min(float(each.times[0]) for each in rays)
    end = max(float(each.times[-1]) for each in rays)
    interval = float(np.nanmax([each.interval() for each in rays]))
    times = np.arange(begin, end, interval)
    return times, np.stack([each.without_leaps().at(times, longest) for each in rays], axis=1)


def _most_seen(seen: NDArray[np.bool_], names: Sequence[str]) -> list[int]:
    """Return the lights to begin with: as many as are seen together long enough."""
    lights = list(range(seen.shape[1]))
    while seen[:, lights].all(axis=1).sum() < LEAST_TOGETHER and len(lights) > LEAST_LIGHTS:
        lights.remove(max(
            lights,
            key=lambda light: seen[:, [each for each in lights if each != light]].all(1).sum(),
        ))
    if seen[:, lights].all(axis=1).sum() < LEAST_TOGETHER:
        most, best = max(
            (int(seen[:, list(four)].all(axis=1).sum()), four)
            for four in combinations(range(seen.shape[1]), LEAST_LIGHTS)
        )
        if most < LEAST_TOGETHER:
            words = ', '.join(f'{name} ({count})' for name, count in zip(names, seen.sum(axis=0)))
            raise BodyCalibrationError(
                f'no {LEAST_LIGHTS} lights were seen together at {LEAST_TOGETHER} instants or '
                f'more; instants of each: {words}. Turn the body so that the camera sees '
                f'{LEAST_LIGHTS} of them at once'
            )
        return list(best)
    return lights


def _pictures(views: Array) -> tuple[Array, Array]:
    """Return lights about their middle on a plane across it, (m, n, 2), and axes, (m, 3, 3)."""
    middle = views.mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    across = np.cross(np.eye(3)[np.abs(middle).argmin(axis=1)], middle)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    axes = np.stack([across, np.cross(middle, across), middle], axis=1)
    local = np.einsum('mab,mnb->mna', axes, views)
    flat = local[..., :2] / local[..., 2:]
    return flat - flat.mean(axis=1, keepdims=True), axes


def _check_pictures(flat: Array) -> None:
    """Refuse lights in one line, and a body that did not turn."""
    size = np.linalg.svd(flat, compute_uv=False)
    if (size[:, 1] < IN_LINE * size[:, 0]).all():
        raise BodyCalibrationError(
            'the lights are in one line: the rotation about that line cannot be seen; put one '
            'light beside it'
        )
    shapes = flat[..., 0] + 1j * flat[..., 1]
    first = shapes[np.argmax(np.linalg.norm(shapes, axis=1))]
    # A turn in the picture and its size are one complex factor.
    factor = (shapes @ first.conj()) / (first @ first.conj())
    changed = np.linalg.norm(shapes - factor[:, None] * first, axis=1)
    if (changed < STILL * np.linalg.norm(shapes, axis=1)).all():
        raise BodyCalibrationError(
            'the body was hardly turned: its lights form the same picture all the time; turn it '
            'by 30 degrees and more to either side, and up and down'
        )


def _fits(views: Array, noise: Array) -> list[Start]:
    """Return what views tell, from each beginning, the best first."""
    starts = [_fitted(views, noise, each) for each in _factorised(views)]
    flat, _ = _pictures(views)
    size = np.linalg.svd(np.swapaxes(flat, 1, 2).reshape(-1, views.shape[1]), compute_uv=False)
    if size[2] < FLAT * size[1]:
        starts += [_fitted(views, noise, each) for each in _flattened(views, noise)]
    return sorted(starts, key=lambda start: start.scatter)


def _allowed(views: Array, noise: Array) -> float:
    """Return the scatter of a start that is none."""
    flat, _ = _pictures(views)
    size = float(np.sqrt((flat**2).sum(axis=2).mean()))
    return ASTRAY * size / float(np.sqrt(noise[:, [0, 1], [0, 1]].mean()))


def _flattened(views: Array, noise: Array) -> Iterator[Unknown]:
    """Give bodies as flat as their widest pictures: of lights in a plane there is no third row."""
    flat, axes = _pictures(views)
    widest = np.argsort(-np.linalg.svd(flat, compute_uv=False)[:, 1])[::WIDEST_STEP][:WIDEST]
    for view in widest:
        places = np.pad(flat[view], ((0, 0), (0, 1)))
        placed, turns, positions = _placed(dict(enumerate(places)), views, noise)
        if len(placed) < LEAST_TOGETHER:
            continue
        at = np.searchsorted(placed, np.arange(len(views))).clip(0, len(placed) - 1)
        yield Unknown(places, turns[at].as_quat(), positions[at])


def _factorised(views: Array) -> list[Unknown]:
    """Return two bodies with a pose for each view, in units of the first one's distance."""
    flat, axes = _pictures(views)
    rows = np.swapaxes(flat, 1, 2).reshape(-1, flat.shape[1])
    left, singular, right = np.linalg.svd(rows, full_matrices=False)
    motion, shape = left[:, :3] * singular[:3], right[:3]
    one, other = motion[0::2], motion[1::2]
    # Rows of one view are as long as each other, and square to each other.
    left_out = np.concatenate([_square(one, one) - _square(other, other), _square(one, other)])
    weights = np.tile(1.0 / (one**2 + other**2).sum(axis=1), 2)
    answer = np.linalg.svd(weights[:, None] * left_out)[2][-1]
    metric = np.array([
        [answer[0], answer[1], answer[2]], [answer[1], answer[3], answer[4]],
        [answer[2], answer[4], answer[5]],
    ])
    values, vectors = np.linalg.eigh(metric)
    if values.sum() < 0.0:
        values = -values
    upgrade = vectors * np.sqrt(np.maximum(values, 0.01 * np.abs(values).max()))
    motion, shape = motion @ upgrade, np.linalg.solve(upgrade, shape)
    one, other = motion[0::2], motion[1::2]
    size = 0.5 * (np.linalg.norm(one, axis=1) + np.linalg.norm(other, axis=1))
    found = []
    for sign in (1.0, -1.0):
        depth = np.array([1.0, 1.0, sign])
        rotations = np.stack([one, other, np.cross(one, other) / size[:, None]], axis=1)
        rotations = rotations * depth * np.array([1.0, 1.0, sign])[:, None]
        left, _, right = np.linalg.svd(rotations / size[:, None, None])
        turns = np.swapaxes(axes, 1, 2) @ (left @ right)
        unit = size[0]
        found.append(Unknown(
            (unit * depth[:, None] * shape).T, Rotation.from_matrix(turns).as_quat(),
            axes[:, 2] * (unit / size)[:, None],
        ))
    return found


def _square(one: Array, other: Array) -> Array:
    """Return the factors of the six numbers of a symmetric Q in one^T Q other."""
    a, b, c = one.T
    x, y, z = other.T
    return np.stack([a * x, a * y + b * x, a * z + c * x, b * y, b * z + c * y, c * z], axis=1)


def _fitted(views: Array, noise: Array, unknown: Unknown) -> Start:
    """Return the body that views of some instants tell, each with a pose of its own."""
    count, lights = views.shape[:2]
    roots = np.linalg.inv(np.linalg.cholesky(noise))
    equations = Equations(
        Measured(
            np.tile(np.arange(lights), count), angles_of(views.reshape(-1, 3)),
            np.tile(roots, (count, 1, 1)), np.repeat(np.arange(count), lights),
            np.ones((count * lights, 1)),
        ), None, np.ones(2),
    )
    for _ in range(ROUNDS):
        of_rays = equations.chi2_of_rays(unknown)
        scale = max(float(np.median(of_rays)) / MEDIAN_OF_TWO, 1.0)
        unknown, _, done = adjusted(
            equations, unknown, GATE * scale / np.maximum(of_rays, GATE * scale)
        )
        if done:
            break
    scatter = float(np.sqrt(np.median(equations.chi2_of_rays(unknown)) / MEDIAN_OF_TWO))
    return Start(unknown.places, np.empty(0), unknown.turns, unknown.positions, scatter)


def _check_rigid(start: Start, views: Array, noise: Array, names: Sequence[str]) -> None:
    """Refuse lights that are on no rigid body; name the one that is not, if it is one."""
    allowed = _allowed(views, noise)
    if start.scatter < allowed:
        return
    if len(names) > LEAST_LIGHTS:
        scatters = []
        for light in range(len(names)):
            others = [each for each in range(len(names)) if each != light]
            part = views[:, others]
            scatters.append(_fits(part, noise[others])[0].scatter)
        odd = int(np.argmin(scatters))
        if scatters[odd] < min(allowed, start.scatter / BETTER):
            raise BodyCalibrationError(
                f'{names[odd]} is not rigid with the other lights, or its rays are of another '
                'light; fix it, or leave it out with --lights'
            )
    raise BodyCalibrationError(
        'no rigid body has its lights where they are seen: does each light keep its name, does '
        'the body bend, and is the lens calibrated? Or it was turned too little'
    )


def _whole(
    start: Start, lights: Sequence[int], times: Array, seen: Array, rays: Sequence[Rays],
    names: Sequence[str],
) -> Start:
    """Return it with all lights, and placed at all instants."""
    known = dict(zip(lights, start.places, strict=True))
    noise = [each.covariance.mean(axis=0) for each in rays]
    while True:
        placed, turns, positions = _placed(known, seen, noise)
        left = [light for light in range(len(rays)) if light not in known]
        if not left:
            break
        counts = [int(np.isfinite(seen[placed, light, 0]).sum()) for light in left]
        if max(counts) < LEAST_PLACED:
            raise BodyCalibrationError(
                f'{", ".join(names[light] for light in left)} was not seen together with '
                f'{LEAST_LIGHTS} others at {LEAST_PLACED} instants: turn the body so that the '
                f'camera sees it beside them, or leave it out with --lights'
            )
        light = left[int(np.argmax(counts))]
        known[light] = _met(seen[placed, light], turns, positions)
    if len(placed) < LEAST_PLACED:
        raise BodyCalibrationError(
            f'the body can be placed at {len(placed)} instants only: turn it for half a minute, '
            f'with {LEAST_LIGHTS} lights in view'
        )
    places = np.stack([known[light] for light in range(len(rays))])
    return Start(places, times[placed], turns.as_quat(), positions, start.scatter)


def _placed(
    known: dict[int, Array], seen: Array, noise: Sequence[Array] | Array
) -> tuple[NDArray[np.intp], Rotation, Array]:
    """Return the instants at which these lights tell the pose, turns and positions."""
    names = {light: str(light) for light in known}
    places = np.stack(list(known.values()))
    size = float(np.linalg.norm(places - places.mean(axis=0), axis=1).max())
    body = Body(tuple(names.values()), places, np.full(len(places), DOUBT * size))
    angles = angles_of(seen.reshape(-1, 3)).reshape(*seen.shape[:2], 2) / MRAD
    found: list[tuple[int, Array, Array]] = []
    failed = 0
    for instant in range(len(seen)):
        there = [light for light in known if np.isfinite(seen[instant, light, 0])]
        if len(there) < LEAST_LIGHTS:
            continue
        bearings = [
            (names[light], Bearing(
                angles[instant, light, 0], angles[instant, light, 1], noise[light] / MRAD**2,
            ))
            for light in there
        ]
        pose = _told(body, bearings, found[-1][1:] if found else None)
        if pose is not None:
            found.append((instant, pose.rotation, pose.position))
            continue
        failed += 1
        if failed > MOST_FAILED * len(seen) + LEAST_PLACED:
            break
    if not found:
        return np.empty(0, dtype=np.intp), Rotation.identity(0), np.empty((0, 3))
    instants, rotations, positions = zip(*found, strict=True)
    return np.array(instants), Rotation.from_matrix(np.stack(rotations)), np.stack(positions)


def _told(
    body: Body, bearings: Sequence[tuple[str, Bearing]], last: tuple[Array, Array] | None
) -> Pose | None:
    """Return the pose that follows from the last one, or else the only one that is likely."""
    if last is not None and not is_flat(body.places):
        near = pose_near(body, bearings, *last, gate_sigma=FAR_SIGMA)
        if near is not None:
            return near
    try:
        likely = poses(body, bearings, gate_sigma=FAR_SIGMA)
    except ConstellationError:
        return None
    return likely[0] if len(likely) == 1 else None


def is_flat(places: Array) -> bool:
    """Tell whether lights are in a plane, whose mirror image is its back."""
    size = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(size[2] < IN_PLANE * size[0])


def _met(seen: Array, turns: Rotation, positions: Array) -> Array:
    """Return where on the body rays to a light meet."""
    there = np.isfinite(seen[:, 0])
    back = turns[there].inv()
    rays, eyes = back.apply(seen[there]), back.apply(-positions[there])
    across = np.eye(3) - rays[:, :, None] * rays[:, None, :]
    return np.asarray(np.linalg.solve(
        across.sum(axis=0), np.einsum('nab,nb->a', across, eyes)
    ))

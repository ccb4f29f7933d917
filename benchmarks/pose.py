"""Poses of bodies with lights: beside the bound, and beside OpenCV's solvePnP."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

from benchmarks.accuracy import target_scenes, Tick
from benchmarks.limit import Limit, worst
from benchmarks.ours import CHAMPION, estimate
from benchmarks.scenes import sample
from blob_tracker.camera.model import CameraModel, pinhole_matrix
from blob_tracker.constellation import Body, BodyError, ConstellationError, poses
from blob_tracker.types import Bearing, Location
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
CAMERA = CameraModel(1280, 960, pinhole_matrix(900.0, 1280, 960), np.zeros(5))
SIZE, DISTANCE = 0.3, 2.0  # m: standard deviation of the lights' places is half the size
SIGMA_PX = 0.05
FAR_PX = 40.0  # standard deviation of an outlier
STEP = 1e-6  # m and rad, of the bound's derivatives
WRONG = 60.0  # of the squared error over its covariance; 5e-11 are beyond it
PEERS = {'SQPnP': cv2.SOLVEPNP_SQPNP, 'iterative': cv2.SOLVEPNP_ITERATIVE}


@dataclass(frozen=True)
class Case:
    """Bodies of so many lights, in a plane or not; how many are others', and what is given."""

    lights: int
    flat: bool = False
    outliers: int = 0
    frames: bool = False

    @property
    def name(self) -> str:
        """Say it in words."""
        return (
            f'{self.lights} lights{" in a plane" if self.flat else ""}'
            f'{f", {self.outliers} wrong" if self.outliers else ""}'
            f', {"frames" if self.frames else "bearings"}'
        )


@dataclass(frozen=True)
class Row:
    """
    Poses of one case.

    Parameters
    ----------
    case : Case
        What was given.
    ratio : float
        rms of the six numbers over the bound, of the poses that are certain.
    nees : float
        Mean squared error over the covariance, per number.
    peers : dict of float
        The first for others, by name.
    ambiguous : float
        Share of sights that left more than one pose, %.
    refused, wrong : int
        Sights that gave none, and poses that were given as certain and are another.
    ms : float
        Time of a pose, median.
    count : int
        Sights.

    """

    case: Case
    ratio: float
    nees: float
    peers: dict[str, float]
    ambiguous: float
    refused: int
    wrong: int
    ms: float
    count: int


def cases() -> list[Case]:
    """Return all that is measured."""
    return [
        *(Case(lights, frames=frames) for frames in (False, True) for lights in (4, 5, 8, 16)),
        Case(4, flat=True), Case(5, flat=True), Case(8, flat=True), Case(3),
        Case(5, outliers=1), Case(10, outliers=2), Case(15, outliers=3),
    ]


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(cases())


def run(count: int, tick: Tick) -> list[Row]:
    """Return a row for each case, from `count` sights each."""
    rows = []
    for seed, case in enumerate(cases()):
        tick(f'pose {case.name}')
        rows.append(_row(case, count, np.random.default_rng(2000 + seed)))
    return rows


def limits(rows: Sequence[Row]) -> list[Limit]:
    """Return each target, see `worst`."""
    plain = [row for row in rows if not row.case.outliers and row.case.lights > 3]

    return [
        worst('pose: rms over the bound', 1.02, plain, lambda row: row.ratio),
        worst('pose: NEES/6, least', 0.95, plain, lambda row: row.nees, True),
        worst('pose: NEES/6, greatest', 1.05, plain, lambda row: row.nees),
        worst('pose: another given as certain', 0.0, rows, lambda row: float(row.wrong)),
        worst('pose: time, 4 to 16 lights', 0.3, plain, lambda row: row.ms, unit=' ms'),
    ]


def _row(case: Case, count: int, random: np.random.Generator) -> Row:
    """Return what comes of `count` sights of a case."""
    compared: dict[str, list[float]] = {'': [], **{name: [] for name in PEERS}}
    nees, times = [], []
    ambiguous = refused = wrong = 0
    errors_px, noise = _noise(case, count, random)
    for index in range(count):
        body = _body(case, random)
        places = body.places
        rotation, position = _seen_pose(places, random)
        pixels = _pixels(places, rotation, position) + errors_px[index]
        pixels[:case.outliers] += FAR_PX * random.normal(size=(case.outliers, 2))
        seen = _bearings(pixels, noise[index])
        begin = perf_counter()
        try:
            found = poses(body, list(zip(body.names, seen, strict=True)))
        except ConstellationError:
            refused += 1
            continue
        finally:
            times.append(perf_counter() - begin)
        if len(found) > 1:
            ambiguous += 1
            continue
        error = _error(found[0].rotation, found[0].position, rotation, position)
        squared = float(error @ np.linalg.solve(found[0].covariance, error))
        if squared > WRONG:
            wrong += 1
            continue
        nees.append(squared / 6.0)
        good = slice(case.outliers, None)
        information = _information(places[good], rotation, position, noise[index][good])
        compared[''].append(float(error @ information @ error) / 6.0)
        for name, method in PEERS.items():
            other = _peer(places, pixels, method)
            if other is not None:
                compared[name].append(
                    float(_squared(_error(*other, rotation, position), information))
                )
    ratios = {
        name: float(np.sqrt(np.mean(values))) if values else float('nan')
        for name, values in compared.items()
    }
    mean = float(np.mean(nees)) if nees else float('nan')
    return Row(
        case, ratios.pop(''), mean, ratios, 100.0 * ambiguous / count, refused, wrong,
        1e3 * float(np.median(times)), count,
    )


def _body(case: Case, random: np.random.Generator) -> Body:
    """Return a body with lights anywhere, but in one line."""
    names = tuple(f'light{each}' for each in range(case.lights))
    while True:
        places = 0.5 * SIZE * random.normal(size=(case.lights, 3))
        if case.flat:
            places[:, 2] = 0.0
        try:
            return Body(names, places, np.zeros(case.lights))
        except BodyError:
            continue


def _noise(case: Case, count: int, random: np.random.Generator) -> tuple[Array, Array]:
    """Return (count, n, 2) errors, px, and their (count, n, 2, 2) covariance, px^2."""
    shape = count, case.lights
    if not case.frames:
        return (
            SIGMA_PX * random.normal(size=(*shape, 2)),
            np.broadcast_to(SIGMA_PX**2 * np.eye(2), (*shape, 2, 2)),
        )
    scene = next(iter(target_scenes().values()))
    number = count * case.lights
    off = random.uniform(-0.5, 0.5, (number, 2))
    found = estimate(sample(scene, number, 1, off).windows, CHAMPION)
    middle = (scene.window - 1) // 2
    errors = np.stack([found.x, found.y], axis=1) - middle - off
    return errors.reshape(*shape, 2), found.covariance.reshape(*shape, 2, 2)


def _seen_pose(places: Array, random: np.random.Generator) -> tuple[Array, Array]:
    """Return a pose in which all lights are in the picture."""
    while True:
        rotation = np.asarray(Rotation.random(random_state=random).as_matrix())
        position = np.array([*(0.3 * random.normal(size=2)), DISTANCE])
        ahead = (places @ rotation.T + position)[:, 2].min() > 0.5
        pixels = _pixels(places, rotation, position)
        if ahead and (np.abs(pixels - (639.5, 479.5)) < (620, 460)).all():
            return rotation, position


def _pixels(places: Array, rotation: Array, position: Array) -> Array:
    """Return where lights are imaged, px."""
    points = places @ rotation.T + position
    return np.asarray(points[:, :2] / points[:, 2:] * 900.0 + CAMERA.matrix[:2, 2])


def _bearings(pixels: Array, noise: Array) -> list[Bearing]:
    """Return the bearings of places with their covariance, px^2."""
    return [
        CAMERA.bearing(Location(x, y, covariance, 1.0, 0.0, 1.5, 1.0, 1.0, 0))
        for (x, y), covariance in zip(pixels, noise, strict=True)
    ]


def _error(rotation: Array, position: Array, true: Array, place: Array) -> Array:
    """Return what is off, m and rad."""
    return np.concatenate([
        place - position, Rotation.from_matrix(true @ rotation.T).as_rotvec()
    ])


def _squared(error: Array, information: Array) -> float:
    return float(error @ information @ error) / 6.0


def _information(places: Array, rotation: Array, position: Array, noise: Array) -> Array:
    """
    Return the inverse of the pose's Cramer-Rao bound, by numerical derivatives of the pixels.

    Kept apart from the package: it knows pixels and no bearings.
    """
    slopes = []
    for step in STEP * np.eye(6):
        turn = Rotation.from_rotvec(step[3:]).as_matrix()
        slopes.append((
            _pixels(places, turn @ rotation, position + step[:3])
            - _pixels(places, turn.T @ rotation, position - step[:3])
        ) / (2.0 * STEP))
    return np.asarray(np.einsum('pka,kab,qkb->pq', slopes, np.linalg.inv(noise), slopes))


def _peer(places: Array, pixels: Array, method: int) -> tuple[Array, Array] | None:
    """Return rotation and position by OpenCV, None if it has none; SQPnP is its start."""
    done, turn, position = cv2.solvePnP(
        places, pixels, CAMERA.matrix, None, flags=cv2.SOLVEPNP_SQPNP
    )
    if not done:
        return None
    if method != cv2.SOLVEPNP_SQPNP:
        _, turn, position = cv2.solvePnP(
            places, pixels, CAMERA.matrix, None, turn, position, True, flags=method
        )
    return np.asarray(cv2.Rodrigues(turn)[0]), np.asarray(position[:, 0])

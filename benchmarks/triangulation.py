"""Places of lights by two to eight cameras: beside the bound, and beside linear least squares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter

from benchmarks.accuracy import Tick
from benchmarks.limit import Limit, worst
from blob_tracker.camera.model import CameraModel, pinhole_matrix
from blob_tracker.tracking import (
    CameraPose, Sight, Simultaneous, triangulate, TriangulationError,
)
from blob_tracker.types import Bearing, Location
from blob_tracker.units import MRAD
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
FOCAL_PX = 900.0
CAMERA = CameraModel(1280, 960, pinhole_matrix(FOCAL_PX, 1280, 960), np.zeros(5))
RADIUS_M = 6.0  # of the circle on which the cameras stand, about the light
SPREAD_M = 0.7  # standard deviation of the light's place about the middle
LEAST_SIGMA_PX, MOST_SIGMA_PX = 0.05, 0.2  # of each camera
POSITION_SIGMA, ROTATION_SIGMA, SCALE_SIGMA = 2e-3, 3e-4, 2e-3  # m, rad, relative
FAR_PX = 40.0  # an outlier's error
FEWER = 40  # by which there are fewer sights with outliers, which take longer
LEAST_RATE_HZ, MOST_RATE_HZ = 20.0, 60.0
# Of a light that moves: standard deviation of its velocity, and of how that changes in a second.
SPEED, ACCELERATION = 0.5, 0.6  # m/s and m/s^2
PATH_S, PATH_STEP_S = 1.0, 1e-3
STEP_M, STEP_RAD = 1e-5, 1e-6
WRONG = 45.0  # of the squared error over its covariance; 1e-9 are beyond it
LINEAR, OPENCV, LATEST = 'linear least squares', 'OpenCV triangulatePoints', 'linear, last rays'


@dataclass(frozen=True)
class Case:
    """So many cameras, whether their poses err or they run freely, and how many see another."""

    cameras: int
    poses: bool = False
    free: bool = False
    outliers: int = 0

    @property
    def name(self) -> str:
        """Say it in words."""
        return (
            f'{self.cameras} cameras{", poses err" if self.poses else ""}'
            f'{", free-running" if self.free else ""}'
            f'{f", {self.outliers} wrong" if self.outliers else ""}'
        )


@dataclass(frozen=True)
class Row:
    """
    Positions of one case.

    Parameters
    ----------
    case : Case
        What was given.
    ratio : float
        rms of the error over the bound; of free-running cameras, over the covariance.
    nees : float
        Mean squared error over the covariance, per axis.
    peers : dict of float
        The first for others, by name.
    refused, wrong : int
        Sights without a position, and positions that are another light's.
    ms : float
        Time of a position, median.
    count : int
        Sights.

    """

    case: Case
    ratio: float
    nees: float
    peers: dict[str, float]
    refused: int
    wrong: int
    ms: float
    count: int


def cases() -> list[Case]:
    """Return all that is measured."""
    return [
        *(Case(cameras) for cameras in range(2, 9)),
        *(Case(cameras, poses=True) for cameras in (2, 3, 5, 8)),
        *(Case(cameras, free=True) for cameras in (2, 3, 8)),
        Case(3, outliers=1), Case(5, outliers=2), Case(8, outliers=1), Case(8, outliers=3),
    ]


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(cases())


def run(count: int, tick: Tick) -> list[Row]:
    """Return a row for each case, from `count` sights each."""
    rows = []
    for seed, case in enumerate(cases()):
        tick(f'triangulation {case.name}')
        random = np.random.default_rng(3000 + seed)
        sights = count // FEWER if case.outliers else count
        rows.append((_free_row if case.free else _row)(case, sights, random))
    return rows


def limits(rows: Sequence[Row]) -> list[Limit]:
    """Return each target, see `worst`."""
    plain = [row for row in rows if not row.case.outliers]

    return [
        worst('triangulation: rms over the bound', 1.02, [
            row for row in plain if not row.case.free], lambda row: row.ratio),
        worst('triangulation: NEES/3, least', 0.95, plain, lambda row: row.nees, True),
        worst('triangulation: NEES/3, greatest', 1.05, plain, lambda row: row.nees),
        worst('triangulation: rms over the best peer', 1.0, [
            row for row in rows if row.case.cameras > 2 or row.case.free
        ], lambda row: row.ratio / min(row.peers.values())),
        worst('triangulation: positions of another light', 0.0, rows,
              lambda row: float(row.wrong)),
    ]


def _row(case: Case, count: int, random: np.random.Generator) -> Row:
    """Return what comes of `count` sights of a case by cameras with one trigger."""
    found = _Found()
    for _ in range(count):
        poses, sigmas = _poses(case, random)
        shared = _scale(poses) if case.poses else None
        true = _displaced(poses, shared, random)
        place = SPREAD_M * random.normal(size=3)
        pixels = _pixels(place, true) + sigmas[:, None] * random.normal(size=(len(poses), 2))
        turns = random.uniform(0.0, 2.0 * np.pi, case.outliers)
        pixels[:case.outliers] += FAR_PX * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        good = slice(case.outliers, None)
        information = _information(
            place, poses[good], sigmas[good],
            None if shared is None else shared[6 * case.outliers:, 6 * case.outliers:],
        )
        others = {LINEAR: _linear(pixels, poses)}
        if len(poses) == 2:
            others[OPENCV] = _of_opencv(pixels, poses)
        found.add(_bearings(pixels, sigmas), poses, shared, place, information, others)
    return found.row(case, count)


def _free_row(case: Case, count: int, random: np.random.Generator) -> Row:
    """Return what comes of a light that moves before cameras that run freely."""
    found = _Found()
    while found.sights < count:
        poses, sigmas = _poses(case, random)
        path = _path(random)
        due = sorted(
            (float(time), number)
            for number, rate in enumerate(
                random.uniform(LEAST_RATE_HZ, MOST_RATE_HZ, len(poses)))
            for time in np.arange(random.uniform(0.0, 1.0 / rate), PATH_S, 1.0 / rate)
        )
        pairing = Simultaneous(len(poses), 0.1, ACCELERATION / RADIUS_M / MRAD)
        last: dict[int, Array] = {}
        for time, number in due:
            pixels = _pixels(_along(path, time), poses[number:number + 1])
            last[number] = pixels[0] + sigmas[number] * random.normal(size=2)
            bearing, = _bearings(last[number][None], sigmas[number:number + 1])
            sight = Sight(replace(bearing, stamp_ns=round(1e9 * time)), poses[number])
            for seen in pairing.take(number, sight):
                if len(seen.cameras) < len(poses) or found.sights >= count:
                    continue
                place = _along(path, 1e-9 * seen.sights[0].stamp_ns)
                latest = np.array([last[camera] for camera in seen.cameras])
                found.add(
                    [each.bearing for each in seen.sights], poses, None, place, None,
                    {LATEST: _linear(latest, poses)}, seen.strayed,
                )
    return found.row(case, found.sights)


class _Found:
    """What has come so far."""

    def __init__(self) -> None:
        self.sights = self.refused = self.wrong = 0
        self._nees: list[float] = []
        self._times: list[float] = []
        self._compared: dict[str, list[float]] = {'': []}

    def add(
        self, bearings: Sequence[Bearing], poses: Sequence[CameraPose], shared: Array | None,
        place: Array, information: Array | None, others: dict[str, Array],
        strayed: Array | None = None,
    ) -> None:
        """Triangulate, and hold it against the truth, as others' answers."""
        self.sights += 1
        begin = perf_counter()
        try:
            position = triangulate(bearings, poses, shared=shared, strayed=strayed)
        except TriangulationError:
            self.refused += 1
            return
        finally:
            self._times.append(perf_counter() - begin)
        error = position.position - place
        squared = float(error @ np.linalg.solve(position.covariance, error))
        if squared > WRONG:
            self.wrong += 1
            return
        self._nees.append(squared / 3.0)
        bound = np.linalg.inv(position.covariance) if information is None else information
        for name, other in {'': position.position, **others}.items():
            off = other - place
            self._compared.setdefault(name, []).append(float(off @ bound @ off) / 3.0)

    def row(self, case: Case, count: int) -> Row:
        """Return it."""
        ratios = {name: float(np.sqrt(np.mean(each))) for name, each in self._compared.items()}
        return Row(
            case, ratios.pop(''), float(np.mean(self._nees)), ratios, self.refused, self.wrong,
            1e3 * float(np.median(self._times)), count,
        )


def _poses(case: Case, random: np.random.Generator) -> tuple[list[CameraPose], Array]:
    """Return cameras about the middle, which they look at, and the sigmas of their places, px."""
    poses = []
    round_about = 2.0 * np.pi * (np.arange(case.cameras) / case.cameras + random.uniform())
    for angle in round_about + random.normal(0.0, 0.3, case.cameras):
        place = RADIUS_M * np.array([np.cos(angle), 0.3 * random.normal(), np.sin(angle)])
        ahead = -place / np.linalg.norm(place)
        across = np.cross([0.0, 1.0, 0.0], ahead)
        across /= np.linalg.norm(across)
        rotation = np.stack([across, np.cross(ahead, across), ahead], axis=1)
        poses.append(CameraPose(
            place, rotation, POSITION_SIGMA if case.poses else 0.0,
            ROTATION_SIGMA if case.poses else 0.0,
        ))
    return poses, random.uniform(LEAST_SIGMA_PX, MOST_SIGMA_PX, case.cameras)


def _scale(poses: Sequence[CameraPose]) -> Array:
    """Return the covariance of poses of which the scale is not quite known."""
    along = np.zeros((len(poses), 6))
    along[:, 3:] = SCALE_SIGMA * np.array([pose.position for pose in poses])
    return np.outer(along, along)


def _displaced(
    poses: Sequence[CameraPose], shared: Array | None, random: np.random.Generator
) -> list[CameraPose]:
    """Return where the cameras really are."""
    scale = 0.0 if shared is None else SCALE_SIGMA * random.normal()
    return [
        replace(
            pose,
            position=(1.0 + scale) * pose.position + pose.position_sigma * random.normal(size=3),
            rotation=pose.rotation @ Rotation.from_rotvec(
                pose.rotation_sigma * random.normal(size=3)).as_matrix(),
        )
        for pose in poses
    ]


def _path(random: np.random.Generator) -> Array:
    """Return where a light is whose acceleration is white noise, at even instants, (n, 3), m."""
    steps = random.normal(0.0, ACCELERATION * PATH_STEP_S**0.5, (round(PATH_S / PATH_STEP_S), 3))
    velocities = SPEED * random.normal(size=3) + steps.cumsum(axis=0)
    return np.asarray((velocities * PATH_STEP_S).cumsum(axis=0))


def _along(path: Array, time: float) -> Array:
    """Return where the light is, m."""
    times = PATH_STEP_S * np.arange(len(path))
    return np.array([np.interp(time, times, each) for each in path.T])


def _pixels(place: Array, poses: Sequence[CameraPose]) -> Array:
    """Return where the cameras image a place, px."""
    points = np.array([pose.rotation.T @ (place - pose.position) for pose in poses])
    return np.asarray(points[:, :2] / points[:, 2:] * FOCAL_PX + CAMERA.matrix[:2, 2])


def _bearings(pixels: Array, sigmas: Array) -> list[Bearing]:
    """Return the bearings of places in the pictures."""
    return [
        CAMERA.bearing(Location(x, y, sigma**2 * np.eye(2), 1.0, 0.0, 1.5, 1.0, 1.0, 0))
        for (x, y), sigma in zip(pixels, sigmas, strict=True)
    ]


def _information(
    place: Array, poses: Sequence[CameraPose], sigmas: Array, shared: Array | None
) -> Array:
    """
    Return the inverse of the position's Cramer-Rao bound, by numerical derivatives of the pixels.

    Kept apart from the package: it knows pixels and no bearings.
    """
    slopes = np.array([
        (_pixels(place + step, poses) - _pixels(place - step, poses)).ravel() / (2.0 * STEP_M)
        for step in STEP_M * np.eye(3)
    ])
    noise = np.diag(np.repeat(sigmas**2, 2))
    if shared is not None:
        of_poses = shared + np.diag(np.tile(
            [*3 * [ROTATION_SIGMA**2], *3 * [POSITION_SIGMA**2]], len(poses)))
        by_pose = block_diag(*(_by_pose(place, pose) for pose in poses))
        noise = noise + by_pose @ of_poses @ by_pose.T
    return np.asarray(slopes @ np.linalg.solve(noise, slopes.T))


def _by_pose(place: Array, pose: CameraPose) -> Array:
    """Return the (2, 6) derivative of the pixels by the camera's turn and position."""
    columns = []
    for axis in np.eye(3):
        turn = Rotation.from_rotvec(STEP_RAD * axis).as_matrix()
        ahead, back = (
            replace(pose, rotation=pose.rotation @ each) for each in (turn, turn.T)
        )
        columns.append((_pixels(place, [ahead]) - _pixels(place, [back]))[0] / (2.0 * STEP_RAD))
    for axis in STEP_M * np.eye(3):
        ahead, back = (replace(pose, position=pose.position + each) for each in (axis, -axis))
        columns.append((_pixels(place, [ahead]) - _pixels(place, [back]))[0] / (2.0 * STEP_M))
    return np.stack(columns, axis=1)


def _projections(poses: Sequence[CameraPose]) -> list[Array]:
    """Return the (3, 4) matrix of each camera."""
    return [
        CAMERA.matrix @ np.column_stack([pose.rotation.T, -pose.rotation.T @ pose.position])
        for pose in poses
    ]


def _linear(pixels: Array, poses: Sequence[CameraPose]) -> Array:
    """Return the place by the linear equations of all views (Hartley & Zisserman, 12.2)."""
    rows = [
        coordinate * projection[2] - projection[axis]
        for place, projection in zip(pixels, _projections(poses), strict=True)
        for axis, coordinate in enumerate(place)
    ]
    solution = np.linalg.svd(np.array([row / np.linalg.norm(row[:3]) for row in rows]))[2][-1]
    return np.asarray(solution[:3] / solution[3])


def _of_opencv(pixels: Array, poses: Sequence[CameraPose]) -> Array:
    """Return the place by OpenCV, which takes two cameras."""
    one, other = _projections(poses)
    found = cv2.triangulatePoints(one, other, pixels[0][:, None], pixels[1][:, None])[:, 0]
    return np.asarray(found[:3] / found[3])

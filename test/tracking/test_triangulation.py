"""Where rays meet: at the truth within the covariance that is told, or not at all."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, hypot, pi
import subprocess
import sys

from blob_tracker.tracking import (
    CameraPose, ParallelRays, Position, RaysApart, triangulate, TriangulationError,
)
from blob_tracker.types import Bearing
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

Array = NDArray[np.float64]
COVARIANCE = np.array([[0.01, 0.004], [0.004, 0.02]])  # mrad^2: 0.1 and 0.14 mrad


def looking(position: list[float], *turn: float) -> CameraPose:
    """Return a camera by the roll, pitch and yaw of its optical frame."""
    return CameraPose(np.array(position), Rotation.from_euler('xyz', turn).as_matrix())


# Two that look along x of a frame whose z is up, and a third from aside, turned about all axes.
LEFT = looking([0.0, 2.0, 1.0], -pi / 2, 0.0, -pi / 2)
RIGHT = looking([0.0, -2.0, 1.0], -pi / 2, 0.0, -pi / 2)
ASIDE = looking([12.0, -9.0, 3.0], -1.7, 0.1, 0.2)
PAIR = (LEFT, RIGHT)
TARGET = np.array([15.0, 1.0, 2.5])


def true_bearing(target: Array, pose: CameraPose, covariance: Array = COVARIANCE) -> Bearing:
    """Return what a camera sees without noise."""
    x, y, z = pose.rotation.T @ (target - pose.position)
    return Bearing(1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)), covariance, 7)


def seen(
    target: Array, pose: CameraPose, random: np.random.Generator, covariance: Array = COVARIANCE
) -> Bearing:
    """Return what a camera sees, with noise of that covariance."""
    true = true_bearing(target, pose, covariance)
    azimuth, elevation = random.multivariate_normal([true.azimuth, true.elevation], covariance)
    return replace(true, azimuth=azimuth, elevation=elevation)


def displaced(pose: CameraPose, random: np.random.Generator) -> CameraPose:
    """Return where a camera really is, of which the pose and its sigmas are known."""
    turn = Rotation.from_rotvec(random.normal(0.0, pose.rotation_sigma, 3)).as_matrix()
    return replace(
        pose,
        position=pose.position + random.normal(0.0, pose.position_sigma, 3),
        rotation=pose.rotation @ turn,
    )


def nees(found: Position, target: Array) -> float:
    """Return the squared error over its covariance; 3 on average."""
    error = found.position - target
    return float(error @ np.linalg.solve(found.covariance, error))


def within(total: float, degrees: int) -> bool:
    """Tell whether a sum of squares is in the middle 99.9 % of its distribution."""
    low, high = chi2.ppf([0.0005, 0.9995], degrees)
    return bool(low < total < high)


@pytest.mark.parametrize('poses', [PAIR, (LEFT, RIGHT, ASIDE)], ids=['two', 'three'])
def test_rays_without_noise_meet_at_the_target(poses: tuple[CameraPose, ...]) -> None:
    """To rounding, wherever it is, and with the stamp of the first."""
    for target in (TARGET, np.array([3.0, -4.0, 0.0]), np.array([80.0, 30.0, 20.0])):
        found = triangulate([true_bearing(target, pose) for pose in poses], poses)
        np.testing.assert_allclose(found.position, target, atol=1e-8)
        assert found.chi2 < 1e-9
        assert found.degrees_of_freedom == 2 * len(poses) - 3
        assert found.stamp_ns == 7
        assert not found.systematic.any()


@pytest.mark.parametrize('poses', [PAIR, (LEFT, RIGHT, ASIDE)], ids=['two', 'three'])
def test_errors_are_those_of_the_covariance(poses: tuple[CameraPose, ...]) -> None:
    """NEES and chi-square of 2000 positions within 99.9 % of their distributions."""
    random = np.random.default_rng(1)
    runs = 2000
    found = [
        triangulate([seen(TARGET, pose, random) for pose in poses], poses, gate_sigma=7.0)
        for _ in range(runs)
    ]
    assert within(sum(nees(each, TARGET) for each in found), 3 * runs)
    assert within(sum(each.chi2 for each in found), found[0].degrees_of_freedom * runs)
    bias = np.mean([each.position - TARGET for each in found], axis=0)
    sigma = np.sqrt(found[0].covariance.diagonal() / runs)
    assert (np.abs(bias) < 4.0 * sigma).all()


def test_a_ray_counts_by_its_covariance() -> None:
    """One that is ten times worse moves the position by less than the two good ones do."""
    random = np.random.default_rng(2)
    poses = LEFT, RIGHT, ASIDE
    covariances = COVARIANCE, COVARIANCE, 100.0 * COVARIANCE
    runs = 1000
    found = [
        triangulate(
            [seen(TARGET, *each) for each in zip(poses, 3 * [random], covariances)], poses,
            gate_sigma=7.0,
        )
        for _ in range(runs)
    ]
    assert within(sum(nees(each, TARGET) for each in found), 3 * runs)


@pytest.mark.parametrize(
    'position_sigma, rotation_sigma', [(0.01, 0.0), (0.0, 0.001), (0.005, 0.0005)]
)
def test_errors_of_the_poses_are_in_the_covariance(
    position_sigma: float, rotation_sigma: float
) -> None:
    """Cameras that are elsewhere by their sigmas, each time anew: NEES and chi-square hold."""
    random = np.random.default_rng(3)
    poses = [
        replace(pose, position_sigma=position_sigma, rotation_sigma=rotation_sigma)
        for pose in PAIR
    ]
    runs = 2000
    found = [
        triangulate(
            [seen(TARGET, displaced(pose, random), random) for pose in poses], poses,
            gate_sigma=7.0,
        )
        for _ in range(runs)
    ]
    assert within(sum(nees(each, TARGET) for each in found), 3 * runs)
    assert within(sum(each.chi2 for each in found), runs)


def test_what_the_poses_err_by_does_not_average() -> None:
    """The mean of 300 positions of displaced cameras is off by the systematic part alone."""
    random = np.random.default_rng(4)
    poses = [replace(pose, position_sigma=0.02, rotation_sigma=0.002) for pose in PAIR]
    rigs, looks = 200, 300
    total = 0.0
    for _ in range(rigs):
        true = [displaced(pose, random) for pose in poses]
        # The mean of the noise is drawn at once: its covariance over the number of looks.
        mean = [seen(TARGET, pose, random, COVARIANCE / looks) for pose in true]
        found = triangulate(
            [replace(each, covariance=COVARIANCE) for each in mean], poses, gate_sigma=7.0
        )
        random_part = found.covariance - found.systematic
        error = found.position - TARGET
        total += error @ np.linalg.solve(found.systematic + random_part / looks, error)
        assert np.linalg.eigvalsh(random_part).min() > 0.0
    assert within(total, 3 * rigs)


def with_parallax(ratio: float, distance: float) -> tuple[Array, Array]:
    """Return a target and the covariance by which its parallax is so many of its sigmas."""
    sigma = 1e3 * 4.0 / distance / ratio / np.sqrt(2.0)  # mrad; 4 m between the cameras
    return np.array([distance, 0.0, 1.0]), sigma**2 * np.eye(2)


@pytest.mark.parametrize('ratio, off', [(40.0, 0.05), (10.0, 0.15)])
@pytest.mark.parametrize('distance', [50.0, 2000.0])
def test_nearly_parallel_rays_are_still_right(distance: float, ratio: float, off: float) -> None:
    """The distance is not quite Gaussian any more: NEES is so far off as 1 / ratio tells."""
    random = np.random.default_rng(5)
    target, covariance = with_parallax(ratio, distance)
    runs = 2000
    found = [
        triangulate(
            [seen(target, pose, random, covariance) for pose in PAIR], PAIR, gate_sigma=7.0
        )
        for _ in range(runs)
    ]
    # 2000 runs know the mean to 0.055, or 2 %.
    assert np.mean([nees(each, target) for each in found]) == pytest.approx(3.0, rel=off)
    # Range is the worst known by far, and is so told.
    deviations = np.sqrt(np.mean([each.covariance.diagonal() for each in found], axis=0))
    assert deviations[0] > 5.0 * deviations[1:].max()
    assert deviations[0] == pytest.approx(distance / ratio, rel=0.1)


@pytest.mark.parametrize('distance', [50.0, 2000.0, 1e9])
def test_parallel_rays_are_refused(distance: float) -> None:
    """Where the distance would be off by a fifth or more; and those that never meet."""
    target, covariance = with_parallax(4.9, distance)
    with pytest.raises(ParallelRays, match='4.9 times the standard deviation of that angle'):
        triangulate([true_bearing(target, pose, covariance) for pose in PAIR], PAIR)
    with pytest.raises(ParallelRays, match='differ by 0 mrad'):
        triangulate([Bearing(10.0, 5.0, COVARIANCE)] * 2, PAIR)


def test_a_light_in_line_with_the_cameras_is_refused() -> None:
    """Between them as well: along their line it may be anywhere."""
    facing = looking([20.0, 2.0, 1.0], -pi / 2, 0.0, pi / 2)
    for target in ([10.0, 2.0, 1.0], [30.0, 2.0, 1.0]):
        for poses in ((LEFT, facing), (facing, LEFT)):
            bearings = [true_bearing(np.array(target), pose) for pose in poses]
            with pytest.raises(ParallelRays, match='or in line with them'):
                triangulate(bearings, poses)


def test_rays_that_meet_behind_a_camera_are_refused() -> None:
    """Each of them: the left camera sees it on the left and the right one on the right."""
    for first, second in ((-100.0, 100.0), (0.0, 200.0), (-200.0, 0.0)):
        with pytest.raises(RaysApart, match='behind camera 1'):
            triangulate(
                [Bearing(first, 0.0, COVARIANCE), Bearing(second, 0.0, COVARIANCE)], PAIR
            )


@pytest.mark.parametrize(
    'sigmas, meet', [(3.0, True), (4.95, True), (5.05, False), (500.0, False)]
)
def test_rays_that_do_not_meet_are_refused(sigmas: float, meet: bool) -> None:
    """One elevation is off by so many sigmas of the difference of both: the gate is at 5."""
    target = np.array([15.0, 0.0, 1.0])
    covariance = 0.01 * np.eye(2)
    one, other = (true_bearing(target, pose, covariance) for pose in PAIR)
    other = replace(other, elevation=other.elevation + sigmas * 0.1 * np.sqrt(2.0))
    if meet:
        assert triangulate([one, other], PAIR).chi2 == pytest.approx(sigmas**2, rel=1e-3)
    else:
        with pytest.raises(RaysApart, match='do not meet: chi-square is .* may be 25.0'):
            triangulate([one, other], PAIR)


MANY = tuple(
    looking([0.0, y, z], -pi / 2, 0.0, -pi / 2 - 0.1 * y)
    for y, z in ((2.0, 1.0), (-2.0, 1.2), (0.3, 3.0), (1.0, -1.0), (-1.0, 4.0))
)
NAMES = 'left', 'right', 'top', 'bottom', 'mast'


@pytest.mark.parametrize('count, odd', [
    (3, (0,)), (3, (2,)), (4, (1,)), (5, (4,)), (5, (0, 3)),
])
def test_rays_of_another_light_are_named_and_left_out(count: int, odd: tuple[int, ...]) -> None:
    """The position is that of the others, the errors those of its covariance."""
    random = np.random.default_rng(10 * count + odd[0])
    poses, runs = MANY[:count], 100
    squared = []
    for _ in range(runs):
        bearings = [seen(TARGET, pose, random) for pose in poses]
        for each in odd:
            # Away from the others' planes, so that which it is can be told.
            bearings[each] = replace(
                bearings[each], azimuth=bearings[each].azimuth + 9.0 + 7.0 * each,
                elevation=bearings[each].elevation + 5.0 - 3.0 * each,
            )
        found = triangulate(bearings, poses, names=NAMES[:count])
        assert [each.name for each in found.outliers] == [NAMES[each] for each in odd]
        assert min(each.sigmas for each in found.outliers) > 20.0
        assert found.degrees_of_freedom == 2 * (count - len(odd)) - 3
        squared.append(nees(found, TARGET))
    assert within(sum(squared), 3 * runs)


def test_an_outlier_is_as_far_off_as_is_told() -> None:
    """The one that is off by 3 mrad where its sigma is 0.14, and the others' tell the position."""
    bearings = [true_bearing(TARGET, pose) for pose in MANY]
    bearings[2] = replace(bearings[2], elevation=bearings[2].elevation + 3.0)
    outlier, = triangulate(bearings, MANY).outliers
    assert outlier.name == 'camera 3'
    deviation = np.sqrt(np.linalg.inv(COVARIANCE)[1, 1])  # by its own covariance alone
    assert 0.7 * 3.0 * deviation < outlier.sigmas < 3.0 * deviation


def test_which_is_of_another_light_may_not_be_told() -> None:
    """In the plane of its ray and another's it meets both: there is no position."""
    poses = MANY[0], MANY[1], looking([0.0, -2.0, 3.0], -pi / 2, 0.0, -pi / 2)
    bearings = [true_bearing(TARGET, pose) for pose in poses]
    # The second sees what is nearer on the ray of the first.
    near = poses[0].position + 0.7 * (TARGET - poses[0].position)
    bearings[1] = true_bearing(near, poses[1])
    with pytest.raises(RaysApart, match='is unknown: .* without (right|top), or without'):
        triangulate(bearings, poses, names=NAMES[:3])
    # All of three lights.
    bearings[2] = true_bearing(TARGET + [0.0, 3.0, 9.0], poses[2])
    bearings[1] = true_bearing(TARGET + [0.0, 0.0, 3.0], poses[1])
    with pytest.raises(RaysApart, match='no more than half of the rays of left, right, top meet'):
        triangulate(bearings, poses, names=NAMES[:3])


def test_an_outlier_that_leaves_parallel_rays_leaves_no_position() -> None:
    """Of three cameras two stand together, and the third sees another light."""
    beside = replace(LEFT, position=LEFT.position + [0.0, 0.002, 0.0])
    poses = LEFT, beside, RIGHT
    bearings = [true_bearing(TARGET, pose) for pose in poses]
    bearings[2] = replace(bearings[2], elevation=bearings[2].elevation + 20.0)
    with pytest.raises(ParallelRays):
        triangulate(bearings, poses)


@pytest.mark.parametrize('count', [2, 5])
def test_what_poses_err_by_together_is_in_the_covariance(count: int) -> None:
    """A scale, and turns that go with places: NEES holds; chi-square too, for most cancels."""
    random = np.random.default_rng(6)
    poses, runs = MANY[:count], 800
    places = np.array([pose.position for pose in poses])
    spread = 0.0005 * random.normal(size=(6 * count, 8))
    by_scale = np.concatenate([np.zeros((count, 3)), 0.003 * places], axis=1).ravel()
    shared = spread @ spread.T + np.outer(by_scale, by_scale)
    squared = chi_square = 0.0
    for _ in range(runs):
        errors = (
            spread @ random.normal(size=8) + by_scale * random.normal()
        ).reshape(count, 6)
        true = [
            replace(
                pose, position=pose.position + error[3:],
                rotation=pose.rotation @ Rotation.from_rotvec(error[:3]).as_matrix(),
            )
            for pose, error in zip(poses, errors)
        ]
        found = triangulate(
            [seen(TARGET, pose, random) for pose in true], poses, gate_sigma=7.0, shared=shared
        )
        assert np.linalg.eigvalsh(found.covariance - found.systematic).min() > 0.0
        squared += nees(found, TARGET)
        chi_square += found.chi2
    assert within(squared, 3 * runs)
    assert within(chi_square, (2 * count - 3) * runs)


@pytest.mark.parametrize('covariance', [
    np.zeros((2, 2)), np.full((2, 2), np.nan), np.diag([0.01, np.inf]), -COVARIANCE,
    np.array([[0.01, 0.02], [0.02, 0.01]]), np.array([[0.01, 0.004], [-0.004, 0.01]]),
], ids=['zero', 'NaN', 'infinite', 'negative', 'indefinite', 'not symmetric'])
def test_a_covariance_that_cannot_be_is_refused(covariance: Array) -> None:
    """With the covariance in the sentence."""
    bearings = [true_bearing(TARGET, LEFT, covariance), true_bearing(TARGET, RIGHT)]
    with pytest.raises(TriangulationError, match='finite|positive definite'):
        triangulate(bearings, PAIR)


def test_what_is_no_pair_or_pose_is_refused() -> None:
    """A NaN, one ray alone, a matrix that mirrors, a negative sigma."""
    good = true_bearing(TARGET, LEFT)
    with pytest.raises(TriangulationError, match='all must be finite'):
        triangulate([replace(good, azimuth=np.nan), good], PAIR)
    with pytest.raises(TriangulationError, match='bearings: 1, cameras: 1; there must be two'):
        triangulate([good], [LEFT])
    with pytest.raises(ValueError, match='a matrix that turns|that turns and does no more'):
        CameraPose(np.zeros(3), np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(ValueError, match='must be 3 finite numbers'):
        CameraPose(np.array([0.0, np.nan, 0.0]))
    with pytest.raises(ValueError, match='rotation_sigma is -1.0; it must be finite, 0 or more'):
        CameraPose(np.zeros(3), rotation_sigma=-1.0)


def test_the_first_position_waits_for_nothing_to_load() -> None:
    """Once that was done ahead; and SciPy's stats, which takes a second, is not needed at all."""
    code = (
        'import sys; from blob_tracker.tracking import triangulation as it; it.load_ahead(); '
        'before = set(sys.modules); it.load_ahead(); '
        'sys.exit("scipy.stats" in before or bool(set(sys.modules) - before))'
    )
    assert subprocess.run([sys.executable, '-c', code]).returncode == 0

"""A board's calibration against the camera that the views were made with."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.calibration.board import BoardCalibration, calibrate_board
from blob_tracker.calibration.boards import DotGrid, View
from blob_tracker.camera import CalibrationError, CameraModel, LensError
from blob_tracker.simulation.board import BoardScene
import numpy as np
import pytest
from scipy.stats import chi2
from support.boards import ASYMMETRIC, camera, CHARUCO, CHESSBOARD, DOTS, poses, printed

# Where bearings are compared, as parts of width and height: where the views have points.
PLACES = (0.5, 0.2)
SIGMA = 0.08  # px, of simulated corners: what cv2.cornerSubPix reaches on a grainy image


def corners(
    random: np.random.Generator,
    model: CameraModel,
    count: int,
    sigma: float = SIGMA,
    **tilts: tuple[float, float],
) -> list[View]:
    """Return views of the chessboard with Gaussian errors, without images."""
    scene = BoardScene(printed(CHESSBOARD), model)
    y, x = np.divmod(np.arange(54), 9)
    points = 25.0 * np.column_stack([x, y]).astype(float)
    return [
        View(
            points,
            scene.truth(points, pose) + random.normal(0.0, sigma, points.shape),
            (model.width, model.height),
            f'view {index}',
        )
        for index, pose in enumerate(poses(random, CHESSBOARD, model, count=count, **tilts))
    ]


def rendered(random: np.random.Generator, board, model: CameraModel, count: int) -> list[View]:
    """Return views of a board as found in noisy images of it."""
    scene = BoardScene(printed(board), model)
    views: list[View] = []
    for pose in poses(random, board, model, count=count):
        view = board.find(scene.frame(pose, random), f'view {len(views)}')
        assert view is not None
        views.append(view)
    return views


def distances(found: BoardCalibration, true: CameraModel) -> list[float]:
    """Return chi-square of fx, fy, cx, cy, and of the bearing at the centre and far from it."""
    error = found.values[:4] - true.matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
    chi = [float(error @ np.linalg.solve(found.covariance[:4, :4], error))]
    for part in PLACES:
        x, y = part * true.width, part * true.height
        off = np.array(found.model.angles(x, y)[:2]) - true.angles(x, y)[:2]
        chi.append(float(off @ np.linalg.solve(found.bearing_covariance(x, y), off)))
    return chi


def assert_likely(chi: np.ndarray, confidence: float) -> None:
    """Hold each chi-square, summed over the draws, within its bounds, lower and upper."""
    for value, freedom in zip(chi.sum(axis=0), (4, 2, 2)):
        low, high = chi2.ppf([0.5 - confidence / 2, 0.5 + confidence / 2], freedom * len(chi))
        assert low < value < high


@pytest.fixture(scope='module')
def draws() -> dict[str, np.ndarray]:
    """Return the chi-squares of a hundred random cameras, thirty of them from images."""
    random = np.random.default_rng(20)
    chi: dict[str, list[list[float]]] = {}
    for model, count in (('plumb_bob', 40), ('rational_polynomial', 15), ('equidistant', 15)):
        for _ in range(count):
            true = camera(random, model)
            found = calibrate_board(corners(random, true, 8), model)
            assert not found.left_out
            chi.setdefault(model, []).append(distances(found, true))
    for _ in range(30):
        true = camera(random, width=320)
        found = calibrate_board(rendered(random, CHESSBOARD, true, 8))
        chi.setdefault('from images', []).append(distances(found, true))
    return {name: np.array(values) for name, values in chi.items()}


def test_a_hundred_draws_are_recovered_within_their_uncertainty(draws) -> None:
    """Intrinsics and bearings err as much as the covariance says, no more and no less."""
    every = np.vstack(list(draws.values()))
    assert len(every) == 100
    assert_likely(every, 0.95)


@pytest.mark.parametrize(
    'part', ['plumb_bob', 'rational_polynomial', 'equidistant', 'from images']
)
def test_draws_of_each_lens_model_are_recovered_within_their_uncertainty(draws, part: str) -> None:
    """And no model hides behind the others: 99.9 % bounds, since twelve sums are looked at."""
    assert_likely(draws[part], 0.999)


@pytest.mark.parametrize('board', [CHARUCO, DOTS, ASYMMETRIC])
def test_every_kind_recovers_the_camera(board) -> None:
    """Markers and both grids of dots, from images: the intrinsics err as they say."""
    random = np.random.default_rng(22)
    chi = []
    for _ in range(3):
        true = camera(random)
        chi.append(distances(calibrate_board(rendered(random, board, true, 8)), true)[0])
    # 99.9 %: three cameras with dots, whose rims hold a bias of 0.005 px, are no fine test.
    assert np.sum(chi) < chi2.ppf(0.999, 12)


def test_dots_without_the_offset_of_their_centres_miss_the_camera() -> None:
    """Perspective moves a disc's centroid: left in, it is many sigmas of the focal length."""
    random = np.random.default_rng(23)
    true = camera(random)
    views = rendered(random, ASYMMETRIC, true, 10)
    assert views[0].diameter == pytest.approx(14.0, rel=0.01)
    found = calibrate_board(views)
    blunt = calibrate_board([replace(view, diameter=0.0) for view in views])
    assert blunt.rms > 1.2 * found.rms  # measured 1.34: the camera takes most of the bias up
    assert distances(found, true)[0] < chi2.ppf(0.999, 4) < distances(blunt, true)[0]


def test_a_fish_eye_is_recovered() -> None:
    """Its fit is another function of OpenCV, with flags that moved between versions."""
    random = np.random.default_rng(26)
    true = camera(random, 'equidistant')
    found = calibrate_board(corners(random, true, 8), 'equidistant')
    assert distances(found, true)[0] < chi2.ppf(0.999, 4)


def test_a_strongly_distorted_lens_is_recovered_within_its_uncertainty() -> None:
    """The prior of the denominator weighs by the scatter of the fit, not by that of its start."""
    random = np.random.default_rng(29)
    true = CameraModel(
        640, 480, np.array([[350.0, 0.0, 319.5], [0.0, 350.0, 239.5], [0.0, 0.0, 1.0]]),
        np.array([1.2, 0.3, 0.0, 0.0, 0.02, 1.9, 0.9, 0.1]), 'rational_polynomial',
    )
    chi, sigmas = [], []
    for _ in range(8):
        found = calibrate_board(corners(random, true, 12, 0.02), 'rational_polynomial')
        chi.append(distances(found, true)[0])
        sigmas.append(found.sigma)
    # With the scatter of the start the sum is several times the bound.
    assert np.sum(chi) < chi2.ppf(0.999, 4 * 8)
    # 1164 degrees of freedom each, 8 draws: 0.7 % is the standard error.
    assert np.mean(sigmas) == pytest.approx(0.02, rel=0.03)


def fish_eye() -> BoardCalibration:
    """Return a lens that sees 115 degrees away from its axis in the corners, known to 1 %."""
    matrix = np.array([[200.0, 0.0, 319.5], [0.0, 200.0, 239.5], [0.0, 0.0, 1.0]])
    model = CameraModel(640, 480, matrix, np.array([0.01, 0.0, 0.0, 0.0]), 'equidistant')
    covariance = np.diag([4.0, 4.0, 1.0, 1.0, 1e-4, 1e-4, 1e-4, 1e-4])
    names = ('fx', 'fy', 'cx', 'cy', 'k1', 'k2', 'k3', 'k4')
    none = np.zeros((0, 3))
    return BoardCalibration(model, names, covariance, 0.1, 0.1, (), (), none, none)


def test_bearing_covariance_is_that_of_moved_parameters() -> None:
    """Central differences of the angles, close to the axis and 80 degrees away from it."""
    found = fish_eye()
    for x, y in ((300.0, 250.0), (60.0, 150.0)):
        columns = []
        for step in 1e-4 * np.diag(found.sigmas):
            ends = []
            for sign in (1.0, -1.0):
                fx, fy, cx, cy, *distortion = found.values + sign * step
                matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
                moved = replace(found.model, matrix=matrix, distortion=np.array(distortion))
                ends.append(np.array(moved.angles(x, y)[:2]))
            columns.append((ends[0] - ends[1]) / 2e-4)
        moved_by_sigmas = np.column_stack(columns)
        expected = moved_by_sigmas @ moved_by_sigmas.T
        # Differences of 1e-4 sigma hold seven digits and more.
        assert found.bearing_covariance(x, y) == pytest.approx(
            expected, rel=1e-5, abs=1e-6 * expected.max()
        )


def test_a_bearing_beyond_90_degrees_has_no_covariance() -> None:
    """No figure rather than that of the opposite corner: OpenCV projects no such ray."""
    with pytest.raises(LensError, match='looks 90 degrees or more away from the axis'):
        fish_eye().bearing_covariance(0.0, 0.0)


def test_covariance_shrinks_as_views_are_added() -> None:
    """Four times the views halve the sigmas, within the luck of their poses."""
    random = np.random.default_rng(24)
    true = camera(random)
    views = corners(random, true, 40)
    ratio = calibrate_board(views[:10]).sigmas[:4] / calibrate_board(views).sigmas[:4]
    assert ratio == pytest.approx(np.full(4, 2.0), rel=0.35)


def test_a_wrong_view_is_left_out_and_told_of() -> None:
    """A view whose corners are shaken by a pixel is named; the camera stays what it was."""
    random = np.random.default_rng(25)
    true = camera(random)
    views = corners(random, true, 12)
    spoilt = replace(views[4], places=views[4].places + random.normal(0.0, 1.0, (54, 2)))
    found = calibrate_board([*views[:4], spoilt, *views[5:]])
    assert [view.name for view, _ in found.left_out] == ['view 4']
    assert len(found.views) == 11
    assert distances(found, true)[0] < chi2.ppf(0.999, 4)


def test_sigma_is_that_of_the_corners() -> None:
    """The scatter of the residuals, freed of the parameters, is the noise that was put in."""
    random = np.random.default_rng(26)
    found = calibrate_board(corners(random, camera(random), 20))
    freedom = 2 * 20 * 54 - 9 - 6 * 20
    assert found.sigma == pytest.approx(SIGMA, rel=4.0 / np.sqrt(2.0 * freedom))


def bent(random: np.random.Generator, true: CameraModel, count: int) -> list[View]:
    """Return views in each of which the board is bent anew, 0.2 mm in 100, as paper is."""
    seen: list[View] = []
    for pose in poses(random, CHESSBOARD, true, count=count):
        y, x = np.divmod(np.arange(54), 9)
        points = 25.0 * np.column_stack([x, y]).astype(float)
        across, down = ((points - points.mean(axis=0)) / 100.0).T
        bend = random.normal(0.0, 0.2, 3)
        moved = np.column_stack(
            [bend[0] * across**2 + bend[1] * across * down, bend[2] * down**2]
        )
        places = BoardScene(printed(CHESSBOARD), true).truth(points + moved, pose)
        places = places + random.normal(0.0, 0.05, places.shape)
        seen.append(View(points, places, (true.width, true.height), f'view {len(seen)}'))
    return seen


def test_sigmas_hold_where_the_errors_of_a_view_hang_together() -> None:
    """Points that move together tell less: their number alone makes sigmas too small by four."""
    random = np.random.default_rng(31)
    chi, without = [], []
    for _ in range(12):
        true = camera(random)
        found = calibrate_board(bent(random, true, 12))
        chi.append(distances(found, true)[0])
        without.append(chi[-1] * found.growth)
    low, high = chi2.ppf([0.001, 0.999], 4 * 12)
    # The growth is known to a tenth or two from 12 views, which widens the bounds by as much.
    assert 0.8 * low < np.sum(chi) < 1.2 * high
    assert np.sum(without) > 5.0 * high  # measured 12 to 16 times


def test_two_views_are_too_few() -> None:
    """Says how many it takes."""
    random = np.random.default_rng(27)
    with pytest.raises(CalibrationError, match='found in 2 images; it takes 3'):
        calibrate_board(corners(random, camera(random), 2))


def test_sizes_do_not_mix() -> None:
    """Names both sizes and an image of each."""
    random = np.random.default_rng(28)
    views = corners(random, camera(random), 5)
    views[3] = replace(views[3], size=(320, 240))
    with pytest.raises(CalibrationError, match=r'4 of 640 x 480 px \(view 0\), 1 of 320 x 240'):
        calibrate_board(views)


def test_dots_are_what_the_board_says() -> None:
    """The asymmetric grid as OpenCV counts it."""
    points = DotGrid(4, 3, 10.0, asymmetric=True).points()
    assert points[:6].tolist() == [[0, 0], [20, 0], [40, 0], [60, 0], [10, 10], [30, 10]]

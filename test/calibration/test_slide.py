"""A camera on a slide: scale, direction and focal length within their stated uncertainty."""

from __future__ import annotations

from math import atan2

from blob_tracker.calibration.slide import calibrate_slide, SlideError
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.stats import chi2

DRAWS = 100
SIGMA = 0.02  # px
START, SCALE = np.array([300.0, 120.0]), np.array([-1.7, 0.03])  # px, px per mm
READINGS = np.linspace(0.0, 50.0, 11)  # mm: eleven displacements, as in the thesis
INCH = 25.4  # mm


def seen(
    random: np.random.Generator, *, slide_sigma: float = 0.0, bend: float = 0.0
) -> NDArray[np.float64]:
    """Return the pixels of a slide that stood within slide_sigma of its readings."""
    true = READINGS + slide_sigma * random.standard_normal(len(READINGS))
    bow = np.outer((READINGS / 25.0 - 1.0) ** 2, [0.0, bend])
    noise = SIGMA * random.standard_normal((len(READINGS), 2))
    return START + np.outer(true, SCALE) + bow + noise


@pytest.mark.parametrize('given', [True, False])
@pytest.mark.parametrize('slide_sigma', [0.0, 0.0073, 0.05])
def test_truth_is_within_the_stated_covariance(given: bool, slide_sigma: float) -> None:
    """Chi-square of start and scale under their full covariance over 100 draws."""
    random = np.random.default_rng(6)
    squares = []
    for _ in range(DRAWS):
        fit = calibrate_slide(
            READINGS,
            seen(random, slide_sigma=slide_sigma),
            pixel_sigma=np.full((len(READINGS), 2), SIGMA) if given else None,
            slide_sigma=slide_sigma,
        )
        error = np.concatenate([fit.start - START, fit.scale - SCALE])
        squares.append(error @ np.linalg.solve(fit.covariance, error))
    low, high = chi2.ppf([0.025, 0.975], 4 * DRAWS) / DRAWS
    if not given:
        # Sigma from the scatter of 9 (across) or 18 degrees of freedom, F and not chi-square.
        freedom = 9 if slide_sigma else 18
        high *= freedom / (freedom - 2) * 1.1
    assert low < np.mean(squares) < high


def test_scale_direction_and_focal_length_have_true_sigmas() -> None:
    """Each derived figure scatters about its truth as its sigma says."""
    random = np.random.default_rng(7)
    distance, distance_sigma = 1000.0, 2.0
    scale = float(np.hypot(*SCALE))
    true = np.array([scale, 1e3 * atan2(-SCALE[1], -SCALE[0]), 1.0 / scale, scale * distance])
    standard = []
    for _ in range(DRAWS):
        fit = calibrate_slide(
            READINGS, seen(random), pixel_sigma=np.full((len(READINGS), 2), SIGMA)
        )
        read = distance + distance_sigma * random.standard_normal()
        found = np.array([
            fit.pixels_per_mm, fit.direction, fit.displacement(1.0),
            fit.focal_length(read, distance_sigma),
        ])
        standard.append((found[:, 0] - true) / found[:, 1])
    low, high = chi2.ppf([0.0125 / 2, 1 - 0.0125 / 2], DRAWS) / DRAWS  # 95 % for all four
    mean = np.mean(np.square(standard), axis=0)
    assert (low < mean).all() and (mean < high).all()


def test_table_5_1_of_the_thesis() -> None:
    """0.1694 inch a pixel at 8 feet; 0.0294 and 0.0147 for 0.10 and 0.05 px at 16 feet."""
    for inches_per_pixel, shift, expected in (
        (0.1694, 1.00, 0.1694), (0.294, 0.10, 0.0294), (0.294, 0.05, 0.0147),
    ):
        readings = INCH * inches_per_pixel * np.arange(11.0)  # the thesis' calipers were imperial
        pixels = np.stack([200.0 + np.arange(11), np.full(11, 240.0)], axis=1)
        pixels = pixels + 0.02 * np.random.default_rng(3).standard_normal(pixels.shape)
        # 0.001 inch is the step of the caliper: uniform within it.
        fit = calibrate_slide(readings, pixels, slide_sigma=0.001 * INCH / np.sqrt(12.0))
        way, sigma = (value / INCH for value in fit.displacement(shift))
        assert way == pytest.approx(expected, abs=4.0 * sigma)
        # "the accuracy presented in the table is unmeasurable" with a caliper of 0.001 inch;
        # eleven displacements together do measure the fourth digit.
        assert sigma < 5e-4


def test_a_straight_path_is_not_called_bent() -> None:
    """The tests of straightness are normal with the sigma that they state."""
    random = np.random.default_rng(8)
    standard = []
    for _ in range(DRAWS):
        fit = calibrate_slide(
            READINGS, seen(random), pixel_sigma=np.full((len(READINGS), 2), SIGMA)
        )
        standard.append([bend.pixels / bend.sigma for bend in fit.bends])
    low, high = chi2.ppf([0.01, 0.99], DRAWS) / DRAWS
    mean = np.mean(np.square(standard), axis=0)
    assert mean.shape == (3,)
    assert (low < mean).all() and (mean < high).all()


def test_a_bent_path_is() -> None:
    """0.3 px of bow across the path at 0.02 px of noise."""
    fit = calibrate_slide(READINGS, seen(np.random.default_rng(9), bend=0.3))
    significant = {bend.kind for bend in fit.bends if bend.significant}
    assert significant == {'across'}


def test_an_oblique_image_plane_shows_along_the_path() -> None:
    """A slide at 3 degrees to the image plane at 1 m: the steps grow."""
    angle = np.radians(3.0)
    depth = 1000.0 - READINGS * np.sin(angle)
    x = 320.0 - 1700.0 * (READINGS - 25.0) * np.cos(angle) / depth
    random = np.random.default_rng(10)
    pixels = np.stack([x, np.full(11, 240.0)], axis=1) + SIGMA * random.standard_normal((11, 2))
    fit = calibrate_slide(READINGS, pixels)
    assert {bend.kind for bend in fit.bends if bend.significant} == {'along'}


@pytest.mark.parametrize('turn, roll', [(0.0, 0.0), (0.1, 100.0), (np.pi / 2 + 0.1, 100.0)])
def test_roll_is_from_the_nearest_axis(turn: float, roll: float) -> None:
    """A slide along the rows or along the columns."""
    path = np.outer(READINGS, [np.cos(turn), np.sin(turn)])
    fit = calibrate_slide(READINGS, 100.0 + path + 1e-6 * np.sin(np.arange(22.0)).reshape(11, 2))
    assert fit.roll[0] == pytest.approx(roll, abs=1e-3)


@pytest.mark.parametrize(
    'change, sentence',
    [
        ({'slide': READINGS[:3], 'pixels': np.ones((3, 2))}, 'read at 3 positions; 4 or more'),
        ({'slide': np.zeros(11)}, 'read at 1 positions'),
        ({'slide': np.full(11, np.nan)}, 'NaN'),
        ({'pixels': np.ones((11, 3))}, 'do not go with'),
        ({'pixels': np.ones((11, 2))}, 'does not move'),
        ({'pixel_sigma': -np.ones((11, 2))}, 'above 0'),
        ({'slide_sigma': -1.0}, 'must be 0 or more'),
    ],
)
def test_what_cannot_be_is_refused(change: dict, sentence: str) -> None:
    """Each with its sentence."""
    arguments = {'slide': READINGS, 'pixels': seen(np.random.default_rng(1))} | change
    with pytest.raises(SlideError, match=sentence):
        calibrate_slide(**arguments)

"""A camera on a servo: the truth of the simulator within the stated uncertainty."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.calibration.turn import calibrate_turn, project
from blob_tracker.calibration.turn_start import TurnError
from blob_tracker.camera import CameraModel, pinhole_matrix
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.stats import chi2

DRAWS = 100
SIGMA = 0.02  # px
TRUE = {
    'fx': 612.0, 'fy': 608.0, 'cx': 331.0, 'cy': 228.0, 'k1': -0.2,
    'azimuth': 0.02, 'elevation': -0.03, 'yaw': 0.012, 'pitch': -0.008, 'roll': 0.02,
}
CAMERA = CameraModel(
    640,
    480,
    np.array([[612.0, 0.0, 331.0], [0.0, 608.0, 228.0], [0.0, 0.0, 1.0]]),
    distortion=np.array([-0.2, 0.05, 0.0, 0.0, 0.0]),
)
GUESS = replace(CAMERA, matrix=pinhole_matrix(500.0, 640, 480))
PAN, TILT = (
    angle.ravel()
    for angle in np.meshgrid(np.linspace(-0.4, 0.4, 5), np.linspace(-0.28, 0.28, 5))
)


def seen(
    random: np.random.Generator | None = None,
    *,
    pan: NDArray[np.float64] = PAN,
    tilt: NDArray[np.float64] = TILT,
    step_sigma: float = 0.0,
    offset: float = 0.0,
    sigma: float = SIGMA,
    camera: CameraModel = CAMERA,
) -> NDArray[np.float64]:
    """Return the pixels of a servo that went to its angles within step_sigma."""
    random = random or np.random.default_rng(1)
    pixels = project(
        camera,
        pan + step_sigma * random.standard_normal(len(pan)),
        tilt + step_sigma * random.standard_normal(len(pan)),
        target=(TRUE['azimuth'], TRUE['elevation']),
        misalignment=(TRUE['yaw'], TRUE['pitch'], TRUE['roll']),
        offset=offset,
    )
    return pixels + sigma * random.standard_normal(pixels.shape)


@pytest.mark.parametrize(
    'given, options',
    [
        (True, {}),
        (False, {}),
        (True, {'step_sigma': 2e-4}),
        (False, {'step_sigma': 1e-3}),
        (True, {'fit_distortion': True}),
        (True, {'offset': 0.01}),
    ],
)
def test_truth_is_within_the_stated_covariance(given: bool, options: dict) -> None:
    """Chi-square of all parameters together, under their full covariance, over 100 draws."""
    random = np.random.default_rng(5)
    guess = GUESS
    if options.get('fit_distortion'):
        guess = replace(GUESS, distortion=np.array([0.0, 0.05, 0.0, 0.0, 0.0]))
    simulated = {name: options[name] for name in ('step_sigma', 'offset') if name in options}
    if not given and options:
        simulated['sigma'] = 1e-4  # the servo's steps are to be all there is
    squares, freedom = [], 0
    for _ in range(DRAWS):
        pixels = seen(random, **simulated)
        fit = calibrate_turn(
            PAN, TILT, pixels, guess,
            pixel_sigma=np.full(pixels.shape, SIGMA) if given else None, **options,
        )
        error = np.array([fit.values[name] - TRUE[name] for name in fit.fitted])
        squares.append(error @ np.linalg.solve(fit.covariance, error))
        freedom = fit.freedom
    parameters = len(error)
    assert parameters == (10 if options.get('fit_distortion') else 9)
    low, high = chi2.ppf([0.025, 0.975], DRAWS * parameters) / DRAWS
    if not given and not options:
        # Sigma from the scatter: p F(p, n) has the mean p n / (n - 2) and is as much wider.
        high *= 1.0 + 2.0 / (freedom - 2) + 1.5 * parameters / freedom / np.sqrt(DRAWS)
    assert low < np.mean(squares) < high


def test_bearings_of_the_result_are_those_of_the_camera() -> None:
    """What it is for: the angles differ by less than 0.1 mrad from corner to corner."""
    pixels = seen()
    model = calibrate_turn(PAN, TILT, pixels, GUESS).model
    for x, y in ((40.0, 40.0), (600.0, 40.0), (320.0, 440.0)):
        # Differences of directions: the principal point's own error turns all of them alike.
        true = np.subtract(CAMERA.angles(x, y)[:2], CAMERA.angles(320.0, 240.0)[:2])
        found = np.subtract(model.angles(x, y)[:2], model.angles(320.0, 240.0)[:2])
        # 0.02 px at 25 places is 0.004 px, 7 urad: a dozen of them.
        np.testing.assert_allclose(found, true, atol=0.08)


@pytest.mark.parametrize('signs', [(-1, 1), (1, -1), (-1, -1)])
def test_servo_that_counts_the_other_way(signs: tuple[int, int]) -> None:
    """A turn about ROS' upward z is to the left: found out, taken, and said."""
    fit = calibrate_turn(signs[0] * PAN, signs[1] * TILT, seen(), GUESS)
    assert fit.values['fx'] == pytest.approx(612.0, abs=5 * fit.sigmas['fx'])
    assert ('to the left' in ' '.join(fit.notes)) == (signs[0] < 0)
    assert ('downwards' in ' '.join(fit.notes)) == (signs[1] < 0)


def test_parallax_makes_the_focal_length_too_long_by_offset_over_range() -> None:
    """Uncorrected, 1 % of it for a lens 50 mm in front of the axes at 5 m."""
    fit = calibrate_turn(PAN, TILT, seen(offset=0.01), GUESS)
    # To a tenth: the correction's own second order.
    assert fit.values['fx'] / TRUE['fx'] - 1.0 == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize('axis', [0, 1])
def test_one_axis_alone_says_what_it_does_not_tell(axis: int) -> None:
    """One focal length and its coordinate of the centre, within their sigmas; a sentence."""
    square = replace(CAMERA, matrix=np.array([[612.0, 0, 331.0], [0, 612.0, 228.0], [0, 0, 1.0]]))
    guess = replace(GUESS, matrix=np.array([[500.0, 0, 331.0], [0, 500.0, 228.0], [0, 0, 1.0]]))
    angles = np.linspace(-0.4, 0.4, 21) * (1.0 if axis == 0 else 0.7)
    still = np.zeros(21)
    pan, tilt = (angles, still) if axis == 0 else (still, angles)
    fit = calibrate_turn(
        pan, tilt, seen(pan=pan, tilt=tilt, camera=square), guess,
        pixel_sigma=np.full((21, 2), SIGMA),
    )
    assert f'only {("pan", "tilt")[axis]} was turned' in fit.notes[0]
    own, other = (('cx', 'cy'), ('cy', 'cx'))[axis]
    assert fit.sigmas[other] == 0.0
    assert fit.values['fx'] == fit.values['fy'] == pytest.approx(612, abs=4 * fit.sigmas['fx'])
    assert fit.values[own] == pytest.approx(TRUE[own], abs=4 * fit.sigmas[own])


def test_short_range_leaves_the_principal_point_vague_and_says_so() -> None:
    """20 mrad of the picture: the focal length is there, the centre is not."""
    pan, tilt = 0.05 * PAN, 0.05 * TILT
    fit = calibrate_turn(pan, tilt, seen(pan=pan, tilt=tilt), GUESS)
    assert any('principal point is known to' in note for note in fit.notes)
    fixed = calibrate_turn(pan, tilt, seen(pan=pan, tilt=tilt), GUESS, fit_centre=False)
    assert fixed.sigmas['cx'] == 0.0
    assert not any('principal point' in note for note in fixed.notes)


def test_one_focal_length() -> None:
    """Square pixels are taken so."""
    fit = calibrate_turn(PAN, TILT, seen(), GUESS, one_focal_length=True)
    assert fit.values['fx'] == fit.values['fy'] == fit.model.matrix[1, 1]
    assert 'fy' not in fit.fitted


def test_wrong_sigmas_grow_the_covariance() -> None:
    """Sigmas a tenth of the scatter are not believed."""
    believed = calibrate_turn(PAN, TILT, seen(), GUESS, pixel_sigma=np.full((25, 2), SIGMA))
    grown = calibrate_turn(PAN, TILT, seen(), GUESS, pixel_sigma=np.full((25, 2), 0.1 * SIGMA))
    assert believed.factor == 1.0
    assert grown.factor > 50.0
    ratio = grown.sigmas['fx'] / believed.sigmas['fx']
    # The scatter of 41 degrees of freedom is known to 11 %, three of which are allowed.
    assert ratio == pytest.approx(1.0, abs=0.33)


def test_degrees_taken_for_milliradians_are_suspected() -> None:
    """A lens of 3 degrees can be, but its pictures are not those: the residuals tell."""
    unit = np.radians(1.0) / 1e-3
    fit = calibrate_turn(PAN / unit, TILT / unit, seen(), GUESS)
    assert any('are the angles in the unit' in note for note in fit.notes)


def few(count: int) -> dict:
    """Return so many stations that are not in a row."""
    chosen = np.random.default_rng(2).permutation(len(PAN))[:count]
    return {'pan': PAN[chosen], 'tilt': TILT[chosen], 'pixels': seen()[chosen]}


@pytest.mark.parametrize(
    'change, sentence',
    [
        (few(4), '4 stations are 8 numbers for 9 unknowns; 5 stations are the least'),
        (few(2), 'stood at 2 different angles'),
        ({'pan': PAN[:4]}, 'do not go with'),
        ({'pan': np.full(25, np.nan)}, 'NaN or infinite'),
        ({'pixels': seen() + 300.0}, 'outside of the 640 x 480 picture'),
        ({'pan': TILT, 'tilt': PAN}, 'columns mixed up'),
        ({'pan': 1e3 * PAN, 'tilt': 1e3 * TILT}, r'no lens does. Are the angles in mrad\?'),
        ({'pan': PAN / 99, 'tilt': TILT / 99}, r'no lens does. Are the angles in degrees\?'),
        ({'pan': 0.5 * TILT, 'tilt': TILT, 'pixels': seen()}, 'always turned together'),
        ({'pixel_sigma': np.zeros((25, 2))}, 'above 0, one for each'),
        ({'step_sigma': -1.0}, 'must be 0 to 1'),
        ({'pixels': np.roll(seen(), 1, axis=0)}, 'no camera sees the target so'),
    ],
)
def test_what_cannot_be_is_refused(change: dict, sentence: str) -> None:
    """Each with its sentence."""
    arguments = {'pan': PAN, 'tilt': TILT, 'pixels': seen(), 'guess': GUESS} | change
    with pytest.raises(TurnError, match=sentence):
        calibrate_turn(**arguments)

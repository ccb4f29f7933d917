"""The phase correction takes off what it can see, says how well, and refuses what it cannot."""

from dataclasses import replace

from blob_tracker.location import correct_phase, learn_phase_correction, locate_batch
from blob_tracker.location import PhaseCorrection
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import LocationError, SensorNoise
import numpy as np
import pytest

NOISE = SensorNoise(gain=4.0, read_noise=1.0)


def core_and_halo(count, seed):
    """Return estimates of an undersampled pulse that is no Gaussian, and where it was, px."""
    random = np.random.default_rng(seed)
    x, y = 3.0 + random.uniform(-0.5, 0.5, (2, count))
    mean = np.full((count, 7, 7), 20.0)
    for peak, sigma in ((300.0, 0.4), (30.0, 1.2)):
        down, across = integrated_profile(7, y, sigma)[0], integrated_profile(7, x, sigma)[0]
        mean += peak * down[:, :, None] * across[:, None, :]
    found = locate_batch(expose(mean, NOISE, random, saturation=4095), noise=NOISE)
    assert found.ok.all()
    return found, np.stack([x, y])


def errors_of(found, truth):
    """Return (2, N) px."""
    return np.stack([found.x, found.y]) - truth


def first_harmonic(phase, error):
    """Return the amplitude of the error's first harmonic in the true phase, px."""
    turn = 2.0 * np.pi * phase
    terms = np.stack([np.sin(turn), np.cos(turn), np.ones_like(turn)], axis=1)
    return np.hypot(*np.linalg.lstsq(terms, error, rcond=None)[0][:2])


def nees(error, covariance):
    """Return the mean normalised squared error of (2, N) errors."""
    return np.einsum('in,nij,jn->n', error, np.linalg.inv(covariance), error).mean()


def test_bias_of_an_undersampled_pulse_is_removed_to_the_standard_error():
    """Learn from some windows, correct others: the harmonic goes, and the covariance holds."""
    learned, _ = core_and_halo(3000, seed=1)
    correction = learn_phase_correction(learned.x, learned.y)
    found, truth = core_and_halo(8000, seed=2)
    corrected = correct_phase(found, correction)
    before, after = errors_of(found, truth), errors_of(corrected, truth)
    for axis in range(2):
        was = first_harmonic(truth[axis], before[axis])
        left = first_harmonic(truth[axis], after[axis])
        assert was > 0.025
        # A Rayleigh amplitude of that standard error stays below 3 of them in 99 of 100 runs.
        assert left < 3.0 * correction.standard_error
    assert after.std() < 0.8 * before.std()
    # The bias makes it 3, the lean that some windows show held in the covariance. Chi-square of
    # the misfit widens this covariance: below 2, not above.
    assert nees(before, found.covariance) > 2.8
    assert 1.5 < nees(after, corrected.covariance) < 2.1


def located(truth, harmonic):
    """Return the phases to which a bias moves the true ones, where one harmonic undoes it."""
    grid = np.linspace(-1.0, 1.0, 1001)
    a, b = harmonic
    true = grid + (a * np.sin(2 * np.pi * grid) - b * np.cos(2 * np.pi * grid)) / (2 * np.pi)
    return np.interp(truth, true, grid)


def test_covariance_holds_the_slope_and_the_standard_error(scene, nees_bounds):
    """
    Have a NEES within its 95 % bounds over 4000 corrections, each learned afresh.

    From 100 positions each, so that the correction's own error counts as much as the noise.
    """
    random = np.random.default_rng(3)
    harmonics, noise, count = {'x': (0.3, 0.1), 'y': (-0.2, 0.2)}, 0.02, 4000
    template = scene(7, 1.2, 200.0, count=1, noise=NOISE).locate('maximum_likelihood')
    errors, covariances = [], []
    for _ in range(count):
        positions, truth, slopes = [], [], []
        for harmonic in harmonics.values():
            true = random.uniform(-0.5, 0.5, 101)
            position = located(true, harmonic)
            turn = 2 * np.pi * position[0]
            # Noise of the pixels, as the method's own covariance states it, is that of f.
            slopes.append(1.0 + harmonic[0] * np.cos(turn) + harmonic[1] * np.sin(turn))
            position[0] += noise * random.standard_normal() / slopes[-1]
            positions.append(position)
            truth.append(true[0])
        correction = learn_phase_correction(positions[0][1:], positions[1][1:])
        one = replace(
            template,
            x=positions[0][:1],
            y=positions[1][:1],
            covariance=np.diag((noise / np.array(slopes)) ** 2)[None],
        )
        corrected = correct_phase(one, correction)
        errors.append(errors_of(corrected, np.array(truth)[:, None])[:, 0])
        covariances.append(corrected.covariance[0])
    low, high = nees_bounds(count)
    assert low < nees(np.array(errors).T, np.array(covariances)) < high


def test_whole_pixels_do_not_matter():
    """Give the same from coordinates of windows and of the frame they were cut from."""
    found, _ = core_and_halo(500, seed=4)
    offsets = np.random.default_rng(5).integers(-2000, 2000, (2, 500))
    frame = replace(found, x=found.x + offsets[0], y=found.y + offsets[1])
    correction = learn_phase_correction(found.x, found.y)
    shifted = learn_phase_correction(frame.x, frame.y)
    # sin 2 pi x of x = 2000 px has lost 4 of its 16 digits.
    np.testing.assert_allclose([*shifted.x, *shifted.y], [*correction.x, *correction.y], atol=1e-9)
    here, there = correct_phase(found, correction), correct_phase(frame, correction)
    np.testing.assert_allclose(there.x - offsets[0], here.x, atol=1e-9)
    np.testing.assert_allclose(there.y - offsets[1], here.y, atol=1e-9)
    np.testing.assert_allclose(there.covariance, here.covariance, atol=1e-12)


def test_what_has_failed_stays_failed():
    """Pass on the failures, whatever numbers stand beside them, and change nothing else."""
    found, _ = core_and_halo(3, seed=6)
    failed = replace(
        found,
        x=np.array([3.0, np.nan, np.inf]),
        failure=np.array([0, 7, 5], dtype=np.uint8),
    )
    corrected = correct_phase(failed, PhaseCorrection((0.3, 0.0), (0.3, 0.0), 400))
    assert list(corrected.failure) == [0, 7, 5]
    assert np.isfinite(corrected.x[0]) and corrected.sigma is failed.sigma


def test_no_bias_is_corrected_by_no_more_than_the_standard_error():
    """Leave evenly spread positions where they are, to 0.225 / sqrt(M) px rms."""
    moved = []
    for seed in range(200):
        x, y = np.random.default_rng(seed).uniform(0.0, 30.0, (2, 400))
        correction = learn_phase_correction(x, y)
        moved += [np.hypot(*correction.x), np.hypot(*correction.y)]
    # The amplitude's square is twice the variance at a phase; 400 of them tell it to 5 %.
    rms = np.sqrt(np.mean(np.square(moved)) / 2) / (2 * np.pi)
    assert rms == pytest.approx(correction.standard_error, rel=0.1)
    assert correction.standard_error == pytest.approx(0.2251 / 20, rel=1e-3)


RANDOM = np.random.default_rng(7)
EVEN = RANDOM.uniform(0.0, 50.0, 400)
REFUSED = {
    'too few': (EVEN[:99], EVEN[:99], '99 positions are too few'),
    'still': (EVEN, 12.3 + 0.05 * RANDOM.standard_normal(400), 'locked .* along y'),
    'half a pixel': (RANDOM.uniform(5.0, 5.5, 400), EVEN, 'locked .* along x'),
    'three quarters of a pixel': (EVEN, RANDOM.uniform(5.0, 5.75, 400), 'empty along y'),
    'rounded to a half': (np.rint(2 * EVEN) / 2, EVEN, 'empty along x'),
    'rounded to a quarter': (np.rint(4 * EVEN) / 4, EVEN, 'empty along x'),
    'NaN': (EVEN, np.where(EVEN > 25.0, np.nan, EVEN), 'NaN or infinity'),
    'shapes': (EVEN, EVEN[:200], r'x is \(400,\) and y \(200,\)'),
    'a table': (EVEN.reshape(2, 200), EVEN.reshape(2, 200), r'must be \(M,\)'),
}


@pytest.mark.parametrize(('x', 'y', 'reason'), REFUSED.values(), ids=REFUSED)
def test_refusals(x, y, reason):
    """Say what is wrong with positions that no bias can explain."""
    with pytest.raises(LocationError, match=reason):
        learn_phase_correction(x, y)


@pytest.mark.parametrize('bias', [0.0, 0.06, 0.1])
def test_a_bias_is_not_refused(bias):
    """Learn from biased positions in 100 runs of 100."""
    for seed in range(100):
        true = np.random.default_rng(seed).uniform(0.0, 40.0, (2, 300))
        x, y = true - bias * np.sin(2.0 * np.pi * true)
        learn_phase_correction(x, y)

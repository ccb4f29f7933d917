"""Locations with the jitter taken off: as accurate as without it, and honest about the rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from blob_tracker.camera import CalibrationError
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.location import locate
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.simulation.line_jitter import line_offsets
from blob_tracker.types import Location, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.stats import chi2

HEIGHT = 480
SIZE = 11
SHOT = SensorNoise(gain=4.0, read_noise=0.5)  # at a peak of 150 DN nearly all is shot noise
READ = SensorNoise(gain=1e6, read_noise=3.0)


def located(
    jitter: LineJitter,
    random: np.random.Generator,
    noise: SensorNoise,
    *,
    sigma: float = 1.5,
    count: int = 1000,
    corrected: bool = True,
    looks: int = 1,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return errors and covariances of blobs at the top of frames that jitter."""
    errors, covariances = [], []
    for _ in range(count):
        x, y = (SIZE - 1) / 2 + random.uniform(-0.5, 0.5, 2)
        top = int(random.integers(0, 60))
        part = slice(top, top + SIZE)
        # The true offsets. A calibration's error is fixed: its covariance is over calibrations.
        offsets = jitter.offsets[part] + jitter.sigma[part] * random.standard_normal(SIZE)
        lit = np.zeros((SIZE, SIZE), np.uint16)
        for _ in range(looks):
            lines = offsets + jitter.sigma_from_frame_to_frame * random.standard_normal(SIZE)
            pulse = pixel_integrated_gaussian((SIZE, SIZE), x + lines, y, sigma)
            mean = 10.0 + 150.0 * pulse
            lit += expose(mean, noise, random, saturation=4095)
        location = locate(Window(lit, y0=top, x0=100, looks=looks), noise=noise)
        if corrected:
            location = jitter.corrected(location, gain=noise.gain, looks=looks)
        errors.append([location.x - x - 100, location.y - y - top])
        covariances.append(location.covariance)
    return np.array(errors), np.array(covariances)


def nees(errors: NDArray[np.float64], covariances: NDArray[np.float64]) -> float:
    """Return the mean normalised squared error; two for a true covariance."""
    return float(np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariances), errors).mean())


@pytest.mark.parametrize('noise', [SHOT, READ])
def test_known_jitter_costs_nothing(noise: SensorNoise) -> None:
    """Corrected, the error is that of frames without jitter; uncorrected it is far from it."""
    known = LineJitter(line_offsets(HEIGHT), np.zeros(HEIGHT), 0.0)
    none = LineJitter(np.zeros(HEIGHT), np.zeros(HEIGHT), 0.0)
    rms = [
        np.sqrt(np.mean(errors[:, 0] ** 2))
        for errors, _ in (
            located(none, np.random.default_rng(1), noise),
            located(known, np.random.default_rng(1), noise),
            located(known, np.random.default_rng(1), noise, corrected=False),
        )
    ]
    # The same noise in all three: what is left of the jitter alone tells them apart.
    assert rms[1] == pytest.approx(rms[0], rel=0.01)
    assert rms[2] > 3.0 * rms[0]


@pytest.mark.parametrize(
    'noise, options',
    [(SHOT, {}), (READ, {}), (SHOT, {'sigma': 1.0}), (SHOT, {'looks': 4}), (READ, {'looks': 4})],
)
def test_covariance_holds_what_is_left(noise: SensorNoise, options: dict) -> None:
    """NEES in its 95 % bounds with uncertain offsets and jitter from frame to frame."""
    jitter = LineJitter(line_offsets(HEIGHT), np.full(HEIGHT, 0.02), 0.05)
    errors, covariances = located(jitter, np.random.default_rng(2), noise, **options)
    low, high = chi2.ppf([0.025, 0.975], 2 * len(errors)) / len(errors)
    assert low < nees(errors, covariances) < high


def location(**changes: Any) -> Location:
    """Return a location in the middle of the picture."""
    base = Location(320.0, 240.0, 1e-4 * np.eye(2), 100.0, 20.0, 2.0, 50.0, 1.0, 0, stamp_ns=42)
    return replace(base, **changes)


def test_lines_are_weighted_by_their_information() -> None:
    """One line off by a pixel: at constant noise exp(-(k - y)^2 / sigma^2) of a sum."""
    sigma = np.sqrt(4.0 + 1.0 / 12.0)
    weights = np.exp(-((np.arange(HEIGHT) - 240.0) / sigma) ** 2)
    for line in (240, 242, 245):
        offsets = np.zeros(HEIGHT)
        offsets[line] = 1.0
        jitter = LineJitter(offsets, np.zeros(HEIGHT), 0.1)
        found = jitter.corrected(location(), gain=1e9)
        assert 320.0 - found.x == pytest.approx(weights[line] / weights.sum(), rel=1e-3)
        effective = weights.sum() ** 2 / (weights**2).sum()
        assert effective == pytest.approx(np.sqrt(2.0 * np.pi) * sigma, rel=1e-3)
        grown = found.covariance - location().covariance
        np.testing.assert_allclose(grown, [[0.01 / effective, 0], [0, 0]], rtol=1e-3)
        assert (found.y, found.stamp_ns, found.snr) == (240.0, 42, 50.0)


@pytest.mark.parametrize('y', [-0.4, 479.4])
def test_at_the_border_the_lines_that_are_there_count(y: float) -> None:
    """The weights still sum to one."""
    jitter = LineJitter(np.full(HEIGHT, 0.25), np.zeros(HEIGHT), 0.0)
    assert jitter.corrected(location(y=y), gain=40.0).x == pytest.approx(319.75)


@pytest.mark.parametrize('field', [0, 1])
def test_a_blob_in_a_field_is_of_its_lines_alone(field: int) -> None:
    """The odd lines are half a pixel to the right; each field has half of a picture's lines."""
    offsets = np.tile([0.0, 0.5], HEIGHT // 2)
    jitter = LineJitter(offsets, np.zeros(HEIGHT), 0.1, sigma_between_fields=0.04)
    whole = jitter.corrected(location(), gain=1e9)
    # The geometric mean of the axes, in lines of the field along y.
    of_field = location(sigma=2.0 / np.sqrt(2.0))
    found = jitter.corrected(of_field, gain=1e9, field=field)
    assert (whole.x, found.x) == pytest.approx((319.75, 320.0 - 0.5 * field), abs=1e-3)
    variance, of_all = (
        each.covariance[0, 0] - location().covariance[0, 0] for each in (found, whole))
    # The lines' boxes are twice as high: a little less than twice the variance.
    assert variance - 0.02**2 == pytest.approx(2.0 * of_all, rel=0.05)


def test_files_of_before_know_of_no_error_between_fields(tmp_path: Path) -> None:
    """It is taken as 0."""
    path = tmp_path / 'line_jitter.yaml'
    LineJitter(np.zeros(4), np.zeros(4), 0.05, 0.01).to_yaml(path)
    assert LineJitter.from_yaml(path).sigma_between_fields == 0.01
    path.write_text(path.read_text().replace('sigma_between_fields: 0.01\n', ''))
    assert LineJitter.from_yaml(path).sigma_between_fields == 0.0


def test_round_trip(tmp_path: Path) -> None:
    """Written and read to a millionth of a pixel, with comments."""
    random = np.random.default_rng(3)
    jitter = LineJitter(0.1 * random.standard_normal(HEIGHT), np.full(HEIGHT, 0.01), 0.05)
    path = tmp_path / 'line_jitter.yaml'
    jitter.to_yaml(path, ['from 20 frames', 'px'])
    assert path.read_text().startswith('# from 20 frames\n# px\nimage_height: 480\n')
    again = LineJitter.from_yaml(path)
    np.testing.assert_allclose(again.offsets, jitter.offsets, atol=1e-6)
    np.testing.assert_allclose(again.sigma, jitter.sigma, atol=1e-6)
    assert again.sigma_from_frame_to_frame == 0.05


@pytest.mark.parametrize(
    'text, sentence',
    [
        ('image_height: 3\noffsets: [0, 0]\nsigma: [0, 0]\nsigma_from_frame_to_frame: 0',
         'is for 2 lines and the picture has 3'),
        ('image_height: 2\noffsets: [0, .nan]\nsigma: [0, 0]\nsigma_from_frame_to_frame: 0',
         'within 10 px'),
        ('image_height: 2\noffsets: [0, 0]\nsigma: [0, -1]\nsigma_from_frame_to_frame: 0',
         'must be 0 to 10 px'),
        ('image_height: 2\noffsets: [0, 0]\nsigma: [0]\nsigma_from_frame_to_frame: 0',
         '2 offsets and 1 sigmas'),
        ('image_height: 2\noffsets: [0, 0]\nsigma: [0, 0]', 'has no sigma_from_frame_to_frame'),
        ('image_height: 2\noffsets: [a, b]\nsigma: [0, 0]', 'wrong form'),
        ('image_height: 0\noffsets: []\nsigma: []\nsigma_from_frame_to_frame: 0', 'a list'),
        ('just words', 'no named values'),
        ('a: [', 'is not YAML'),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, sentence: str) -> None:
    """Each with its sentence, which names the file."""
    path = tmp_path / 'line_jitter.yaml'
    path.write_text(text)
    with pytest.raises(CalibrationError, match=sentence) as raised:
        LineJitter.from_yaml(path)
    assert str(path) in str(raised.value)


def test_missing_file_is_named(tmp_path: Path) -> None:
    """The sentence has its name."""
    with pytest.raises(CalibrationError, match='cannot read the line jitter .*none.yaml'):
        LineJitter.from_yaml(tmp_path / 'none.yaml')

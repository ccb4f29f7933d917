"""Rigs of cameras from a waved light: right poses and clocks with right sigmas, or a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from blob_tracker.calibration.rays import Rays
from blob_tracker.calibration.rig import calibrate_rig, RigCalibration
from blob_tracker.calibration.rig_start import RigError
from blob_tracker.simulation.waved_light import RigCamera, WavedLight
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2 as chi_square

SIGMA = 1e-4  # rad
PAIR = (RigCamera((-1.0, 0.0, 0.0)), RigCamera((1.0, 0.1, 0.0), offset=0.002, roll=0.1))
FOUR = (
    RigCamera((-1.0, 0.0, 0.0), rate=25.0), RigCamera((1.0, 0.0, 0.0), offset=0.012),
    RigCamera((0.0, -1.5, 1.0), rate=60.0, offset=-0.051), RigCamera((0.3, 0.0, 6.0), roll=3.0),
)
LENGTH = float(np.linalg.norm(np.subtract(PAIR[1].position, PAIR[0].position)))
PROBABLE = 1e-4  # of a chi-square further out: one seed in ten thousand


def waved(
    cameras: Sequence[RigCamera], seed: int, *, wand: float = 0.0, seconds: float = 20.0
) -> list[list[Rays]]:
    """Return the rays of each camera to each light."""
    rng = np.random.default_rng(seed)
    light = WavedLight(rng, wand)
    return [
        [Rays(*light.seen(camera, each, seconds, SIGMA, rng)) for each in range(light.lights)]
        for camera in cameras
    ]


def names(cameras: Sequence[RigCamera]) -> list[str]:
    """Return a name for each."""
    return [f'camera_{number}' for number in range(len(cameras))]


def squared_error(result: RigCalibration, cameras: Sequence[RigCamera]) -> tuple[float, int]:
    """Return the squared error over the covariance, and its degrees of freedom."""
    first = cameras[0]
    errors = []
    for number, camera in enumerate(cameras[1:], 1):
        turn = result.rotations[number].T @ first.rotation.T @ camera.rotation
        place = first.rotation.T @ np.subtract(camera.position, first.position)
        errors.append([
            *Rotation.from_matrix(turn).as_rotvec(), *(place - result.positions[number]),
            camera.offset - first.offset - result.offsets[number],
        ])
    error = np.ravel(errors)
    sigma = np.sqrt(np.diag(result.covariance)[7:])
    scaled = result.covariance[7:, 7:] / np.outer(sigma, sigma)
    return float(error / sigma @ np.linalg.solve(scaled, error / sigma)), len(error)


@pytest.mark.parametrize('cameras, wand', [(PAIR, 0.0), (PAIR, 0.5), (FOUR, 0.5)])
def test_the_errors_are_those_of_the_covariance(
    cameras: Sequence[RigCamera], wand: float
) -> None:
    """Any rates and clocks, one camera upside down and from behind; up to six draws together."""
    total, freedom = 0.0, 0
    for seed in range(12 // len(cameras)):
        rng = np.random.default_rng(1000 + seed)
        rays = waved(cameras, seed, wand=wand)
        if wand:
            known = wand + 1e-3 * rng.standard_normal()
            result = calibrate_rig(rays, names(cameras), wand=(known, 1e-3))
        else:
            known = LENGTH + 1e-3 * rng.standard_normal()
            result = calibrate_rig(
                rays, names(cameras), baseline=('camera_0', 'camera_1', known, 1e-3)
            )
        assert result.is_metric
        assert result.factor == 1.0
        assert result.left_out.sum() <= 1  # by chance: a ray in 250 000 is so far out
        # Over their degrees of freedom, of which the path takes many: an rms to a few per cent.
        np.testing.assert_allclose(result.residuals, 1.0, atol=0.15)
        squared, degrees = squared_error(result, cameras)
        total, freedom = total + squared, freedom + degrees
    assert chi_square.ppf(PROBABLE, freedom) < total < chi_square.isf(PROBABLE, freedom)


def test_strays_are_left_out_and_named() -> None:
    """Every thirtieth ray is of something else."""
    rays = waved(PAIR, 3)
    angles = rays[1][0].angles.copy()
    angles[::30] += 0.15
    rays[1][0] = replace(rays[1][0], angles=angles)
    result = calibrate_rig(
        rays, ['left', 'right'], baseline=('left', 'right', LENGTH, 1e-4)
    )
    # The first and last may lie where the other camera saw nothing; a neighbour may go with one.
    assert 0.9 * len(angles[::30]) <= result.left_out[1] < 2 * len(angles[::30])
    assert any('rays of right left out' in note for note in result.notes)
    squared, degrees = squared_error(result, PAIR)
    assert squared < chi_square.isf(PROBABLE, degrees)


def test_a_coded_light_is_dark_at_times() -> None:
    """Rays in the lit bits of a code alone: no gap of the path is longer than its dark bits."""
    code = np.array([1, 1, 0, 1, 0, 0, 1, 0], dtype=bool)
    lit = [
        [each.part(code[(15.0 * each.times).astype(int) % len(code)]) for each in of_camera]
        for of_camera in waved(PAIR, 6, wand=0.5, seconds=40.0)
    ]
    result = calibrate_rig(lit, ['left', 'right'], wand=(0.5, 1e-3))
    squared, degrees = squared_error(result, PAIR)
    assert squared < chi_square.isf(PROBABLE, degrees)
    assert result.used.min() > 0.9 * min(len(each.times) for of in lit for each in of)


def test_without_a_length_there_is_no_scale() -> None:
    """Directions and clocks are right all the same, and the notes say what is missing."""
    result = calibrate_rig(waved(PAIR, 5), ['left', 'right'])
    assert not result.is_metric
    assert 'the scale is unknown' in result.notes[0]
    assert abs(result.offsets[1] - 0.002) < 5.0 * result.offset_sigmas[1]


def test_sigmas_that_are_too_small_are_grown() -> None:
    """Rays of twice the noise that they claim: the sigmas are those of the scatter."""
    claimed = [
        [replace(each, covariance=0.25 * each.covariance) for each in of_camera]
        for of_camera in waved(PAIR, 7)
    ]
    result = calibrate_rig(claimed, ['left', 'right'])
    assert 3.0 < result.factor < 5.0  # the gate takes off some of 4
    assert any('sigmas were grown' in note for note in result.notes)


@pytest.mark.parametrize('change, words', [
    (lambda rays: rays[:1], 'a rig has two or more'),
    (lambda rays: [rays[0], [rays[1][0].part(np.arange(len(rays[1][0].times)) < 20)]],
     'saw the light together'),
    (lambda rays: [rays[0], waved(PAIR, 9)[1]], 'the same light'),
    (lambda rays: [[Rays(each.times, 0.0 * each.angles + each.angles[0], each.covariance)
                    for each in of_camera] for of_camera in rays], 'stayed in one place'),
    (lambda rays: [rays[0], [replace(each, times=np.append(each.times[:-1], 2e9))
                             for each in rays[1]]], 'Some may be 0'),
    (lambda rays: [[replace(each, covariance=1e-12 * each.covariance) for each in of_camera]
                   for of_camera in rays], 'covariances|covariance allows'),
])
def test_no_rig(change, words: str) -> None:
    """Too few, of two lights, of a light that stands still: a sentence each."""
    rays = change(waved(PAIR, 8))
    with pytest.raises(RigError, match=words):
        calibrate_rig(rays, ['left', 'right'][:len(rays)])


@pytest.mark.parametrize('options, words', [
    ({'wand': (0.5, 1e-3)}, 'a wand has two lights'),
    ({'baseline': ('left', 'top', 1.0, 1e-3)}, 'no camera is called top'),
    ({'baseline': ('left', 'left', 1.0, 1e-3)}, 'not left and itself'),
    ({'baseline': ('left', 'right', -1.0, 1e-3)}, 'a length is above 0'),
])
def test_no_such_length(options, words: str) -> None:
    """What cannot tell the scale is refused before anything is fitted."""
    with pytest.raises(RigError, match=words):
        calibrate_rig(waved(PAIR, 8, seconds=1.0), ['left', 'right'], **options)

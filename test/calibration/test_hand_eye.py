"""A camera on a pan/tilt: axes, arms and clock within their sigmas, or a sentence."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.calibration.hand_eye import (
    calibrate_hand_eye, HandEyeCalibration, HandEyeError, Joint,
)
from blob_tracker.calibration.rays import Rays
from blob_tracker.simulation.panned_camera import PannedCamera
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2 as chi_square

Array = NDArray[np.float64]
DRAWS = 20


def camera(seed: int) -> PannedCamera:
    """Return one that is mounted askew, off both axes, before a light some metres away."""
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(rng.normal(0.0, 0.05, 3))
    signs = rng.choice([-1.0, 1.0], 2)
    return PannedCamera(
        turn.apply([0.0, signs[0], 0.0]),
        turn.apply(Rotation.from_rotvec([0.0, 0.0, rng.normal(0.0, 0.01)]).apply(
            [signs[1], 0.0, 0.0])),
        rng.normal(0.0, 0.03, 3), rng.normal(0.0, 0.03, 3),
        np.array([rng.normal(0.0, 0.3), rng.normal(0.0, 0.2), 4.0]), rng.normal(0.0, 0.01),
    )


def measured(
    true: PannedCamera, seed: int, seconds: float = 15.0
) -> tuple[Rays, Joint, Joint]:
    """Return what it sees and where its joints are."""
    rays, (ticks, turns) = true.seen(np.random.default_rng(seed), seconds=seconds)
    return Rays(*rays), Joint(ticks, turns[:, 0]), Joint(ticks, turns[:, 1])


def across(point: Array, axis: Array) -> Array:
    """Return the part of a point that is across an axis."""
    return np.asarray(point - (point @ axis) * axis)


def errors(found: HandEyeCalibration, true: PannedCamera) -> Array:
    """Return what is off, over the sigmas: axes, arms and clock."""
    sigmas = found.sigmas
    off = []
    for axis, expected, name in (
        (found.pan_axis, true.pan_axis, 'pan'), (found.tilt_axis, true.tilt_axis, 'tilt'),
    ):
        size = np.hypot(sigmas[f'{name}_axis_1'], sigmas[f'{name}_axis_2'])
        off.append(float(np.linalg.norm(np.cross(axis, expected)) / size))
    for arm, point, axis, name in (
        (found.pan_arm, true.pan_point, true.pan_axis, 'pan'),
        (found.tilt_arm, true.tilt_point, true.tilt_axis, 'tilt'),
    ):
        size = np.hypot(sigmas[f'{name}_arm_1'], sigmas[f'{name}_arm_2'])
        off.append(float(np.linalg.norm(arm - across(point, axis)) / size))
    off.append((found.clock - true.clock) / sigmas['clock'])
    return np.array(off)


def test_the_truth_is_within_its_own_sigmas() -> None:
    """Over some draws: the squared error of each quantity is what is stated, in the mean."""
    found = []
    for seed in range(DRAWS):
        true = camera(seed)
        result = calibrate_hand_eye(
            *measured(true, seed), distance=(float(np.linalg.norm(true.light)), 0.0))
        assert result.factor == 1.0
        found.append(errors(result, true))
    squared = (np.array(found)**2).mean(axis=0)
    # Of a normal deviate the mean of 20 squares is 1 +- 0.32.
    low, high = chi_square.ppf([1e-4, 1.0 - 1e-4], DRAWS) / DRAWS
    assert (low < squared).all()
    assert (squared < high).all()


def test_without_a_range_arms_are_over_it() -> None:
    """And so are their sigmas."""
    true = camera(3)
    far = float(np.linalg.norm(true.light))
    plain = calibrate_hand_eye(*measured(true, 3))
    metric = calibrate_hand_eye(*measured(true, 3), distance=(far, 0.0))
    assert not plain.is_metric
    np.testing.assert_allclose(far * plain.pan_arm, metric.pan_arm, rtol=1e-6)
    assert far * plain.sigmas['pan_arm_1'] == pytest.approx(metric.sigmas['pan_arm_1'])


def test_a_few_rays_of_other_lights_are_left_out() -> None:
    """They are counted."""
    true = camera(4)
    rays, pan, tilt = measured(true, 4)
    rays.angles[::30] += 0.03
    result = calibrate_hand_eye(rays, pan, tilt, distance=(float(np.linalg.norm(true.light)), 0))
    assert result.left_out == 10
    assert np.abs(errors(result, true)).max() < 4.0


def test_what_cannot_be_told_is_said() -> None:
    """In a sentence each."""
    true = camera(5)
    rays, pan, tilt = measured(true, 5)
    still = Joint(tilt.times, 0.0 * tilt.angles)
    pan_degrees, tilt_degrees = (
        Joint(each.times, np.degrees(each.angles)) for each in (pan, tilt)
    )
    for given, sentence in (
        ((rays.part(rays.times < 1.0), pan, tilt), '20 rays; 40 are the least'),
        ((rays, pan, still), 'tilt turned by 0.0 degrees'),
        ((rays, tilt, pan), 'are the two exchanged'),
        ((rays, pan, pan), 'always turned together'),
        ((rays, pan_degrees, tilt_degrees), 'are the angles in degrees, not rad'),
        (
            (Rays(rays.times + 0.2, rays.angles, rays.covariance), pan, tilt),
            'are they of one clock',
        ),
        ((rays, Joint(pan.times + 100.0, pan.angles), tilt), 'are the stamps of one clock'),
    ):
        with pytest.raises(HandEyeError, match=sentence):
            calibrate_hand_eye(*given)
    moved = Rays(rays.times, rays.angles + 0.1 * np.sin(rays.times)[:, None], rays.covariance)
    with pytest.raises(HandEyeError):
        calibrate_hand_eye(moved, pan, tilt)
    with pytest.raises(HandEyeError, match='pan turned by 1.7 degrees'):
        calibrate_hand_eye(*measured(replace(true, swing=0.015), 5))


@pytest.mark.parametrize('wrong', ['moved', 'tilt below pan'])
def test_a_misfit_that_no_sigma_covers_is_refused(wrong: str) -> None:
    """A light that moves by 3 mrad half-way, or a tilt that carries the pan."""
    true = camera(6)
    if wrong == 'moved':
        rays, pan, tilt = measured(true, 6)
        rays.angles[len(rays.times) // 2:, 0] += 3e-3
    else:
        below = replace(
            true, pan_axis=true.tilt_axis, tilt_axis=true.pan_axis, pan_point=true.tilt_point,
            tilt_point=true.pan_point,
        )
        rays, tilt, pan = measured(below, 6)
    with pytest.raises(HandEyeError, match='the light moved, the tilt carries the pan'):
        calibrate_hand_eye(rays, pan, tilt)

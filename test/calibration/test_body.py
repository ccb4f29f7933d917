"""Bodies from turning them before a camera: right places with right sigmas, or a sentence."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from blob_tracker.calibration.body import BodyCalibration, calibrate_body
from blob_tracker.calibration.body_start import BodyCalibrationError
from blob_tracker.calibration.rays import Rays
from blob_tracker.simulation.turned_body import places_error, TurnedBody
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.stats import chi2 as chi_square

Array = NDArray[np.float64]
NAMES = ('port', 'starboard', 'left', 'right', 'mast')
PLACES = np.array([
    [0.2, 0.15, 0.0], [0.2, -0.15, 0.02], [-0.25, 0.1, 0.1], [-0.2, -0.1, -0.05], [0.0, 0.0, 0.2],
])
FLAT = np.array([[0.15, 0.1, 0.0], [0.15, -0.1, 0.0], [-0.2, -0.1, 0.0], [-0.2, 0.14, 0.0]])
LINE = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.35, 0.0, 0.0]])
SIGMA = 1e-4  # m, of the distance that is measured
PROBABLE = 1e-4  # of a chi-square further out: one seed in ten thousand


def seen(
    places: Array = PLACES, seed: int = 0, *, seconds: float = 8.0, lit: float = 1.0,
    at_once: bool = False, **motion: Any,
) -> list[Rays]:
    """Return the rays of each light."""
    rng = np.random.default_rng(seed)
    body = TurnedBody(places, **motion)
    return [
        Rays(*each) for each in body.seen(rng, seconds=seconds, lit=lit, at_once=at_once)
    ]


def calibrated(
    rays: Sequence[Rays], places: Array = PLACES, error: float = 0.0
) -> BodyCalibration:
    """Return what comes of them and of a measured distance of the first two."""
    names = NAMES[:len(rays)]
    length = float(np.linalg.norm(places[0] - places[1]))
    return calibrate_body(
        rays, names, distance=(names[0], names[1], length + SIGMA * error, SIGMA))


def squared_error(result: BodyCalibration, places: Array) -> tuple[float, int]:
    """Return the squared error over the covariance, whatever the frame, and its degrees."""
    return places_error(result.places, result.covariance, result.size_sigma, places)[:2]


@pytest.mark.parametrize('places, conditions', [
    (PLACES, {}), (PLACES[[0, 1, 2, 4]], {'at_once': True}), (PLACES, {'lit': 0.6}),
])
def test_the_errors_are_those_of_the_covariance(
    places: Array, conditions: dict[str, Any]
) -> None:
    """Five lights each with its own stamps; four at once; lights that are dark at times."""
    total, freedom = 0.0, 0
    for seed in range(3):
        error = np.random.default_rng(1000 + seed).standard_normal()
        result = calibrated(seen(places, seed, **conditions), places, error)
        assert result.factor == 1.0
        assert result.left_out.sum() <= 1  # by chance: a ray in 250 000 is so far out
        squared, degrees = squared_error(result, places)
        total, freedom = total + squared, freedom + degrees
    low, high = chi_square.ppf([PROBABLE, 1.0 - PROBABLE], freedom)
    assert low < total < high


def test_the_residuals_are_over_their_degrees_of_freedom() -> None:
    """
    The way of the body takes two fifths of what the rays say, which is no merit of the lights.

    Each light has some 190 degrees, an rms to 5 %.
    """
    result = calibrated(seen())
    assert result.freedom < 0.65 * 2.0 * result.used.sum()
    assert (result.residuals**2 @ result.used / result.used.sum()) == pytest.approx(
        result.chi2 / result.freedom)
    np.testing.assert_allclose(result.residuals, 1.0, atol=0.2)


def test_lights_in_a_plane() -> None:
    """They are found as well, though their picture is nearly that of their back."""
    result = calibrated(seen(FLAT, 1, turning=0.25), FLAT)
    squared, degrees = squared_error(result, FLAT)
    assert squared < chi_square.isf(PROBABLE, degrees)


def test_the_frame_is_that_of_three_lights() -> None:
    """The two of the distance and the furthest from their line, or those that are named."""
    rays = seen()
    result = calibrated(rays)
    assert result.frame == ('port', 'starboard', 'left')
    np.testing.assert_allclose(result.places[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(result.places[1, 1:], 0.0, atol=1e-12)
    assert result.places[2, 1] > 0.0
    assert result.places[2, 2] == pytest.approx(0.0, abs=1e-12)
    named = calibrate_body(rays, NAMES, frame=('mast', 'left', 'port'))
    np.testing.assert_allclose(named.places[4], 0.0, atol=1e-12)
    assert not named.is_metric
    assert 'the size is unknown' in named.notes[0]


def test_a_light_that_the_body_hides_at_times() -> None:
    """Each is seen for a part of the time, with four others; the last is found from them."""
    rays = seen(seconds=12.0)
    rays[0] = rays[0].part(rays[0].times < 7.0)
    rays[4] = rays[4].part(rays[4].times > 4.0)
    squared, degrees = squared_error(calibrated(rays), PLACES)
    assert squared < chi_square.isf(PROBABLE, degrees)


def test_reflections_are_left_out() -> None:
    """One ray in twenty."""
    rng = np.random.default_rng(5)
    rays, strays = [], 0
    for each in seen():
        stray = rng.uniform(size=len(each.times)) < 0.05
        off = stray[:, None] * rng.normal(0.0, 0.05, each.angles.shape)
        rays.append(Rays(each.times, each.angles + off, each.covariance))
        strays += int(stray.sum())
    result = calibrated(rays)
    assert abs(int(result.left_out.sum()) - strays) < 5
    squared, degrees = squared_error(result, PLACES)
    assert squared < chi_square.isf(PROBABLE, degrees)


def swaying(rays: Sequence[Rays]) -> list[Rays]:
    """Let the third light sway by itself."""
    off = 0.01 * np.sin(9.0 * rays[2].times)[:, None] * [1.0, 0.0]
    swayed = Rays(rays[2].times, rays[2].angles + off, rays[2].covariance)
    return [*rays[:2], swayed, *rays[3:]]


@pytest.mark.parametrize('rays, sentence', [
    (lambda: seen()[:3], '3 lights: port, starboard, left; a body needs 4 or more'),
    (lambda: [each.part(each.times < 2.0) for each in seen()], 'seen together for 1.9. s only'),
    (lambda: seen(LINE), 'the lights are in one line'),
    (lambda: seen(turning=0.0, sway=0.005), 'the body was hardly turned'),
    (lambda: swaying(seen(seconds=4.0)), 'left is not rigid with the other lights'),
    (lambda: [*seen()[:4], seen(seed=1)[4]], 'mast is not rigid with the other lights'),
    (lambda: seen(PLACES[[0, 1, 2, 4]], distance=50.0, seconds=4.0), 'its mirror image explain'),
    (lambda: [
        each.part(each.times < 5.0) if number < 4 else each.part(each.times > 6.0)
        for number, each in enumerate(seen())
    ], 'mast was not seen together with 4 others'),
    (lambda: [
        each.part((each.times % 2.0 < 1.0) == (number % 2 == 0))
        for number, each in enumerate(seen())
    ], '4 lights were seen together for 0.00 s only'),
])
def test_what_is_no_body_is_said(rays: Callable[[], list[Rays]], sentence: str) -> None:
    """In a sentence each."""
    found = rays()
    with pytest.raises(BodyCalibrationError, match=sentence):
        calibrated(found, PLACES)


@pytest.mark.parametrize('options, sentence', [
    ({'distance': ('port', 'lamp', 0.3, 0.001)}, 'no light is called lamp; there are port'),
    ({'distance': ('port', 'port', 0.3, 0.001)}, 'not port alone'),
    ({'distance': ('port', 'mast', 0.3, 0.4)}, 'a deviation of 0.4 m'),
    ({'frame': ('port', 'mast', 'port')}, 'a frame is made of three lights'),
])
def test_a_length_or_a_frame_that_is_none(options: dict[str, Any], sentence: str) -> None:
    """It is refused before anything is computed."""
    with pytest.raises(BodyCalibrationError, match=sentence):
        calibrate_body(seen(seconds=1.0), NAMES, **options)

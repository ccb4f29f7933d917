"""The response from exposures of a still scene, against the one that was put in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from blob_tracker.calibration.response_measurement import ResponseError, ResponseMeasurement
from blob_tracker.calibration.response_series import measure_response, Shot
import numpy as np
from numpy.typing import NDArray
import pytest
from support.gamma import CURVES, NOISE, seen, still_scene

TIMES = (0.0, 1.0, 2.0, 4.0, 7.0, 11.0, 17.0, 26.0)
HEIGHT, WIDTH = 120, 160


@cache
def series(curve: str) -> list[Shot]:
    """Return two frames of each exposure."""
    random = np.random.default_rng(7)
    scene = still_scene(HEIGHT, WIDTH)
    return [shot(time, [seen(curve, time * scene, random) for _ in range(2)]) for time in TIMES]


def shot(time: float, frames: Sequence[NDArray[np.unsignedinteger[Any]]]) -> Shot:
    """Return an exposure."""
    return Shot(time, np.mean(frames, axis=0, dtype=np.float32), tuple(frames[:2]))


@cache
def measured(curve: str) -> ResponseMeasurement:
    """Return the response of a curve."""
    return measure_response(series(curve), camera='front')


def errors(curve: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the error of the light above black in raw DN, and in sigmas, where light is."""
    found = measured(curve)
    response, black = found.response, found.black_level[0]
    fine = np.linspace(0.0, 255.0, 100_001)
    light = np.interp(response.levels, CURVES[curve](fine), fine) / 255.0
    off = (response.linear - black) / (response.linear[-1] - black) - light
    bright = response.levels > 30.0
    slope = np.gradient(response.linear, response.levels) / (response.linear[-1] - black)
    sigma = np.maximum(response.sigma, 1.0) / (response.linear[-1] - black)
    return (off / slope)[bright], (off / sigma)[bright]


@pytest.mark.parametrize('curve, saturation, exponent', [
    ('rec709', 255, 0.55), ('limited', 235, 1.0),
])
def test_the_response_is_the_one_that_was_put_in(
    curve: str, saturation: int, exponent: float
) -> None:
    """To 2 raw DN, as the exposures are taken to be true to 1 %; within 3 of the sigmas."""
    found = measured(curve)
    assert found.response.saturation == saturation
    assert (found.response.width, found.response.height) == (WIDTH, HEIGHT)
    assert found.exponent == pytest.approx(exponent, abs=0.02)
    raw, sigmas = errors(curve)
    assert np.abs(raw).max() < 2.0
    assert np.abs(sigmas).max() < 3.0
    assert not any('sharpens' in each for each in found.warnings)


@pytest.mark.parametrize('curve', ['rec709', 'limited'])
def test_the_noise_of_linear_pixels_is_that_of_the_sensor(curve: str) -> None:
    """And rounding: gain to 15 %, of which rounding takes 10; read noise to as much."""
    found = measured(curve)
    noise = found.noise
    assert noise is not None
    scale = (found.response.linear[-1] - found.black_level[0]) / 255.0
    assert noise.gain * scale == pytest.approx(NOISE.gain, rel=0.15)
    rounding = found.response.slope(found.black_level[0] + 1.0) / np.sqrt(12.0)
    expected = np.hypot(NOISE.read_noise * scale, rounding)
    assert noise.read_noise == pytest.approx(expected, rel=0.2)
    # Raw, the variance does not grow with the light where there is gamma.
    level, variance, _ = found.variances
    dark, bright = variance[level < 80.0].mean(), variance[level > 160.0].mean()
    assert bool(bright < dark) is (curve == 'rec709')


def test_a_camera_of_12_bits() -> None:
    """With a pedestal and far more noise than a DN: to 6 DN of 4095, the noise of a patch."""
    random = np.random.default_rng(12)
    scene = still_scene(240, 320) / 255.0

    def curve(light: NDArray[np.float64]) -> NDArray[np.float64]:
        power = 1.099 * np.clip(light, 1e-9, 1.0) ** 0.45 - 0.099
        return np.asarray(64.0 + 4031.0 * np.where(light < 0.018, 4.5 * light, power))

    def frame(light: NDArray[np.float64]) -> NDArray[np.uint16]:
        noise = np.sqrt(light / 8000.0 + (6.0 / 8000.0) ** 2)
        signal = light + noise * random.standard_normal(light.shape)
        return np.clip(np.rint(curve(signal)), 0, 4095).astype(np.uint16)

    times = (0.0, 1.0, 2.0, 4.0, 6.0, 9.0, 13.0, 18.0, 25.0)
    found = measure_response([shot(t, [frame(t * scene) for _ in range(2)]) for t in times])
    response, black = found.response, found.black_level[0]
    assert (response.bits, response.saturation) == (16, 4095)
    fine = np.linspace(-0.01, 1.0, 100_001)
    light = np.interp(response.levels, curve(fine), fine)
    above = response.linear[-1] - black
    slope = np.gradient(response.linear, response.levels) / above
    off = ((response.linear - black) / above - light) / slope
    assert np.abs(off[response.levels > 200.0]).max() < 6.0


def test_doubled_exposures_are_spoken_of() -> None:
    """A ripple of their period would not be seen."""
    shots = [each for each in series('rec709') if each.exposure in (1.0, 2.0, 4.0)]
    random = np.random.default_rng(1)
    scene = still_scene(HEIGHT, WIDTH)
    shots += [shot(time, [seen('rec709', time * scene, random)]) for time in (8.0, 16.0)]
    found = measure_response(shots)
    assert any('the same multiple of the one before' in each for each in found.warnings)


def test_a_camera_that_sharpens_is_named() -> None:
    """A negative correlation of neighbours' noise."""
    def sharpened(frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
        around = sum(np.roll(frame, by, axis) / 4.0 for by in (-1, 1) for axis in (0, 1))
        return np.clip(np.rint(frame + 0.3 * (frame - around)), 0, 255).astype(np.uint8)

    random = np.random.default_rng(2)
    scene = still_scene(HEIGHT, WIDTH)
    shots = [
        shot(time, [sharpened(seen('rec709', time * scene, random)) for _ in range(2)])
        for time in TIMES
    ]
    assert any('the camera sharpens' in each for each in measure_response(shots).warnings)


def with_frames(shots: list[Shot], changed: dict[int, NDArray[np.uint8]]) -> list[Shot]:
    """Return the shots with other frames in some."""
    return [
        shot(each.exposure, [changed[k]]) if k in changed else each
        for k, each in enumerate(shots)
    ]


def test_what_tells_no_response_is_named() -> None:
    """Each with what to do."""
    shots = series('rec709')
    random = np.random.default_rng(3)
    scene = still_scene(HEIGHT, WIDTH)
    full = np.full((HEIGHT, WIDTH), 255, np.uint8)
    for wrong, reason in (
        ([replace(each, exposure=5.0) for each in shots], 'all exposures are equal'),
        (shots[1:3], 'too few for the response'),
        ([shot(time, [full]) for time in TIMES[1:]], 'every frame is clipped at 255 DN'),
        # Automatic exposure holds the brightness, or a part of the way.
        ([shot(t, [seen('rec709', 9.0 * scene, random)]) for t in TIMES[1:]], 'is on'),
        (with_frames(shots, {6: seen('rec709', 13.5 * scene, random)}), 'off the others'),
        (with_frames(shots, {5: seen('rec709', 11.0 * np.roll(scene, 9, 1), random)}), 'moved'),
        ([shot(t, [seen('rec709', t * scene, random)]) for t in (0.5, 1.0, 2.0)], 'too little'),
        (with_frames(shots, {3: np.zeros((20, 30), np.uint8)}), 'differ in size'),
    ):
        with pytest.raises(ResponseError, match=reason):
            measure_response(wrong)

"""The response from flat frames of unknown light, against the one that was put in."""

from __future__ import annotations

from blob_tracker.calibration.response_flats import response_of_flats
from blob_tracker.calibration.response_measurement import ResponseError, ResponseMeasurement
import numpy as np
from numpy.typing import NDArray
import pytest
from support.gamma import CURVES, NOISE, seen

LIGHTS = (2.0, 5.0, 10.0, 20.0, 35.0, 55.0, 80.0, 110.0, 150.0, 200.0, 240.0, 300.0)
READ_NOISE_E = NOISE.gain * NOISE.read_noise


def pairs(curve: str, lights: tuple[float, ...] = LIGHTS) -> list[tuple[NDArray, NDArray]]:
    """Return two flat frames of each light."""
    random = np.random.default_rng(4)
    return [
        (seen(curve, field, random), seen(curve, field, random))
        for field in (np.full((120, 160), light) for light in lights)
    ]


def error(curve: str, found: ResponseMeasurement) -> float:
    """Return the greatest error of the light above black where it is bright, raw DN."""
    response, black = found.response, found.black_level[0]
    fine = np.linspace(0.0, 255.0, 100_001)
    light = np.interp(response.levels, CURVES[curve](fine), fine) / 255.0
    whole = response.linear[-1] - black
    off = (response.linear - black) / whole - light
    slope = np.gradient(response.linear, response.levels) / whole
    return float(np.abs(off / slope)[response.levels > 40.0].max())


def test_variance_over_level_tells_the_response() -> None:
    """
    With the read noise of the data sheet, to 4 raw DN at 19,200 pixels a pair.

    The variance of each is known to 1 %, and the sum over the levels is that well.
    """
    found = response_of_flats(pairs('rec709'), read_noise=READ_NOISE_E, sensor=(1280, 960))
    assert (found.response.width, found.response.height) == (1280, 960)  # not of the samples
    assert found.response.saturation == 255
    assert error('rec709', found) < 4.0
    assert found.exponent == pytest.approx(0.55, abs=0.03)
    assert any('--read-noise' in each for each in found.warnings)
    noise = found.noise
    assert noise is not None
    scale = found.response.linear[-1] / 255.0
    assert noise.gain * scale == pytest.approx(NOISE.gain, rel=0.15)
    # Half a read noise more or less is within the stated sigma.
    other = response_of_flats(pairs('rec709'), read_noise=1.4 * READ_NOISE_E).response
    pull = (other.linear - found.response.linear)[10:-1] / found.response.sigma[10:-1]
    assert np.abs(pull).max() < 1.5


def test_what_tells_no_response_is_named() -> None:
    """Too few lights, all clipped, and noise that rounding hides."""
    with pytest.raises(ResponseError, match='there are no flat frames'):
        response_of_flats([])
    with pytest.raises(ResponseError, match='every pair is clipped at 255 DN'):
        response_of_flats(pairs('rec709', (400.0,) * 6))
    with pytest.raises(ResponseError, match='are too few for the response'):
        response_of_flats(pairs('rec709', LIGHTS[:5]))
    still = [(first, first) for first, _ in pairs('rec709')]
    with pytest.raises(ResponseError, match='0 of 12 lights show their noise'):
        response_of_flats(still)

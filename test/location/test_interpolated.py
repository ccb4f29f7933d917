"""A narrow light in a picture that was interpolated from a colour mosaic is not where it seems."""

from __future__ import annotations

from blob_tracker.location import locate
from blob_tracker.location.interpolated import doubted
from blob_tracker.location.noise_check import NoiseCheck
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import LocationError, SensorNoise, Window
import cv2
import numpy as np
import pytest

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
BACKGROUND, PEAK, SIZE = 30.0, 120.0, 16  # DN, DN, px
RED = np.tile([[1.0, 0.08], [0.08, 0.02]], (SIZE // 2, SIZE // 2))  # RGGB at 625 nm


def grey(mean: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return the luma of what a camera interpolates from its mosaic."""
    mosaic = expose(mean, NOISE, random, saturation=255)
    # OpenCV names a pattern by its second row and column: BG is RGGB.
    return np.asarray(
        cv2.cvtColor(cv2.cvtColor(mosaic, cv2.COLOR_BAYER_BG2BGR), cv2.COLOR_BGR2GRAY)
    )


@pytest.mark.parametrize('sigma', [0.7, 0.85, 1.0, 1.4])
def test_a_red_light_keeps_its_covariance(sigma: float) -> None:
    """It had NEES of 16, 11, 6 and 2; it takes ten windows to see that neighbours are alike."""
    random = np.random.default_rng(11)
    check, squares = NoiseCheck(NOISE), []
    for index in range(260):
        x, y = 7.5 + random.uniform(-1.0, 1.0, 2)
        light = PEAK * RED * pixel_integrated_gaussian((SIZE, SIZE), x, y, sigma)
        window = Window(
            grey(BACKGROUND + light, random), grey(np.full(RED.shape, BACKGROUND), random), 0, 0,
            round(index * 1e9 / 30), 255,
        )
        try:
            location = locate(window, noise=check.noise)
        except LocationError:
            continue
        location = check.doubted(window, location)
        check.add(window, location)
        if index >= 20:
            error = np.array([location.x - x, location.y - y])
            squares.append(error @ np.linalg.solve(location.covariance, error))
    assert 'interpolated from a colour mosaic, smoothed, or compressed with loss' in check.warning
    assert len(squares) > 200
    # The error depends on the phase: it is no Gaussian, and its mean square is true to a half.
    assert 1.0 < np.mean(squares) < 3.2


def test_a_grey_camera_is_none() -> None:
    """Its noise is white; nothing is added to its covariance."""
    random = np.random.default_rng(12)
    check = NoiseCheck(NOISE)
    for index in range(100):
        light = PEAK * pixel_integrated_gaussian((SIZE, SIZE), 7.3, 7.9, 0.7)
        lit, unlit = (
            expose(mean, NOISE, random, saturation=255)
            for mean in (BACKGROUND + light, np.full(RED.shape, BACKGROUND))
        )
        window = Window(lit, unlit, 0, 0, round(index * 1e9 / 30), 255)
        location = locate(window, noise=NOISE)
        assert check.doubted(window, location) is location
        check.add(window, location)


def test_binned_pixels_have_a_binned_pitch() -> None:
    """The doubt is that of the window's pixels, in sensor pixels along each axis."""
    random = np.random.default_rng(13)
    light = PEAK * pixel_integrated_gaussian((SIZE, SIZE), 7.3, 7.9, 0.8)
    lit = expose(BACKGROUND + light, NOISE, random, saturation=255)
    plain = locate(Window(lit, None, 0, 0, 0, 255), noise=NOISE)
    binned = locate(Window(lit, None, 0, 0, 0, 255, binning=(2, 2)), noise=NOISE)
    added = np.diag(doubted(plain, (1, 1)).covariance - plain.covariance)
    more = np.diag(doubted(binned, (2, 2)).covariance - binned.covariance)
    assert (added > 0.0).all()
    assert more == pytest.approx(4.0 * added, rel=0.05)

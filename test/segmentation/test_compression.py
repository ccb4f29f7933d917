"""JPEG's rounding is in the covariance."""

from __future__ import annotations

from typing import Any

from blob_tracker.capture.pixel_formats.jpeg import luma_quantisation
from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.compression import compression_noise, standard_quantisation
from blob_tracker.types import Frame
import cv2
import numpy as np
import pytest
from support.filtered_flashes import BACKGROUND, digitised, flashes, Floats, judge
from support.gamma import GAMMA, gamma_response, linear_noise


def encoded(pixels: np.ndarray, quality: int) -> bytes:
    """Return the file of a picture."""
    return cv2.imencode('.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


@pytest.mark.parametrize(('quality', 'sigma', 'peak'), [
    (95, 1.5, 120.0), (90, 1.5, 60.0), (80, 1.5, 120.0), (60, 1.5, 120.0), (60, 1.5, 60.0),
    (60, 0.8, 120.0), (60, 3.0, 120.0),
])
def test_the_covariance_is_true(quality: int, sigma: float, peak: float) -> None:
    """Of a true NEES of 2 the mean of 200 flashes has a sigma of 0.14, and more by the tails."""
    def develop(light: Floats, random: np.random.Generator) -> Frame:
        file = encoded(digitised(BACKGROUND + light, random), quality)
        pixels = cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_GRAYSCALE)
        return Frame(pixels.astype(np.uint8), 0, 255, quantisation=luma_quantisation(file))

    found, nees, _ = judge(Segmenter(), flashes(420, sigma, peak, develop, seed=3))
    assert found >= 0.95
    assert 1.4 < nees < 2.8


def candidate(**changes: Any) -> Candidate:
    """Return a blob of sigma 1.5 px and 100 DN."""
    widths = ('sigma_x', 'sigma_y', 'sigma_major', 'sigma_minor')
    shape: dict[str, Any] = dict.fromkeys(widths, 1.5)
    rest = dict.fromkeys(Candidate._fields[:20], 0.0)
    return Candidate(**rest | shape | {'x': 40.0, 'y': 30.0, 'amplitude': 100.0} | changes)


def test_no_compression_adds_no_noise() -> None:
    """And finer steps less than coarse ones."""
    assert compression_noise(None, candidate()) == 0.0
    coarse, fine = (
        compression_noise(standard_quantisation(quality), candidate()) for quality in (60, 90)
    )
    assert 0.3 < fine < coarse


def test_equal_steps_are_white_noise() -> None:
    """Whatever the blob: q / sqrt(12), where all its coefficients are larger than that."""
    for place in (40.0, 43.5):
        noise = compression_noise(np.full((8, 8), 1), candidate(x=place, amplitude=1e6))
        assert noise == pytest.approx(1 / np.sqrt(12), abs=1 / 32)  # told in steps of 1/16


@pytest.mark.parametrize('quality', [1, 10, 49, 50, 75, 95, 100])
def test_the_standard_table_is_that_of_the_encoder(quality: int) -> None:
    """The one of OpenCV is libjpeg's."""
    written = luma_quantisation(encoded(np.zeros((16, 16), np.uint8), quality))
    np.testing.assert_array_equal(standard_quantisation(quality), written)


def test_the_covariance_is_true_of_a_camera_with_gamma() -> None:
    """The rounding is that of raw DN, and the pixels are linear: so are webcams' pictures."""
    response = gamma_response(640, 480)

    def develop(light: Floats, random: np.random.Generator) -> Frame:
        mean = BACKGROUND + light
        noisy = mean + np.sqrt(mean / 20.0 + 0.09) * random.standard_normal(mean.shape)
        raw = 255.0 * (np.clip(noisy, 0.0, 255.0) / 255.0) ** GAMMA
        file = encoded(np.rint(raw).astype(np.uint8), 80)
        pixels = cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_GRAYSCALE)
        frame = Frame(pixels.astype(np.uint8), 0, 255, quantisation=luma_quantisation(file))
        return response.linear_frame(frame)

    found, nees, _ = judge(
        Segmenter(), flashes(420, 1.5, 100.0, develop, seed=3), noise=linear_noise()
    )
    assert found >= 0.95
    assert 1.4 < nees < 2.8

"""The response of a camera: its file, its table, and what it refuses to make linear."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from blob_tracker.camera import CalibrationError
from blob_tracker.camera.response import linear_full_scale, Response
from blob_tracker.location import locate
from blob_tracker.types import Frame, Mosaic, Window
import numpy as np
import pytest
from support.gamma import FINENESS, GAMMA, gamma_response, light_of, linear_noise

RESPONSE = gamma_response()
RAW = np.arange(256, dtype=np.uint8)


def test_the_table_is_the_curve() -> None:
    """Between knots every 5 DN to half a linear DN, a thirtieth of a raw one at full scale."""
    np.testing.assert_allclose(RESPONSE.table.astype(float), FINENESS * light_of(RAW), atol=1.0)
    assert RESPONSE.table[-1] == linear_full_scale(255) == 16 * 255
    raw = 150.0
    slope = FINENESS * light_of(raw) / raw / GAMMA
    assert RESPONSE.slope(float(FINENESS * light_of(raw))) == pytest.approx(slope, rel=0.01)


def test_a_file_is_read_as_it_was_written(tmp_path: Path) -> None:
    """Every value to the fourth digit."""
    path = tmp_path / 'response.yaml'
    named = replace(RESPONSE, camera='front', pixel_format='YUYV', method='exposures')
    named.to_yaml(path, ['by hand'])
    read = Response.from_yaml(path)
    np.testing.assert_allclose(read.linear, named.linear, atol=5e-5)
    assert (read.camera, read.pixel_format, read.method) == ('front', 'YUYV', 'exposures')
    np.testing.assert_array_equal(read.table, named.table)


def test_frames_of_8_and_16_bits_and_of_colours() -> None:
    """Each sample by itself, the clipping level with it; of Y Cb Cr the luma alone."""
    frame = RESPONSE.linear_frame(Frame(RAW.reshape(16, 16), 1, 235))
    np.testing.assert_array_equal(frame.image.ravel(), RESPONSE.table)
    assert frame.image.dtype == np.uint16 and frame.saturation == RESPONSE.table[235]
    colours = np.dstack([RAW.reshape(16, 16)] * 3)
    assert RESPONSE.linear_frame(Frame(colours, 1, 255, layout='rgb')).image.shape == (16, 16, 3)
    luma = RESPONSE.linear_frame(Frame(colours, 1, 255, layout='yuv'))
    assert luma.layout == 'grey' and luma.image.shape == (16, 16)
    levels = np.linspace(0.0, 1023.0, 12)
    deep = Response(levels, 16.0 * levels, np.zeros(12), 128, 96, bits=16)
    wide = deep.linear_frame(Frame(np.array([[0, 512, 1023, 5000]], np.uint16), 1, 1023))
    np.testing.assert_array_equal(wide.image, [[0, 8192, 16368, 16368]])
    assert wide.saturation == 16368


def test_a_window_without_a_segmenter() -> None:
    """A blob that gamma has made broad has its own width again."""
    offset = np.arange(15) - 7.2
    bell = np.exp(-(offset[:, None] ** 2 + offset**2) / 4.5)
    raw = 255.0 * ((2.0 + 140.0 * bell) / 255.0) ** GAMMA
    window = Window(np.rint(raw).astype(np.uint8), saturation=255)
    noise = linear_noise()
    broad = locate(window, noise=noise)
    right = locate(RESPONSE.linear_window(window), noise=noise)
    assert broad.sigma > 1.8
    # The fit integrates over pixels, the blob was sampled: 1/12 px^2 less.
    assert right.sigma == pytest.approx(np.sqrt(1.5**2 - 1.0 / 12.0), abs=0.02)
    assert right.x == pytest.approx(7.2, abs=0.005)
    with pytest.raises(CalibrationError, match='a sum of 4 frames cannot be made linear'):
        RESPONSE.linear_window(replace(window, looks=4))


def test_another_camera_is_refused() -> None:
    """In one sentence, with what would be right."""
    deep = Frame(np.zeros((4, 4), np.uint16), 1, 4095)
    with pytest.raises(CalibrationError, match='for pixels of 8 bits and these have 16'):
        RESPONSE.linear_frame(deep)
    levels = np.array([0.0, 1023.0])
    ten_bits = Response(levels, 16.0 * levels, np.zeros(2), 128, 96, bits=16)
    with pytest.raises(CalibrationError, match='clipped at 1023 DN and these are at 4095 DN'):
        ten_bits.linear_frame(deep)
    with pytest.raises(CalibrationError, match='of a camera with 128 x 96 px and the picture'):
        RESPONSE.check_size(640, 480)
    pixels = np.zeros((4, 4), np.uint8)
    summed = Frame(pixels, 1, 255, mosaic=Mosaic(pixels, np.ones((2, 2), bool), 255))
    with pytest.raises(CalibrationError, match='set channel of the camera to auto'):
        RESPONSE.linear_frame(summed)


@pytest.mark.parametrize('changes, reason', [
    ({'linear': np.array([0.0, 2.0, 1.0])}, 'must not fall'),
    ({'levels': np.array([1.0, 2.0, 255.0])}, 'both begin at 0'),
    ({'levels': np.array([0.0, 2.0, 300.0])}, 'which no pixel of 8 bits'),
    ({'sigma': np.zeros(2)}, 'it needs one of each'),
    ({'linear': np.array([0.0, np.nan, 9.0])}, 'not numbers'),
    ({'bits': 12}, 'not 8 or 16'),
    ({'width': 0}, 'has no response'),
])
def test_what_cannot_be_is_named(changes: dict[str, Any], reason: str) -> None:
    """At once, and not with the first frame."""
    levels = np.array([0.0, 100.0, 255.0])
    values: dict[str, Any] = {'levels': levels, 'linear': levels, 'sigma': np.zeros(3)}
    values |= {'width': 4, 'height': 4}
    with pytest.raises(CalibrationError, match=reason):
        Response(**values | changes)


@pytest.mark.parametrize('text, reason', [
    ('version: 2\n', 'version 2, and this program reads 1'),
    ('levels: [0]\n', 'has no version'),
    ('- 1\n', 'is not a response'),
])
def test_what_is_no_response_is_named(text: str, reason: str, tmp_path: Path) -> None:
    """With the file's name."""
    path = tmp_path / 'response.yaml'
    path.write_text(text)
    with pytest.raises(CalibrationError, match=f'{path}.*{reason}'):
        Response.from_yaml(path)


def test_raw_pixels_of_16_bits_are_told_from_linear_ones() -> None:
    """Linear ones have the DN of the table alone, or the mark of a clipped pixel."""
    response = gamma_response()
    raw = np.arange(0, 4096, 9, dtype=np.uint16)
    linear = response.linear_pixels(np.arange(256, dtype=np.uint8))
    assert response.has_made(linear)
    assert response.has_made(np.append(linear, np.uint16(65535)))
    assert not response.has_made(raw)
    assert not response.has_made(raw.astype(np.uint8))

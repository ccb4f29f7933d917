"""What is rejected because it is over-exposed has a reason that says what to do."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.candidates import table_of
from blob_tracker.segmentation.overexposure import advice, clipped_pixels
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.types import Frame, SensorNoise
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
BLOOMING = Sensor(noise=NOISE, full_well=2550.0, blooming=True)
SHAPE = (96, 128)


@pytest.mark.parametrize('times', [5.0, 6.0, 8.0])
def test_a_light_that_blooms_is_told_of(times: float) -> None:
    """Its charge fills the column: mostly no place, but a word on the exposure."""
    random = np.random.default_rng(31)
    segmenter = Segmenter()
    told = 0
    for index in range(40):
        x, y = random.uniform((60.0, 45.0), (62.0, 47.0))
        mean = np.full(SHAPE, 30.0)
        if index % 2 == 0:
            mean += 255.0 * times * pixel_integrated_gaussian(SHAPE, x, y, 1.5)
        window = segmenter.update(
            Frame(BLOOMING.expose(mean, random), 1 + index * 10**7, 255)
        )
        if index % 2 == 0 and index > 0 and window is None:
            told += 'pixels are clipped: lower the exposure' in segmenter.reason
    assert told >= 10


def test_what_was_clipped_before_and_what_is_not_rejected_stay_as_they_are() -> None:
    """And so does a single pixel."""
    unlit = np.full((40, 40), 30, np.uint8)
    lit = unlit.copy()
    lit[18:23, 18:23] = 255
    contrast = contrast_of(lit, unlit, 255)
    line = candidate_at(20, 20, rejected='what lit up is long')
    light, before = line._replace(rejected=''), line._replace(clipped=1.0)
    assert clipped_pixels(contrast, table_of([light, line, before])) == {1: 25}
    assert advice(25).startswith('25 pixels are clipped')
    lit[18:23, 18:23] = 30
    lit[20, 20] = 255
    alone = contrast_of(lit, unlit, 255)
    assert clipped_pixels(alone, table_of([line])) == {}
    assert advice(0) == ''

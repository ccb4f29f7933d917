"""A light that moves before an interlaced camera: true places at the times of the fields."""

from __future__ import annotations

from collections.abc import Iterator
import math

from blob_tracker.capture.fields import fields
from blob_tracker.location import Locator
from blob_tracker.segmentation import (
    FieldSegmenter, flash_by_name, FrameError, Segmenter,
)
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise
import numpy as np
import pytest
from support.flashes import nees

NOISE = SensorNoise(10.0, 1.0)
WIDTH, HEIGHT = 160, 160
RATE = 25.0  # pictures/s: 50 fields
INTERVAL_NS = 40_000_000
SIGMA, PEAK, BACKGROUND = 1.5, 150.0, 30.0
SPEED = 3.0  # px a field, at the top


def place(time: float) -> tuple[float, float]:
    """Return where the light is, px."""
    angle = SPEED * 2.0 * RATE / math.sqrt(2.0) * time / 45.0
    return 80.0 + 45.0 * math.sin(angle + 0.4), 80.0 + 45.0 * math.sin(1.1 * angle)


def pictures(bits: str, count: int, order: str) -> Iterator[Frame]:
    """Yield interlaced pictures of the light, which holds a bit for a picture."""
    random = np.random.default_rng(6)
    for index in range(count):
        image = np.empty((HEIGHT, WIDTH), np.uint8)
        for half in range(2):
            kind = half if order == 'interlaced_tb' else 1 - half
            x, y = place((index + 0.5 * half) / RATE)
            light = float(bits[index % len(bits)]) * PEAK * pixel_integrated_gaussian(
                (HEIGHT + 1, WIDTH), x, y, SIGMA
            )
            # A line of a field is the sum of two of the sensor's.
            both = 0.5 * (light[kind:HEIGHT + kind:2] + light[kind + 1:HEIGHT + kind + 1:2])
            image[kind::2] = expose(BACKGROUND + both, NOISE, random)
        yield Frame(image, round(1e9 * index / RATE), 255, exposure_ns=1_000_000)


@pytest.mark.parametrize(('mode', 'bits', 'order', 'least'), [
    ('alternate', '10', 'interlaced_tb', 90),
    ('alternate', '10', 'interlaced_bt', 90),
    ('coded', '1101011000', 'interlaced_tb', 80),
])
def test_places_are_true_at_the_stamps_of_the_fields(
    mode: str, bits: str, order: str, least: int
) -> None:
    """Both fields of a lit picture, by an elliptical pulse, with a true covariance."""
    options = {'codes': {'': bits}} if mode == 'coded' else {}
    segmenter = FieldSegmenter(lambda: Segmenter(flash=flash_by_name(mode=mode, **options)))
    locator = Locator()
    errors, covariances, kinds = [], [], set()
    for picture in pictures(bits, 110, order):
        for field in fields(picture, order, INTERVAL_NS):
            window = segmenter.update(field)
            if window is None or picture.stamp_ns < 5 * INTERVAL_NS:
                continue
            assert window.binning == (1, 2)
            found = locator.locate(window, noise=NOISE)
            # That of a light with a code by its phase, which is known to a hundredth of a frame.
            slack_ns = INTERVAL_NS // 100 if mode == 'coded' else 0
            assert abs(found.stamp_ns - field.stamp_ns) <= slack_ns
            x, y = place(found.stamp_ns / 1e9)
            errors.append([found.x - x, found.y - y])
            covariances.append(found.covariance)
            kinds.add(field.y0)
    assert len(errors) >= least and kinds == {0, 1}
    # The mean of N of chi-square with two degrees of freedom, four standard deviations of it.
    assert nees(errors, covariances) == pytest.approx(2.0, abs=8.0 / math.sqrt(len(errors)))


@pytest.mark.parametrize(('binning', 'offsets', 'count'), [
    ((1, 1), (0, 0, 0, 0), 1),
    ((1, 2), (0, 0, 0, 0), 1),  # of a camera that sums lines
    ((1, 2), (0, 1, 0, 1), 2),
    ((1, 2), (21, 20, 21, 20), 2),
    ((2, 4), (0, 2, 0, 2), 2),  # fields of a binned picture
])
def test_each_kind_has_a_segmenter(
    binning: tuple[int, int], offsets: tuple[int, ...], count: int
) -> None:
    """The first is that which there is; none begins afresh."""
    made: list[Segmenter] = []

    def new_segmenter() -> Segmenter:
        made.append(Segmenter())
        return made[-1]

    segmenter = FieldSegmenter(new_segmenter)
    assert segmenter.channel is made[0].channel
    pixels = np.zeros((40, 40), np.uint8)
    for index, y0 in enumerate(offsets):
        assert segmenter.update(Frame(pixels, 10**7 * index, 255, y0=y0, binning=binning)) is None
    assert list(segmenter.of_kind.values()) == made and len(made) == count
    again = FieldSegmenter(new_segmenter, segmenter.of_kind)
    assert again.of_kind == segmenter.of_kind and len(made) == count
    assert 'afresh' not in segmenter.reason
    segmenter.reason = 'another'
    assert segmenter.reason == 'another'
    assert segmenter.repeated_frames == 0 and segmenter.warnings == ()


def test_another_crop_begins_afresh() -> None:
    """As with frames."""
    segmenter = FieldSegmenter(Segmenter)
    pixels = np.zeros((40, 40), np.uint8)
    assert segmenter.update(Frame(pixels, 0, 255)) is None
    with pytest.raises(FrameError, match='afresh'):
        segmenter.update(Frame(pixels, 10**7, 255, y0=20))

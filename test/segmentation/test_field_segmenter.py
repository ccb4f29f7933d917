"""A light that moves before an interlaced camera: true places at the times of the fields."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math

from blob_tracker.capture.fields import fields
from blob_tracker.location import Locator
from blob_tracker.segmentation import (
    FieldSegmenter, flash_by_name, FrameError, Segmenter,
)
from blob_tracker.simulation import (
    expose, InterlacedCamera, Light, periodic, pixel_integrated_gaussian, Scene, Sensor,
)
from blob_tracker.types import Frame, SensorNoise, Window
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
    assert 'starting again' not in segmenter.reason
    segmenter.reason = 'another'
    assert segmenter.reason == 'another'
    assert segmenter.repeated_frames == 0 and segmenter.warnings == ()


def test_another_crop_begins_afresh() -> None:
    """As with frames."""
    segmenter = FieldSegmenter(Segmenter)
    pixels = np.zeros((40, 40), np.uint8)
    assert segmenter.update(Frame(pixels, 0, 255)) is None
    with pytest.raises(FrameError, match='starting again'):
        segmenter.update(Frame(pixels, 10**7, 255, y0=20))


def seen(
    lights: Sequence[Light], count: int, segmenter: FieldSegmenter, hidden: range = range(0)
) -> list[tuple[Frame, Window]]:
    """Return the fields that show a light, with its window; while hidden there is none."""
    found = []
    for index in range(count):
        first, *others = lights[1:] if index in hidden else lights
        camera = InterlacedCamera(Scene(
            first, elements=others, width=WIDTH, height=HEIGHT, rate=2.0 * RATE, exposure=0.1,
            sensor=Sensor(NOISE)))
        for field in fields(camera.picture(index), 'interlaced_tb', INTERVAL_NS):
            window = segmenter.update(field)
            if window is not None:
                found.append((field, window))
    return found


@pytest.mark.parametrize('kind', [0, 1])
@pytest.mark.parametrize('reach', [0.0, 40.0])
def test_a_light_in_step_with_the_fields_is_found(kind: int, reach: float) -> None:
    """It is on in all of one kind and off in the other; half of the fields have it."""
    wave = periodic(RATE, 0.5, 0.25 + 0.5 * kind)
    light = Light(80.3, 81.2, SIGMA, PEAK, wave, reach_x=reach, reach_y=reach)
    segmenter, locator = FieldSegmenter(Segmenter), Locator()
    found = seen([light], 50, segmenter)
    # A second goes by before neighbours are compared, and three more fields confirm it.
    assert len(found) >= 33 and {field.y0 for field, _ in found} == {kind}
    assert 'every other field' in segmenter.finding
    errors, covariances = [], []
    for field, window in found:
        location = locator.locate(window, noise=NOISE)
        truth = light.spot((field.stamp_ns - 1e9) / 1e9)
        errors.append([location.x - truth.x, location.y - truth.y])
        covariances.append(location.covariance)
    # The scene is not subtracted to the line: what that leaves is in the covariance, about.
    assert 0.7 < nees(errors, covariances) < 2.0 + 8.0 / math.sqrt(len(errors))


def test_what_stands_still_is_no_light_in_step_with_the_fields() -> None:
    """Dots of half a line to a line and a half, each in one field more than in the other."""
    random = np.random.default_rng(3)
    places = random.uniform(15.0, 145.0, (3, 8, 2))
    for sigma, each in zip((0.3, 0.6, 1.2), places):
        lights = [Light(x, y, sigma, PEAK) for x, y in each.tolist()]
        assert seen(lights, 30, FieldSegmenter(Segmenter)) == []


@pytest.mark.parametrize('phase', [0.0, 0.5, 1.0])
def test_both_fields_follow_one_of_two_lights(phase: float) -> None:
    """A reflection of like height, at other places in the lines; the same after a dark while."""
    wave = periodic(0.5 * RATE, 0.5, 0.125)
    lights = [
        Light(50.3, 60.2 + phase, SIGMA, PEAK, wave),
        Light(100.3, 90.2 + 0.7 * phase, SIGMA, 0.99 * PEAK, wave),
    ]
    found = seen(lights, 44, FieldSegmenter(Segmenter), hidden=range(20, 23))
    assert len(found) >= 30 and {field.y0 for field, _ in found} == {0, 1}
    assert np.ptp([window.x0 for _, window in found]) < 6


@pytest.mark.parametrize('reach', [5.0, 15.0])
def test_a_light_that_turns_is_followed_in_both_fields(reach: float) -> None:
    """By up to 90 degrees and 20 px a flash; after pictures that come twice or not at all, too."""
    wave = periodic(0.5 * RATE, 0.5, 0.125)
    light = Light(80.3, 79.6, SIGMA, PEAK, wave, reach, 0.67 * reach, period=24 / RATE)
    camera = InterlacedCamera(Scene(
        light, width=WIDTH, height=HEIGHT, rate=2.0 * RATE, exposure=0.1, sensor=Sensor(NOISE)))
    pictures = [list(fields(camera.picture(each), 'interlaced_tb', INTERVAL_NS))
                for each in range(24)]
    broken = [0, 1, 1, 2, 2, 3, 5, 7, 7, 8, 10, 11, 11, 13, 14, 14, 15, 15, 18]
    shown = [*range(24), *broken, *(each % 24 for each in range(19, 67))]
    segmenter = FieldSegmenter(Segmenter)
    found = [
        sum(segmenter.update(replace(
            field, stamp_ns=10**9 + index * INTERVAL_NS + half * INTERVAL_NS // 2
        )) is not None for half, field in enumerate(pictures[number]))
        for index, number in enumerate(shown)
    ]
    assert sum(found[:24]) >= 20
    assert sum(found[-40:]) == 40


def test_a_fast_light_is_one_light() -> None:
    """It goes as far from flash to flash as the gate is wide."""
    wave = periodic(0.5 * RATE, 0.5, 0.125)
    light = Light(80.0, 80.0, SIGMA, PEAK, wave, reach_x=70.0, reach_y=5.0, period=2.9)
    found = seen([light], 44, FieldSegmenter(Segmenter))
    alone = []
    for kind in range(2):
        segmenter = Segmenter()
        camera = InterlacedCamera(Scene(
            light, width=WIDTH, height=HEIGHT, rate=2.0 * RATE, exposure=0.1,
            sensor=Sensor(NOISE)))
        alone += [
            segmenter.update(fields(camera.picture(index), 'interlaced_tb', INTERVAL_NS)[kind])
            for index in range(44)
        ]
    # As many as if each kind went by itself.
    assert len(found) >= sum(window is not None for window in alone) - 2 >= 30

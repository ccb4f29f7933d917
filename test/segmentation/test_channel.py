"""The colour that flashes is searched, and its own samples are fitted."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.location import locate
from blob_tracker.segmentation import flash_by_name, FrameError, Segmenter
from blob_tracker.segmentation.channel import ChannelChoice
from blob_tracker.types import Frame
import cv2
import numpy as np
import pytest
from support.filtered_flashes import (
    BACKGROUND, digitised, flashes, Floats, gaussian, judge, NOISE, SHAPE, STEP_NS,
)

LED = {'r': 1.0, 'g': 0.08, 'b': 0.02}  # at 625 nm
LOW, HIGH = 1.4, 2.8  # of a true NEES of 2: of 150 flashes its own sigma is 0.16


def response(order: str, colours: dict[str, float]) -> Floats:
    """Return what each sample of a mosaic sees of a light."""
    cell = np.array([colours[each] for each in order]).reshape(2, 2)
    return np.tile(cell, (SHAPE[0] // 2, SHAPE[1] // 2))


def mosaic(
    order: str, colours: dict[str, float]
) -> Callable[[Floats, np.random.Generator], Frame]:
    """Return what makes a frame of a Bayer camera of the light."""
    def develop(light: Floats, random: np.random.Generator) -> Frame:
        pixels = digitised(BACKGROUND + response(order, colours) * light, random)
        return Frame(pixels, 0, 255, layout=order)

    return develop


def planes(colours: dict[str, float]) -> Callable[[Floats, np.random.Generator], Frame]:
    """Return what makes a frame of three colours for each pixel of the light."""
    def develop(light: Floats, random: np.random.Generator) -> Frame:
        image = [digitised(BACKGROUND + colours[each] * light, random) for each in 'bgr']
        return Frame(np.dstack(image), 0, 255, layout='bgr')

    return develop


@pytest.mark.parametrize(('order', 'colours', 'sigma', 'peak', 'channel'), [
    ('rggb', LED, 1.2, 120.0, 'red'),
    ('rggb', LED, 2.0, 120.0, 'red'),
    ('rggb', LED, 1.5, 40.0, 'red'),  # 0.08 of it is below the noise of the green ones
    ('grbg', {'r': 0.1, 'g': 1.0, 'b': 0.1}, 1.0, 120.0, 'luma'),
    ('gbrg', {'r': 0.02, 'g': 0.2, 'b': 1.0}, 1.5, 100.0, 'blue'),
    ('bggr', {'r': 1.0, 'g': 1.0, 'b': 1.0}, 1.5, 100.0, 'luma'),
])
def test_a_light_behind_a_mosaic_is_where_it_is(
    order: str, colours: dict[str, float], sigma: float, peak: float, channel: str
) -> None:
    """All flashes, a true covariance, and no part of the pixel's offset from the cell."""
    segmenter = Segmenter()
    found, nees, bias = judge(
        segmenter, flashes(320, sigma, peak, mosaic(order, colours), seed=5)
    )
    assert segmenter.channel.channel == channel
    assert found >= 0.95
    assert LOW < nees < HIGH
    assert np.abs(bias).max() < 0.03  # px: four sigmas of the mean of the faintest


@pytest.mark.parametrize(('colours', 'channel'), [
    (LED, 'red'),
    ({'r': 0.1, 'g': 0.2, 'b': 1.0}, 'blue'),
    ({'r': 1.0, 'g': 1.0, 'b': 1.0}, 'luma'),
])
def test_the_strongest_of_three_planes(colours: dict[str, float], channel: str) -> None:
    """White light is seen best in the mean of all three."""
    segmenter = Segmenter()
    found, _, _ = judge(segmenter, flashes(60, 1.5, 60.0, planes(colours), seed=6))
    assert segmenter.channel.channel == channel
    assert found == 1.0


def test_the_first_flash_is_not_lost() -> None:
    """The frame before it is compared in the colour in which it flashes."""
    segmenter = Segmenter()
    frames = [frame for frame, _ in flashes(2, 1.5, 120.0, mosaic('rggb', LED), seed=7)]
    windows = [
        segmenter.update(Frame(frame.image, 1 + index * STEP_NS, 255, layout='rggb'))
        for index, frame in enumerate(reversed(frames))
    ]
    assert windows[0] is None and windows[1] is not None
    assert windows[1].sites is not None and windows[1].binning == (1, 1)
    # A red site is the first of each cell, and windows are cut between cells.
    np.testing.assert_array_equal(np.argwhere(windows[1].sites)[0], [0, 0])


def test_a_channel_that_is_named_is_kept() -> None:
    """A blue light does not turn it."""
    segmenter = Segmenter(channel=ChannelChoice('red'))
    judge_frames = flashes(40, 1.5, 100.0, planes({'r': 0.5, 'g': 0.0, 'b': 1.0}), seed=8)
    found, _, _ = judge(segmenter, judge_frames)
    assert segmenter.channel.channel == 'red' and found == 1.0


def test_a_grey_camera_has_no_channel_to_name() -> None:
    """It is said, frame by frame."""
    segmenter = Segmenter(channel=ChannelChoice('red'))
    with pytest.raises(FrameError, match='the camera is grey, it has no channel red'):
        segmenter.update(Frame(np.zeros(SHAPE, np.uint8), 1, 255))


def test_another_channel_has_to_be_better_thrice() -> None:
    """What flashes once in another colour does not turn the search."""
    choice = ChannelChoice()
    random = np.random.default_rng(9)
    light = 120.0 * gaussian(40.0, 30.0, 1.5)
    used = []
    for index, colour in enumerate('rrrbrrrbbbb'):
        for lit in (False, True):
            weights = dict.fromkeys('rgb', 0.0) | {colour: 1.0}
            frame = planes(weights)(light if lit else 0.0 * light, random)
            stamped = Frame(frame.image, 1 + 2 * index + lit, 255, layout='bgr')
            choice.take(stamped, None)
        used.append(choice.channel)
    assert used == ['red'] * 9 + ['blue'] * 2


def test_a_mask_is_of_the_size_of_the_mosaic() -> None:
    """Dark in one pixel of a cell is dark in the cell."""
    mask = np.zeros(SHAPE, np.uint8)
    mask[::2] = 255
    segmenter = Segmenter(mask=mask)
    for index, (frame, _) in enumerate(flashes(8, 1.5, 120.0, mosaic('rggb', LED), seed=10)):
        stamped = Frame(frame.image, 1 + index * STEP_NS, 255, layout='rggb')
        assert segmenter.update(stamped) is None


@pytest.mark.parametrize(('mode', 'options'), [
    ('lock_in', {'frequency': 10.0, 'frames': 12}),
    ('periodic', {'frequency': 10.0}),
    ('coded', {'codes': {'port': '1101000'}}),
    ('steady', {}),
])
def test_other_modes_cut_the_samples_out_too(mode: str, options: dict) -> None:
    """A sum of frames has the same sites as each of them."""
    random = np.random.default_rng(11)
    light = 120.0 * gaussian(40.3, 30.6, 1.5)
    segmenter = Segmenter(
        flash=flash_by_name(mode, **options), channel=ChannelChoice('red')
    )
    places = []
    for index in range(60):
        stamp_ns = 10**18 + index * STEP_NS
        on = {
            'lock_in': (index * 10.0 / 60.0) % 1.0 < 0.5,
            'periodic': (index * 10.0 / 60.0) % 1.0 < 0.5,
            'coded': (1, 1, 0, 1, 0, 0, 0)[index % 7],
            'steady': True,
        }[mode]
        pixels = digitised(
            BACKGROUND + response('rggb', LED) * (light if on else 0.0 * light), random)
        window = segmenter.update(Frame(pixels, stamp_ns, 255, layout='rggb'))
        if window is not None:
            found = locate(window, noise=NOISE)
            places.append([found.x, found.y])
    assert len(places) >= 2
    np.testing.assert_allclose(np.mean(places, axis=0), [40.3, 30.6], atol=0.08)  # px: 4 sigmas


def test_the_unlit_samples_are_laid_over_the_lit_ones() -> None:
    """A camera that moves: each colour's samples are interpolated among their own."""
    random = np.random.default_rng(12)
    noise = cv2.GaussianBlur(random.normal(0.0, 1.0, (200, 260)), (0, 0), 3.0)
    texture = 80.0 + 20.0 * noise / noise.std()
    view = response('rggb', {'r': 1.0, 'g': 0.8, 'b': 0.6})
    segmenter = Segmenter(
        flash=flash_by_name('alternate', registration='translation'),
        channel=ChannelChoice('green'),
    )
    left = []
    for index in range(12):
        shift = np.array([[1, 0, 2.6 * index], [0, 1, 1.4 * index]], dtype=np.float64)
        seen = cv2.warpAffine(texture, shift, (260, 200), flags=cv2.INTER_LANCZOS4)[60:132, 60:156]
        light = 90.0 * gaussian(40.0, 30.0, 1.5) * (index % 2)
        pixels = digitised(view * (seen + light), random)
        window = segmenter.update(Frame(pixels, 1 + index * STEP_NS, 255, layout='rggb'))
        if window is not None:
            edge = window.sites.copy()
            edge[2:-2, 2:-2] = False  # 4 sigma from the light
            rise = window.lit.astype(float) - window.unlit
            left.append(rise[edge].std())
    assert len(left) >= 3
    # DN: shot and read noise of two pixels at 64 DN are 3.9; unmoved texture would leave 12.
    assert np.mean(left) < 5.5

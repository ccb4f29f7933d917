"""Frames that hold no target, in every flash mode: no window, a reason, no exception."""

from __future__ import annotations

from blob_tracker.segmentation import flash_by_name, FLASH_MODES, Segmenter
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame
import numpy as np
import pytest

STEP_NS = 16_666_667
FRAMES = 40  # two blocks of the mode lock_in, four codes
SCENE = flashing_light(width=160, height=120, period=3.0)
DARK = flashing_light(width=160, height=120, period=3.0, background=1.0, texture=0.3)
OPTIONS = {
    'max_pair_interval': 0.1,
    'frequency': 15.0,
    'duty': 0.5,
    'frames': 16,
    'codes': {'a': '1101000'},
    'frames_per_bit': 1,
    'bits_per_second': 0.0,
}


def even(level, kind=np.uint8, shape=(120, 160)):
    """Return the frames of a camera that sees nothing."""
    return lambda index: np.full(shape, level, kind)


def jump(index):
    """Return frames of a still wall with half as much light again in every other one."""
    image = SCENE.frame(2 * index + 1).astype(float)
    return np.rint(np.clip(image * (1.5 if index % 2 else 1.0), 0, 255)).astype(np.uint8)


STREAMS = {
    'all zero': even(0),
    'all saturated': even(255),
    'all saturated, 16 bits': even(65535, np.uint16),
    'one pixel': even(9, shape=(1, 1)),
    'a row': even(9, shape=(1, 300)),
    'three by three': even(9, shape=(3, 3)),
    'lens cap on': lambda index: DARK.frame(2 * index + 1),
    'light never on': lambda index: SCENE.frame(2 * index + 1),
    'exposure jumps': jump,
}


@pytest.mark.parametrize('mode', FLASH_MODES)
@pytest.mark.parametrize('stream', STREAMS)
def test_frames_without_a_target_give_no_window(mode, stream):
    """Say why, for each of them."""
    segmenter = Segmenter(flash=flash_by_name(mode, **OPTIONS))
    for index in range(FRAMES):
        frame = Frame(
            STREAMS[stream](index), 10**18 + index * STEP_NS,
            65535 if '16 bits' in stream else 255,
        )
        assert segmenter.sightings(frame) == []
        assert len(segmenter.reason) > 10


@pytest.mark.parametrize('mode', ['alternate', 'periodic', 'coded', 'lock_in'])
def test_a_light_that_is_always_on_is_no_flash(mode):
    """Still, with noise of its own in each frame."""
    segmenter = Segmenter(flash=flash_by_name(mode, **OPTIONS))
    still = flashing_light(width=160, height=120, reach=0.0)
    for index in range(FRAMES):
        frame = Frame(still.frame(2 * index), 10**18 + index * STEP_NS, 255)
        assert segmenter.sightings(frame) == []
        assert len(segmenter.reason) > 10


def test_white_noise_is_no_flash():
    """As much of it as the pixels hold."""
    random = np.random.default_rng(1)
    segmenter = Segmenter()
    for index in range(FRAMES):
        pixels = random.integers(0, 256, (120, 160), dtype=np.uint8)
        assert segmenter.update(Frame(pixels, 10**18 + index * STEP_NS, 255)) is None
        assert segmenter.reason

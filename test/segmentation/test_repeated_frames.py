"""Frames that come twice with stamps of their own are left out and counted; equal ones are not."""

from __future__ import annotations

from blob_tracker.segmentation import flash_by_name, FLASH_MODES, Segmenter
from blob_tracker.segmentation.repeated_frames import RepeatedFrames
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame
import numpy as np
import pytest

SCENE = flashing_light(width=160, height=120, period=3.0)
STEP_NS = 33_333_333
COUNT = 80


def stamped(index: int, image: np.ndarray) -> Frame:
    """Return the frame at this place of the stream."""
    return Frame(image, 10**18 + index * STEP_NS, 255)


@pytest.mark.parametrize('cadence', [3, 4, 5, 12])
@pytest.mark.parametrize('first', range(4))
def test_a_light_is_found_though_frames_come_twice(cadence: int, first: int) -> None:
    """24 frames made 30 and the like, whichever is the one that comes twice."""
    segmenter = Segmenter()
    lit, found, repeated, index = 0, 0, 0, 0
    for number in range(first, COUNT):
        for copy in range(1 + (number % cadence == cadence - 1)):
            window = segmenter.update(stamped(index, SCENE.frame(number)))
            index += 1
            if index == 2 and copy:
                continue  # of the first frame of all: nothing was seen to change before
            repeated += copy
            if copy:
                assert window is None and 'identical' in segmenter.reason
            elif number >= first + 8:
                lit += SCENE.truth(number).lit
                found += window is not None
            if window is not None:
                truth = SCENE.truth(number)
                assert truth.lit and abs(window.x0 + window.lit.shape[1] // 2 - truth.x) <= 1.5
    assert segmenter.repeated_frames == repeated
    assert found >= 0.95 * lit


def test_a_frame_that_stands_for_a_lost_one_costs_only_itself() -> None:
    """The driver had none, and gave the one before."""
    segmenter = Segmenter()
    found = [
        index for index in range(COUNT)
        if segmenter.update(
            stamped(index, SCENE.frame(index - 1 if index % 11 == 10 else index))
        ) is not None
    ]
    assert set(found) >= {
        index for index in range(8, COUNT, 2) if index % 11 != 10 and (index - 1) % 11 != 10
    }
    assert segmenter.repeated_frames == COUNT // 11


@pytest.mark.parametrize('image', [
    np.zeros((48, 64), np.uint8),
    np.full((48, 64), 255, np.uint8),
    np.full((48, 64), 20, np.uint8),
], ids=['black', 'white', 'grey'])
def test_what_has_no_noise_may_be_equal(image: np.ndarray) -> None:
    """Black, blown out or drawn by a program: no frame of it is one that came twice."""
    repeated = RepeatedFrames()
    lit = image.copy()
    lit[20:23, 20:23] ^= 60
    for index in range(12):
        assert not repeated.push(stamped(index, (lit if index % 3 == 0 else image).copy()))
    assert repeated.count == 0


def test_a_flood_on_a_black_scene_is_no_noise() -> None:
    """All of it changes, and its dark frames are equal."""
    repeated = RepeatedFrames()
    random = np.random.default_rng(1)
    for index in range(12):
        image = np.zeros((48, 64), np.uint8)
        if index % 3 == 0:
            image += random.integers(40, 60, image.shape, np.uint8)
        assert not repeated.push(stamped(index, image))


def test_noise_that_changes_few_pixels_is_noise() -> None:
    """0.3 DN of it on 20 DN: half of the pixels are as before, and all of them never."""
    random = np.random.default_rng(2)
    repeated = RepeatedFrames()
    images = np.rint(random.normal(20.0, 0.3, (20, 96, 128))).astype(np.uint8)
    for index, image in enumerate(images):
        assert not repeated.push(stamped(2 * index, image))
        assert repeated.push(stamped(2 * index + 1, image.copy())) == (index > 0)


@pytest.mark.parametrize('mode', FLASH_MODES)
def test_every_mode_leaves_them_out(mode: str) -> None:
    """And says so."""
    segmenter = Segmenter(flash=flash_by_name(mode, codes={'only': '1101000'}))
    for index in range(6):
        segmenter.sightings(stamped(index, SCENE.frame(index)))
    assert segmenter.sightings(stamped(6, SCENE.frame(5))) == []
    assert segmenter.repeated_frames == 1 and 'identical' in segmenter.reason

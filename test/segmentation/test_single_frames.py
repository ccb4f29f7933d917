"""A frame is compared with its scene's dark look; what is no higher than texture is no point."""

from __future__ import annotations

from blob_tracker.segmentation.dark_look import FEWEST
from blob_tracker.segmentation.history import FrameError
from blob_tracker.segmentation.single_frames import seen_points, SingleFrames
from blob_tracker.types import Frame
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of


def textured(index: int) -> Frame:
    """Return a frame of a still wall with 20 DN of texture."""
    wall = np.random.default_rng(1).normal(100.0, 20.0, (48, 64))
    noise = np.random.default_rng([2, index]).normal(0.0, 1.0, wall.shape)
    return Frame(np.clip(np.rint(wall + noise), 0, 255).astype(np.uint8), index * 10**7, 255)


def test_a_dark_look_is_taken_off_once_there_is_one() -> None:
    """It leaves the noise of the camera of the wall's texture."""
    flash = SingleFrames(0.1)
    contrasts = [flash.contrast(textured(index)) for index in range(FEWEST + 2)]
    assert not contrasts[FEWEST - 1].unlit.any()
    last = contrasts[-1]
    assert (last.lit.astype(float) - last.unlit).std() < 3.0


def test_a_jump_back_of_the_stamps_begins_afresh() -> None:
    """The next frame has nothing to be compared with."""
    flash = SingleFrames(0.1)
    for index in range(100, 108):
        flash.contrast(textured(index))
    with pytest.raises(FrameError, match='jumped back'):
        flash.contrast(textured(0))
    assert not flash.contrast(textured(1)).unlit.any()


def test_points_are_what_stands_out() -> None:
    """Five times as high as noise and texture, and not rejected."""
    contrast = contrast_of(np.full((40, 60), 20, np.uint8))
    high, low, refused = (
        candidate_at(10, 10), candidate_at(30, 10, amplitude=4.0),
        candidate_at(50, 10, rejected='a glow'),
    )
    allowed, table, least = seen_points(contrast, [high, low, refused])
    assert allowed == [high] and table.shape == (1, 7)
    # Five standard deviations of a pixel, of a Gaussian of 2 px: 5 * 2 pi 2^2.
    assert least == pytest.approx(5.0 * 8.0 * np.pi)

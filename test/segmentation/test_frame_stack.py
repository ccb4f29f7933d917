"""Looks are summed; clipped pixels stay clipped, and a target that moves begins them anew."""

from __future__ import annotations

from typing import Any

from blob_tracker.colour import in_channel
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.frame_stack import (
    FrameStack, FULL_SCALE_DN, most_frames, sum_frames,
)
from blob_tracker.segmentation.history import FrameError
from blob_tracker.types import Frame, Window
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of

BOX = Box(3, 2, 10, 9)


def add(
    stack: FrameStack,
    x: float,
    *,
    level: int = 50,
    stamp_ns: int = 0,
    saturation: int = 255,
    kind: Any = np.uint8,
    name: str = '',
    duration: float = 0.0,
) -> Window | None:
    """Give a look at a light at this column."""
    lit = np.full((20, 30), level, kind)
    contrast = contrast_of(lit, lit // kind(2), saturation)
    contrast = contrast._replace(
        frame=Frame(lit, stamp_ns, saturation), duration=duration
    )
    return stack.add(name, contrast, candidate_at(6, 5, x=x, sigma_minor=2.0), BOX)


def test_looks_are_summed_beyond_their_own_type() -> None:
    """Three of 200 DN make 600."""
    images = [np.full((2, 3), 200, np.uint8)] * 3
    assert (sum_frames(images, 255) == 600).all()


def test_a_pixel_clipped_once_is_clipped() -> None:
    """The others of its sum say nothing about it."""
    images = [np.full((2, 3), 200, np.uint8) for _ in range(2)]
    images[1][0, 1] = 255
    assert sum_frames(images, 255).tolist() == [[400, FULL_SCALE_DN, 400], [400] * 3]


def test_one_look_is_left_as_it_is() -> None:
    """No other type, and none of its pixels is that of the frame itself."""
    window = add(FrameStack(1), 6.0)
    assert window is not None and window.unlit is not None
    assert window.lit.dtype == np.uint8 and window.lit.base is not window.unlit.base
    assert (window.lit == 50).all() and (window.unlit == 25).all()


def test_every_kth_look_gives_the_window_of_all() -> None:
    """Lit and unlit pixels are summed, the stamp is the mean, and they do not overlap."""
    stack = FrameStack(3)
    given = [add(stack, 6.0, level=50 + k, stamp_ns=1000 + 7 * k) for k in range(6)]
    assert [window is not None for window in given] == [False, False, True] * 2
    window = given[2]
    assert (window.lit == 50 + 51 + 52).all() and (window.unlit == 25 + 25 + 26).all()
    assert window.lit.dtype == np.uint16 and window.lit.shape == (7, 7)
    assert (window.stamp_ns, window.saturation, window.looks) == (1007, FULL_SCALE_DN, 3)
    assert (window.x0, window.y0) == (3, 2)
    assert given[5].stamp_ns == 1000 + 7 * 4


def test_what_is_waited_for_is_told() -> None:
    """With the count."""
    stack = FrameStack(5)
    assert add(stack, 6.0) is None
    assert stack.reason == 'look 1 of the 5 that are summed'


def test_a_target_that_moves_begins_anew() -> None:
    """Half a sigma and half a pixel are still: 1.5 px of a blob of 2 px."""
    stack = FrameStack(2)
    assert add(stack, 6.0) is None
    assert add(stack, 7.6) is None
    assert add(stack, 9.0) is not None


@pytest.mark.parametrize('seconds, duration, summed', [
    (0.9, 0.0, True), (1.1, 0.0, False), (3600.0, 0.0, False), (-0.1, 0.0, False),
    (2.5, 1.0, True), (3.1, 1.0, False),
])
def test_a_pause_begins_anew(seconds: float, duration: float, summed: bool) -> None:
    """The mean of two times far apart is the time of neither; a long code has long gaps."""
    stack = FrameStack(2)
    first = 10**10
    assert add(stack, 6.0, stamp_ns=first, duration=duration) is None
    later = first + round(1e9 * seconds)
    window = add(stack, 6.0, stamp_ns=later, duration=duration)
    assert (window is not None) is summed
    if not summed:
        window = add(stack, 6.0, stamp_ns=later + 2, duration=duration)
        assert window is not None and window.stamp_ns == later + 1


@pytest.mark.parametrize('change', [{'kind': np.uint16}], ids=['depth'])
def test_other_frames_begin_anew(change: dict[str, Any]) -> None:
    """Pixels of two kinds are not summed."""
    stack = FrameStack(2)
    assert add(stack, 6.0) is None
    assert add(stack, 6.0, **change) is None
    assert add(stack, 6.0, **change) is not None


def test_lights_are_summed_by_their_names() -> None:
    """Two lights in turn do not end each other's looks."""
    stack = FrameStack(2)
    assert add(stack, 6.0, name='port') is None
    assert add(stack, 60.0, name='starboard') is None
    assert add(stack, 6.0, name='port') is not None
    assert add(stack, 60.0, name='starboard') is not None


@pytest.mark.parametrize('saturation, most', [(255, 258), (4095, 16), (65535, 1)])
def test_what_does_not_fit_is_refused(saturation: int, most: int) -> None:
    """The greatest sum of unclipped pixels stays below the level that says clipped."""
    assert most_frames(saturation) == most
    assert most * (saturation - 1) < FULL_SCALE_DN
    kind = np.uint8 if saturation == 255 else np.uint16
    with pytest.raises(FrameError, match=f'16 bits of a window, {most} would; .*saturation'):
        add(FrameStack(most + 1), 6.0, saturation=saturation, kind=kind)
    add(FrameStack(most), 6.0, saturation=saturation, kind=kind)


def test_looks_are_one_or_more() -> None:
    """None is no window."""
    with pytest.raises(ValueError, match='0 looks; there must be 1 or more'):
        FrameStack(0)


def test_a_window_of_a_mosaic_has_the_stamp_of_its_middle_line() -> None:
    """A cell is two lines, the middle of which is half a line after its first."""
    line = 1000.0
    whole = Frame(np.zeros((40, 60), np.uint8), 7_000_000, 255, layout='rggb', line_time_ns=line)
    cells = in_channel(whole, 'red')
    assert (cells.line_time_ns, cells.stamp_ns) == (2 * line, 7_000_500)
    contrast = contrast_of(cells.image, cells.image, 255)._replace(
        frame=cells, lit_frames=(cells.samples,), unlit_frames=(cells.samples,)
    )
    window = FrameStack(1).add('', contrast, candidate_at(6, 5, x=6.0, sigma_minor=2.0), BOX)
    assert window is not None
    assert window.line_time_ns == line
    assert window.stamp_ns == 7_000_000 + line * (2 * BOX.y0 + 2 * BOX.y1 - 1) / 2

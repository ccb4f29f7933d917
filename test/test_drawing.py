"""The parts of which pictures are made."""

from __future__ import annotations

from blob_tracker.drawing import (
    blank, FARTHEST_PX, GAP_PX, in_grey, LINE_PX, nearest_pixel, PAPER, paragraphs, side_by_side,
    stack, TEXT, text_width, wrap,
)
import numpy as np
import pytest


@pytest.mark.parametrize('kind', [np.uint8, np.uint16, np.float32])
def test_levels_become_shades(kind):
    """Black, the middle and white, and what lies beyond; larger by repeating."""
    picture = in_grey(np.array([[10, 20, 70, 120, 200]], kind), 20.0, 120.0, 3.0)
    assert picture.shape == (3, 15, 3)
    assert picture[1, 1::3, 0].tolist() == [0, 0, 127, 255, 255]


def test_what_is_drawn_smaller_is_a_mean():
    """A chequerboard becomes grey; nothing becomes less than a pixel; NaN is black."""
    board = np.indices((40, 60)).sum(axis=0) % 2 * 255
    assert np.abs(in_grey(board.astype(np.uint8), 0.0, 255.0, 0.1).astype(int) - 127).max() <= 1
    assert in_grey(np.zeros((1, 1000), np.uint8), 0.0, 1.0, 0.1).shape == (1, 100, 3)
    assert in_grey(np.full((2, 2), np.nan, np.float32), 0.0, 1.0, 1.0).max() == 0


def test_text_is_wrapped_between_words():
    """No line is wider than it may be, none is lost, and one that is a word stays whole."""
    text = 'what is wrong and what would be right ' * 5
    lines = wrap(text, 200)
    assert ' '.join(lines) == text.strip()
    assert max(text_width(line) for line in lines) <= 200
    assert wrap('w' * 100, 200) == ['w' * 100]
    assert paragraphs([(text, TEXT)], 200).shape == (LINE_PX * len(lines), 200, 3)


def test_parts_are_put_together_with_gaps():
    """Each at its left and top, paper about them."""
    one, other = np.full((3, 5, 3), 200, np.uint8), np.full((4, 2, 3), 100, np.uint8)
    row = side_by_side(one, other)
    assert row.shape == (4, 7 + GAP_PX, 3)
    assert (row[:3, :5] == 200).all()
    assert (row[:, 5 + GAP_PX:] == 100).all()
    assert (row[3, :5] == PAPER).all()
    column = stack([one, other])
    assert column.shape == (7 + 2 * GAP_PX, 5, 3)
    assert (column[3 + GAP_PX:7 + GAP_PX, :2] == 100).all()
    assert (blank(2, 2) == PAPER).all()


@pytest.mark.parametrize(
    ('value', 'pixel'), [(2.6, 3), (np.nan, 0), (np.inf, FARTHEST_PX), (-1e30, -FARTHEST_PX)]
)
def test_places_are_those_that_can_be_drawn_at(value, pixel):
    """Whatever the number."""
    assert nearest_pixel(value) == pixel

"""Fields against those of the other kind: lights are told from what is in one line alone."""

from __future__ import annotations

from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.segmentation.field_pairs import FieldPairs, in_places_of, spans_lines
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.types import Frame, Window
import numpy as np
import pytest


@pytest.mark.parametrize(('y0', 'binning', 'kind', 'moved'), [
    (0, (1, 2), 1, 1), (1, (1, 2), 0, 0), (21, (1, 2), 1, 21), (2, (2, 4), 0, 0),
    (0, (2, 4), 1, 2),
])
def test_a_field_is_put_on_the_lines_of_the_other_kind(
    y0: int, binning: tuple[int, int], kind: int, moved: int
) -> None:
    """By a line of the picture, the pixels as they are."""
    field = Frame(np.zeros((8, 8), np.uint8), 5, 255, y0=y0, binning=binning)
    found = in_places_of(field, kind)
    assert (found.y0, found.field) == (moved, kind)
    assert found.image is field.image


@pytest.mark.parametrize(('sigma', 'spans'), [(0.15, False), (0.5, True), (1.5, True)])
def test_what_is_in_one_line_alone_is_no_light(sigma: float, spans: bool) -> None:
    """Sigma in lines of the field, half of that in px; in whichever part of a line it is."""
    for y in (5.0, 5.3, 4.8):
        lit = 30.0 + 100.0 * pixel_integrated_gaussian((11, 11), 5.2, y, sigma)
        window = Window(lit, np.full((11, 11), 30.0))
        assert spans_lines(window) is spans
    assert spans_lines(Window(lit))


def test_only_modes_that_compare_neighbours_have_a_use_for_it() -> None:
    """The others tell a light by its rhythm."""
    assert FieldPairs(Segmenter).usable
    periodic = flash_by_name('periodic', frequency=5.0)
    assert not FieldPairs(lambda: Segmenter(flash=periodic)).usable

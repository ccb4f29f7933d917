"""Fields against those of the other kind: lights are told from what is in one line alone."""

from __future__ import annotations

from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.segmentation.field_pairs import (
    FieldPairs, in_places_of, scene_noise, spans_lines,
)
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
    """A slope stays where it was on the mean of any two neighbours; the pixels are its own."""
    across, down = binning
    lines = (y0 + down * (np.arange(8) + 0.5)).astype(np.uint8)
    field = Frame(np.repeat(lines[:, None], 6, axis=1), 5, 255, y0=y0, binning=binning)
    found = in_places_of(field, kind)
    assert (found.y0, found.field) == (moved, kind)
    places = found.y0 + down * (np.arange(8) + 0.5)
    pairs = found.image.reshape(8, 3, 2).mean(axis=2)
    np.testing.assert_array_equal(pairs[1:-1], np.repeat(places[1:-1, None], 3, axis=1))
    assert set(found.image.ravel()) <= set(field.image.ravel())


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


@pytest.mark.parametrize('texture', [0.0, 6.0])
def test_what_the_scene_between_the_lines_adds_is_told(texture: float) -> None:
    """Half of what differs from line to line, shared by both of a pair."""
    random = np.random.default_rng(5)
    lines = 100.0 + texture * random.standard_normal((41, 1))
    pixels = np.rint(lines + 2.0 * random.standard_normal((41, 60))).astype(np.uint8)
    other = Frame(pixels, 0, 255, y0=1, binning=(1, 2))
    mixed = in_places_of(other, 0)
    window = Window(mixed.image[5:30, 8:50], mixed.image[5:30, 8:50], x0=8, y0=10, binning=(1, 2))
    found = scene_noise(window, mixed, other)
    step = float(np.mean(np.diff(lines[4:30], axis=0) ** 2))
    # Of 25 lines; the noise of the neighbours is alike in both.
    assert found == pytest.approx(np.sqrt(step / 8.0), rel=0.25, abs=0.4)

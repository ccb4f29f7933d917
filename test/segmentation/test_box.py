"""Boxes: cut at borders, and told when too much is cut off."""

from blob_tracker.segmentation.box import Box, box_about, component_box, intersection, whole
import numpy as np
import pytest


def test_box_is_cut_at_the_borders() -> None:
    """A box near the corner keeps inside the frame."""
    assert box_about(2, 1, 4, 4, (20, 30)) == Box(0, 0, 7, 6)
    assert box_about(29, 19, 4, 4, (20, 30)) == Box(25, 15, 30, 20)


def test_box_selects_its_pixels() -> None:
    """Rows first, as an array is indexed."""
    image = np.arange(20 * 30).reshape(20, 30)
    assert image[Box(3, 5, 4, 7).slices].tolist() == [[5 * 30 + 3], [6 * 30 + 3]]


@pytest.mark.parametrize('box, column, row, cut', [
    (Box(1, 1, 29, 19), 1, 1, False),  # touches no border
    (Box(0, 5, 11, 12), 4, 8, False),  # 4 px to the border, 6 px to the other side
    (Box(0, 5, 10, 12), 3, 8, True),  # 3 and 6: half
    (Box(5, 0, 12, 10), 8, 3, True),
    (Box(20, 5, 30, 12), 26, 8, True),
    (Box(5, 10, 12, 20), 8, 16, True),
])
def test_a_border_near_the_peak_cuts(box: Box, column: int, row: int, cut: bool) -> None:
    """The border may take up to half of a side, on any of the four sides."""
    assert box.cut_through(column, row, (20, 30)) is cut


def test_component_is_connected_across_corners() -> None:
    """Pixels that meet at a corner belong together; others do not."""
    mask = np.zeros((10, 10), dtype=bool)
    mask[2, 2] = mask[3, 3] = mask[8, 8] = True
    place = Box(100, 50, 110, 60)
    assert component_box(mask, 102, 52, place) == Box(102, 52, 104, 54)


def test_whole_has_all_pixels() -> None:
    """Of a (h, w) image."""
    assert whole((20, 30)) == Box(0, 0, 30, 20)
    assert whole((20, 30)).size == 600


@pytest.mark.parametrize('other, shared', [
    (Box(5, 4, 40, 50), Box(5, 4, 20, 10)),
    (Box(12, 3, 15, 6), Box(12, 3, 15, 6)),
    (Box(20, 0, 30, 10), Box(20, 0, 20, 10)),  # they touch
    (Box(50, 60, 70, 80), Box(50, 60, 50, 60)),
])
def test_common_pixels_of_two_boxes(other: Box, shared: Box) -> None:
    """Whichever is named first; none where they are apart."""
    box = Box(0, 0, 20, 10)
    assert intersection(box, other) == intersection(other, box) == shared

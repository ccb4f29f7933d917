"""Boxes: cut at borders, scaled about their centre."""

from blob_tracker.segmentation.box import Box, box_about, component_box, scaled
import numpy as np


def test_box_is_cut_at_the_borders() -> None:
    """A box near the corner keeps inside the frame."""
    assert box_about(2, 1, 4, 4, (20, 30)) == Box(0, 0, 7, 6)
    assert box_about(29, 19, 4, 4, (20, 30)) == Box(25, 15, 30, 20)


def test_box_selects_its_pixels() -> None:
    """Rows first, as an array is indexed."""
    image = np.arange(20 * 30).reshape(20, 30)
    assert image[Box(3, 5, 4, 7).slices].tolist() == [[5 * 30 + 3], [6 * 30 + 3]]


def test_scaled_box_is_odd_and_about_the_same_centre() -> None:
    """An odd box keeps its centre; the width is at least the smallest."""
    assert scaled(Box(10, 10, 15, 15), 2.0, 7, (40, 40)) == Box(7, 7, 18, 18)
    assert scaled(Box(12, 12, 13, 13), 2.0, 7, (40, 40)) == Box(9, 9, 16, 16)


def test_touching_an_edge_is_told() -> None:
    """Any of the four borders counts."""
    shape = (20, 30)
    assert not Box(1, 1, 29, 19).touches_edge(shape)
    for box in (Box(0, 1, 5, 5), Box(1, 0, 5, 5), Box(1, 1, 30, 5), Box(1, 1, 5, 20)):
        assert box.touches_edge(shape)


def test_component_is_connected_across_corners() -> None:
    """Pixels that meet at a corner belong together; others do not."""
    mask = np.zeros((10, 10), dtype=bool)
    mask[2, 2] = mask[3, 3] = mask[8, 8] = True
    place = Box(100, 50, 110, 60)
    assert component_box(mask, 102, 52, place) == Box(102, 52, 104, 54)

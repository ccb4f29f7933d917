"""Looks are summed; clipped pixels stay clipped."""

from blob_tracker.segmentation.looks import FULL, most_looks, sum_looks
import numpy as np
import pytest


def test_looks_are_summed_beyond_their_own_type() -> None:
    """Three of 200 DN make 600."""
    looks = [np.full((2, 3), 200, np.uint8)] * 3
    assert (sum_looks(looks, 255) == 600).all()


def test_a_pixel_clipped_once_is_clipped() -> None:
    """The others of its sum say nothing about it."""
    looks = [np.full((2, 3), 200, np.uint8) for _ in range(2)]
    looks[1][0, 1] = 255
    assert sum_looks(looks, 255).tolist() == [[400, FULL, 400], [400] * 3]


def test_one_look_is_left_as_it_is() -> None:
    """No other type, no copy."""
    look = np.full((2, 3), 255, np.uint8)
    assert sum_looks([look], 255) is look


@pytest.mark.parametrize('saturation, most', [(255, 258), (4095, 16), (65535, 1)])
def test_what_does_not_fit_is_refused(saturation: int, most: int) -> None:
    """The greatest sum of unclipped pixels stays below the level that says clipped."""
    assert most_looks(saturation) == most
    assert most * (saturation - 1) < FULL
    looks = [np.zeros((2, 3), np.uint16)] * (most + 1)
    with pytest.raises(ValueError, match=f'at most {most} do'):
        sum_looks(looks, saturation)

"""The strongest rise is found with its sign, its place and its noise."""

from blob_tracker.segmentation.difference import strongest_rise
import numpy as np
import pytest


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
def test_rise_is_found_and_fall_is_not(kind: type) -> None:
    """A deeper fall elsewhere does not hide the rise."""
    before = np.full((48, 64), 100, dtype=kind)
    after = before.copy()
    after[20, 30] = 140
    after[5, 5] = 0
    rise = strongest_rise(after, before)
    assert (rise.column, rise.row, rise.height) == (30, 20, 40.0)
    assert rise.image.sum() == 40


def test_noise_is_that_of_the_difference() -> None:
    """The standard deviation comes out within its own sampling error."""
    random = np.random.default_rng(5)
    frames = [np.rint(random.normal(100, 3.0, (480, 640))).astype(np.uint8) for _ in range(2)]
    noise = strongest_rise(*frames).noise
    # 4800 pixels give 1 % (one sigma) on the mean absolute deviation; 4 sigma.
    assert noise == pytest.approx(3.0 * np.sqrt(2), rel=0.04)


def test_a_change_of_all_the_light_is_the_background() -> None:
    """The mean difference is told with its sign."""
    before = np.full((64, 64), 100, dtype=np.uint8)
    assert strongest_rise(before - 7, before).background == -7.0

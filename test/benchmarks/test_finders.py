"""Each of the others' ways finds a spot that nobody could miss."""

from __future__ import annotations

from benchmarks.clutter import clutter, with_target
from benchmarks.detection import near
from benchmarks.finders import brightest_pixel, Finder, FINDERS, largest_contour, NOISE
import numpy as np
import pytest


@pytest.mark.parametrize('finder', FINDERS, ids=lambda each: each.name)
@pytest.mark.parametrize('sigma', [1.0, 2.0, 4.0])
def test_a_bright_target_on_a_plain_wall_is_found(finder: Finder, sigma: float) -> None:
    """At peak SNR 50."""
    scene = with_target(clutter()['plain'].scene, 50.0, sigma)
    for index in (2, 40, 78):
        place = finder.find(scene.frame(index), scene.frame(index - 1))
        assert place is not None
        x, y = place
        assert near(x, y, scene.truth(index), sigma)


def test_noise_that_they_are_told_is_that_of_the_difference() -> None:
    """On the wall alone; the standard deviation of 77,000 pixels is good to 0.3 %."""
    scene = clutter()['plain'].scene
    difference = scene.frame(1).astype(float) - scene.frame(2)
    assert difference.std() == pytest.approx(NOISE, rel=0.01)


def test_answers_where_there_is_nothing() -> None:
    """No contour, and the brightest pixel all the same."""
    flat = np.full((24, 32), 40, np.uint8)
    assert largest_contour(flat, flat) is None
    assert brightest_pixel(flat, flat) is not None

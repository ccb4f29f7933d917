"""A flat top below the saturation is named and left out; the top of noise is not flat."""

from __future__ import annotations

from blob_tracker.segmentation.flat_top import FlatTop
from blob_tracker.types import Window
import numpy as np
import pytest


def windows(level: int, top: float, kind: type = np.uint8, scale: int = 1) -> list[Window]:
    """Return ten noisy windows of a light of such a peak, DN, clipped at a level."""
    random = np.random.default_rng(3)
    y, x = np.mgrid[-7:8, -7:8] + 0.3
    light = 30.0 + top * np.exp(-0.5 * (x**2 + y**2) / 2.0**2)
    return [
        Window(
            scale * np.clip(random.normal(light, np.sqrt(1.0 + light / 10.0)), 0, level).astype(
                kind),
            saturation=np.iinfo(kind).max,
        )
        for _ in range(10)
    ]


@pytest.mark.parametrize('level, kind, scale', [
    (235, np.uint8, 1), (235, np.uint16, 1), (235, np.uint16, 64),
])
def test_a_flat_top_is_set_to_full_scale(level: int, kind: type, scale: int) -> None:
    """From the third window on, in 8 bits and in 16, in steps of one or more; the rest stays."""
    top = FlatTop()
    for index, window in enumerate(windows(level, 400.0, kind, scale)):
        marked = top.marked(window, 2.5 * scale)
        clipped = window.lit == level * scale
        assert (marked.lit[clipped] == window.saturation).all() == (index >= 2)
        assert np.array_equal(marked.lit[~clipped], window.lit[~clipped])
        assert (f'set saturation to {level * scale}' in top.warning) == (index >= 2)


@pytest.mark.parametrize('level, peak', [(255, 400.0), (255, 150.0), (235, 195.0)])
def test_what_is_not_flat_is_left_alone(level: int, peak: float) -> None:
    """Clipped where it is said to be, not clipped at all, and a top that noise touches."""
    top = FlatTop()
    for window in windows(level, peak):
        assert top.marked(window, 2.5) is window
    assert top.warning == ''


def test_what_lies_beside_a_clipped_column_is_no_top() -> None:
    """A light that blooms has pixels at one value less than full scale, beside those at it."""
    top = FlatTop()
    for window in windows(255, 400.0):
        lit = window.lit.copy()
        lit[:, 7] = 255
        lit[:, 8] = 254
        bloomed = Window(lit, saturation=255)
        assert top.marked(bloomed, 2.5) is bloomed
    assert top.warning == ''


def test_brighter_pixels_say_that_it_was_no_clipping() -> None:
    """As after another exposure; without a flat top nothing is said."""
    top = FlatTop()
    for window in windows(200, 400.0):
        top.marked(window, 2.5)
    assert top.warning
    for window in windows(255, 200.0):
        assert top.marked(window, 2.5) is window
    assert top.warning == ''

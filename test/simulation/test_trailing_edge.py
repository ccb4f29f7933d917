"""The peaking filter: small, bright blobs fall off fast, wide ones and columns do not."""

from __future__ import annotations

from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.simulation.trailing_edge import MEMORY_PX, peaked, PEAKING
import numpy as np
from numpy.typing import NDArray
import pytest

EDGE = TrailingEdge(PEAKING, MEMORY_PX)
BACKGROUND = 10.0


def row_of(sigma: float, amplitude: float) -> NDArray[np.float64]:
    """Return a row behind the filter, clipped at black, its blob in the middle."""
    half = int(8 * sigma) + 40
    light = BACKGROUND + amplitude * integrated_profile(2 * half + 1, half, sigma)[0]
    return np.maximum(peaked(light, EDGE), 0.0)


def fall_over_rise(row: NDArray[np.float64]) -> float:
    """Return the count of pixels above half the peak on its right over that on its left."""
    light = row - BACKGROUND
    top = int(np.argmax(light))
    bright = light > 0.1 * light[top]
    return float(bright[top:].sum() / bright[:top + 1].sum())


def test_even_areas_are_left_as_they_are() -> None:
    """The filter's gain for what does not change is one, whatever the level."""
    assert peaked(np.full((3, 50), 77.0), EDGE) == pytest.approx(77.0)


def test_a_step_overshoots_and_settles() -> None:
    """By a at first, by a / e after tau pixels."""
    step = np.where(np.arange(60) < 20, 20.0, 100.0)
    seen = peaked(step, EDGE)
    assert seen[:20] == pytest.approx(20.0)
    assert seen[20] - 100.0 == pytest.approx(PEAKING * 80.0)
    assert seen[20 + int(MEMORY_PX)] - 100.0 == pytest.approx(PEAKING * 80.0 / np.e)


def test_only_small_bright_blobs_fall_faster_than_they_rise() -> None:
    """10 px wide (4 sigma) in under 0.8 of the rise; 80 px within a tenth (thesis, page 102)."""
    assert fall_over_rise(row_of(2.5, 150.0)) < 0.8
    assert fall_over_rise(row_of(20.0, 150.0)) == pytest.approx(1.0, abs=0.1)


def test_only_bright_blobs_dive_through_black() -> None:
    """A blob as faint as its background never reaches it."""
    assert row_of(2.5, 150.0).min() == 0.0
    assert row_of(2.5, 15.0).min() > 0.0


def test_columns_are_unaffected() -> None:
    """The profile down the frame, summed over lines that do not clip, keeps its shape."""
    light = 100.0 + 50.0 * pixel_integrated_gaussian((41, 161), 30.0, 20.0, 2.5)
    seen = peaked(light, EDGE)
    # To 1e-6: what is left of the memory 130 px behind the blob is exp(-130 / 4).
    assert (seen - 100.0).sum(axis=1) == pytest.approx((light - 100.0).sum(axis=1), abs=1e-6)

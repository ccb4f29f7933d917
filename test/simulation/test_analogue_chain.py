"""The chain of an analogue camera: each defect does what it is named for, and nothing else."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.simulation.analogue_chain import AnalogueChain, LINES
from blob_tracker.simulation.frame_grabber import CELLS, grabbed, PIXELS
from blob_tracker.simulation.line_jitter import displaced_lines, jittering_offsets, line_offsets
from blob_tracker.simulation.profiles import Gaussian
from blob_tracker.simulation.trailing_edge import peaked
import numpy as np
from numpy.typing import NDArray
import pytest

SHAPE, CORNER = (41, 56), (300, 220)


def drawn(chain: AnalogueChain, seed: int = 0) -> NDArray[np.float64]:
    """Return a window of a blob at (328.3, 239.7)."""
    random = np.random.default_rng(seed)
    return chain.window(SHAPE, CORNER, 328.3, 239.7, Gaussian(), 2.5, 100.0, 10.0, random)


def centre(picture: NDArray[np.float64]) -> float:
    """Return the centroid along x, px of the whole picture."""
    light = picture - 10.0
    return float((light.sum(axis=0) @ np.arange(light.shape[1])) / light.sum()) + CORNER[0]


def test_without_defects_it_is_the_pixel_integrated_blob() -> None:
    """To rounding, and the same for every seed."""
    expected = 10.0 + 100.0 * pixel_integrated_gaussian(SHAPE, 28.3, 19.7, 2.5)
    assert drawn(AnalogueChain()) == pytest.approx(expected, abs=1e-9)
    assert (drawn(AnalogueChain(), 1) == drawn(AnalogueChain(), 2)).all()


def test_lines_are_where_their_offsets_are() -> None:
    """Each line's centroid less the blob's is the offset of that line of the picture."""
    chain = AnalogueChain(drift=1.0, between_fields=0.02)
    expected = line_offsets(LINES)[CORNER[1]:CORNER[1] + SHAPE[0]]
    light = drawn(chain) - 10.0
    lit = light.sum(axis=1) > 1.0
    places = light[lit] @ np.arange(SHAPE[1]) / light[lit].sum(axis=1) + CORNER[0]
    assert places == pytest.approx(328.3 + expected[lit], abs=1e-6)


def test_jitter_scatters_lines_and_frames_by_what_is_asked() -> None:
    """Of 2000 frames, to four standard errors."""
    random = np.random.default_rng(3)
    drawn_offsets = np.array([
        jittering_offsets(np.zeros(20), random, per_line=0.05, per_frame=0.2) for _ in range(2000)
    ])
    of_frames = drawn_offsets.mean(axis=1).std()
    of_lines = (drawn_offsets - drawn_offsets.mean(axis=1)[:, None]).std() * np.sqrt(20 / 19)
    assert of_frames == pytest.approx(np.hypot(0.2, 0.05 / np.sqrt(20)), rel=4 / np.sqrt(4000))
    assert of_lines == pytest.approx(0.05, rel=4 / np.sqrt(2 * 2000 * 19))


def test_a_picture_is_displaced_as_a_blob_would_be() -> None:
    """Splines against the blob drawn anew: 1 % of the peak at sigma 1 px, 3e-4 at 2.5 px."""
    offsets = np.random.default_rng(4).uniform(-0.5, 0.5, 41)
    for sigma, off in ((1.0, 1.0), (2.5, 0.03)):
        still = 100.0 * pixel_integrated_gaussian((41, 56), 28.2, 20.1, sigma)
        moved = 100.0 * pixel_integrated_gaussian((41, 56), 28.2 + offsets, 20.1, sigma)
        assert displaced_lines(still, offsets) == pytest.approx(moved, abs=off)


def test_the_filter_is_that_of_the_whole_line() -> None:
    """A window shows what the filter makes of the line that began long before it."""
    edge = TrailingEdge(1.0, 4.0)
    line = 10.0 + 100.0 * pixel_integrated_gaussian((LINES, 640), 328.3, 239.7, 2.5)
    expected = peaked(line, edge)[CORNER[1]:CORNER[1] + 41, CORNER[0]:CORNER[0] + 56]
    assert drawn(AnalogueChain(trailing_edge=edge)) == pytest.approx(expected, abs=1e-6)


def test_the_grabbers_clock_puts_a_point_where_it_says() -> None:
    """641 cells on 640 pixels: half a pixel in the middle, to 1e-3 px."""
    chain = AnalogueChain(own_clock=True)
    assert centre(drawn(chain)) == pytest.approx(float(chain.seen_at(328.3)), abs=1e-3)
    assert float(chain.seen_at(328.3)) == pytest.approx(328.3 - 0.513, abs=1e-3)
    assert float(replace(chain, own_clock=False).seen_at(328.3)) == 328.3


def test_a_whole_line_keeps_its_light() -> None:
    """What the cells hold the pixels show, in their larger unit."""
    cells = np.random.default_rng(5).uniform(0.0, 200.0, (3, CELLS))
    pixels = grabbed(cells, first=0, count=PIXELS)
    assert pixels.sum(axis=1) * CELLS / PIXELS == pytest.approx(cells.sum(axis=1))


def test_pixels_beyond_the_cells_are_refused() -> None:
    """A window without the cell that its last pixel reaches into."""
    with pytest.raises(ValueError, match='do not cover'):
        grabbed(np.ones((2, 50)), first=300, count=50)

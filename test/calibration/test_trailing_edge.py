"""The filter from pictures of an edge, against what was put in."""

from __future__ import annotations

from blob_tracker.calibration.edge import EdgeError
from blob_tracker.calibration.trailing_edge import measure_trailing_edge
from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.simulation import expose
from blob_tracker.simulation.line_jitter import draw_edge, jittering_offsets, line_offsets
from blob_tracker.simulation.trailing_edge import peaked
from blob_tracker.types import Pixels, SensorNoise
import numpy as np
import pytest

NOISE = SensorNoise(gain=40.0, read_noise=0.7)
SHAPE = (120, 110)
PLACES = line_offsets(SHAPE[0]) + 40.0 + 0.03 * np.arange(SHAPE[0])


def frames(
    edge: TrailingEdge, random: np.random.Generator, *, dark: float = 60.0, bright: float = 110.0,
    count: int = 8,
) -> list[Pixels]:
    """Return pictures of a jittering edge behind the filter."""
    return [
        expose(
            peaked(draw_edge(SHAPE, jittering_offsets(PLACES, random), 1.1, dark, bright), edge),
            NOISE, random,
        )
        for _ in range(count)
    ]


@pytest.mark.parametrize(('peaking', 'memory'), [(1.0, 4.0), (0.3, 12.0), (2.0, 2.0)])
def test_found_again_within_the_stated_errors(peaking: float, memory: float) -> None:
    """
    Mean square of 12 calibrations in their stated deviations.

    Of 12 numbers at least (peaking and memory lean on each other) it lies between 0.37 and 1.94
    in 95 of 100 such tests; half as much again is left for the sandwich's own error.
    """
    squares = []
    for seed in range(12):
        edge = TrailingEdge(peaking, memory)
        found = measure_trailing_edge(frames(edge, np.random.default_rng(seed))).trailing_edge
        assert found.covariance is not None
        stated = np.sqrt(np.diag(found.covariance))
        squares.append((np.array([found.peaking - peaking, found.memory - memory]) / stated) ** 2)
        assert stated[0] < 0.05 * peaking
        assert stated[1] < 0.05 * memory
    assert 0.25 < np.mean(squares) < 2.9


def test_falling_edges_serve_as_well() -> None:
    """From bright to dark, as long as nothing clips: to 2 %, four of their deviations."""
    edge = TrailingEdge(1.0, 4.0)
    pictures = frames(edge, np.random.default_rng(5), dark=150.0, bright=90.0)
    found = measure_trailing_edge(pictures).trailing_edge
    assert found.peaking == pytest.approx(1.0, rel=0.02)
    assert found.memory == pytest.approx(4.0, rel=0.02)


def test_no_filter_is_found_as_none() -> None:
    """A camera without peaking has none within three deviations, or is told to have none."""
    pictures = frames(TrailingEdge(0.0, 4.0), np.random.default_rng(6))
    try:
        found = measure_trailing_edge(pictures).trailing_edge
        assert found.covariance is not None
        assert found.peaking < 3.0 * np.sqrt(found.covariance[0, 0])
    except EdgeError as error:
        assert 'no overshoot' in str(error)


def test_clipped_edges_are_refused() -> None:
    """An edge that dives through black tells nothing of how deep it went."""
    pictures = frames(TrailingEdge(2.0, 4.0), np.random.default_rng(7), dark=110.0, bright=20.0)
    with pytest.raises(EdgeError, match='clipped at black'):
        measure_trailing_edge(pictures)


def test_one_frame_is_refused() -> None:
    """The noise comes from the scatter of the frames."""
    with pytest.raises(EdgeError, match='needs 2'):
        measure_trailing_edge(frames(TrailingEdge(1.0, 4.0), np.random.default_rng(8), count=1))

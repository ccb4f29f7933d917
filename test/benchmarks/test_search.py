"""The timing of whole frames times what it says."""

from __future__ import annotations

from benchmarks import search
import numpy as np
import pytest

SIZE = (200, 160)


@pytest.mark.parametrize('depth', ['uint8', 'uint16'])
def test_pool_is_of_different_frames_of_the_depth(depth: str) -> None:
    """As many as said, of the type, the lit ones with a target that the unlit ones lack."""
    frames = search.pool(SIZE, search.DEPTHS[depth], True)
    assert len(frames) == search.POOL >= 16
    assert {str(frame.dtype) for frame in frames} == {depth}
    assert len({frame.tobytes() for frame in frames}) == len(frames)
    scale = search.DEPTHS[depth] / 255.0
    rises = [int(np.max(a.astype(int) - b)) / scale for b, a in zip(frames, frames[1:])]
    assert min(rises[1::2]) > 30.0 > 12.0 > max(rises[::2])


def test_locked_and_acquired_have_a_target_and_lost_has_none() -> None:
    """Every lit frame of the locked path gives a window; times are positive."""
    rows = {row.path: row for row in search.measure(SIZE, 'uint8', 2)}
    assert list(rows) == [search.LOST, search.ACQUIRED, search.LOCKED, search.COMPONENTS]
    assert rows[search.LOCKED].windows == 1.0
    assert np.isnan(rows[search.LOST].windows) and np.isnan(rows[search.COMPONENTS].windows)
    assert all(row.seconds > 0.0 and row.reference > 0.0 for row in rows.values())


def test_lost_gives_no_window() -> None:
    """Round and round an empty pool."""
    runner = search.Runner(search.pool(SIZE, 255, False))
    runner.go(2 * search.POOL)
    assert not any(runner.windows)


def test_lit_and_unlit_frames_count_alike() -> None:
    """Of 5 and 2 us in turn it is 3.5, and not one of the two or the luck of the draw."""
    assert set(search.of_pairs([5.0, 2.0] * 8)) == {3.5}

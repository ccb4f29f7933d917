"""What is counted is what a sort finds."""

from __future__ import annotations

from blob_tracker.segmentation.order_statistics import fill_ranks
import numpy as np
import pytest


@pytest.mark.parametrize('count', [1, 2, 24, 57])
@pytest.mark.parametrize('decimals', [0, 6])
def test_ranks_are_those_of_a_sort(count: int, decimals: int) -> None:
    """Among values of which many are equal, and among such of which none are."""
    random = np.random.default_rng(count)
    ranks = (count // 4, (count - 1) // 2, count // 2, 3 * count // 4)
    for _ in range(20):
        values = random.normal(20.0, 2.0, count).round(decimals).astype(np.float32)
        out = np.empty(len(ranks))
        fill_ranks(values, ranks, out)
        assert out.tolist() == np.sort(values)[list(ranks)].tolist()

"""Candidates are those of their table, whether all are made or one by itself."""

from __future__ import annotations

from blob_tracker.segmentation.candidates import Candidates, table_of
from blob_tracker.segmentation.rejection import FIELDS, GLOW, LONE_PIXEL
import pytest
from support.contrasts import candidate_at


def seen() -> Candidates:
    """Return a light, its glow, and a hot pixel that is clipped."""
    light = candidate_at(30, 20, snr=50.0)
    table = table_of([light, candidate_at(31, 20, sigma_major=9.0), candidate_at(70, 60)])
    table[1:, FIELDS] = GLOW + 0, LONE_PIXEL
    return Candidates(table, {2: 5})


def test_one_is_the_same_by_itself_and_among_all() -> None:
    """From either end."""
    alone, together = seen(), seen()
    every = tuple(together)
    for index in range(-3, 3):
        assert alone[index] == every[index] == together[index]
    assert every[1:] == together[1:]
    assert every[0] == candidate_at(30, 20, snr=50.0)
    for index in (-4, 3):
        with pytest.raises(IndexError):
            alone[index]


def test_why_one_is_rejected_is_said_in_words() -> None:
    """Of which light it is the glow; and that it is clipped."""
    light, glow, hot = seen()
    assert light.rejected == ''
    assert glow.rejected.startswith('a glow 9 px wide (sigma) about the light at (30, 20)')
    assert hot.rejected.startswith('5 pixels are clipped: lower the exposure; as it is, a lone')


def test_the_table_of_candidates_tells_which_are_rejected() -> None:
    """Of those that have one it is that one."""
    candidates = seen()
    assert table_of(candidates) is candidates.table
    rejected = table_of(list(candidates))[:, FIELDS]
    assert rejected.tolist() == [0.0, 1.0, 1.0]
    assert table_of([]).shape == (0, FIELDS + 1)

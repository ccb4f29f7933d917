"""The 1-D figures: what the text says of them, held against ours."""

from __future__ import annotations

from blob_tracker.studies.chapters_2_to_4 import (
    centroid_sweeps, log_linear_sweeps, three_gaussian_sweeps,
)
from blob_tracker.studies.chapters_2_to_4.row_sweeps import locate_rows
from blob_tracker.studies.printed import load
import numpy as np
import pytest
from support.quick_study import by_name, quick_findings

STUDY = by_name(
    centroid_sweeps.STUDIES + log_linear_sweeps.STUDIES + three_gaussian_sweeps.STUDIES
)
# What the text says that ours does not show: single precision's patterns, and a simplex that
# ended farther from the minimum.
DIFFERENT = {
    'figure_4_2': ['order'], 'figure_4_4': ['limit'], 'figure_4_7': ['ends'],
    'figure_4_9': ['limit'], 'figure_4_10': ['wide'],
}


@pytest.mark.parametrize('name', sorted(STUDY))
def test_what_the_text_says(name: str) -> None:
    """All statements hold but those that are known not to."""
    said = {one.says: key for key, one in load(name).statements.items()}
    checks = quick_findings(STUDY[name]).checks
    by_key = {said[check.what.partition(': ')[2]]: check.met for check in checks}
    assert sorted(by_key) == sorted(said.values())  # every statement is looked at
    assert [key for key, met in by_key.items() if not met] == DIFFERENT.get(name, [])


def test_logarithm_meets_the_bound_where_no_pixel_is_faint() -> None:
    """Figure 4.5: at s = 7 in 9 px all pixels are bright, and the fit reaches the bound."""
    table = quick_findings(STUDY['figure_4_5']).tables[0]
    rows = np.array([row for row in table.rows if row[0] == 7.0], dtype=float)
    ratio = np.sqrt(np.mean(rows[:, 3] ** 2) / np.mean(rows[:, 4] ** 2))
    # Ten repeats at fifty places: 3 % is the standard deviation of the ratio.
    assert ratio == pytest.approx(1.0, abs=0.12)


def test_a_row_that_cannot_be_located_is_said_so() -> None:
    """NaN, not a number from somewhere."""
    rows = np.array([[0.0, 2.0, 9.0, 2.0, 0.0], [0.0, 0.0, 9.0, 0.0, 0.0]])
    found = locate_rows(rows, 'gaussian_linear')
    assert found[0] == pytest.approx(2.0) and np.isnan(found[1])

"""Table 2.1 and Figure 2.3."""

from __future__ import annotations

from blob_tracker.studies.chapters_2_to_4.imaging import STUDIES
import pytest
from support.quick_study import by_name, quick_findings

STUDY = by_name(STUDIES)


@pytest.mark.parametrize('name', ['table_2_1', 'figure_2_3'])
def test_all_as_printed(name: str) -> None:
    """Every check is met."""
    assert all(check.met for check in quick_findings(STUDY[name]).checks)

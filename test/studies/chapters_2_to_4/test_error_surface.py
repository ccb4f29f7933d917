"""Figure 4.6, and what it is of."""

from __future__ import annotations

from blob_tracker.studies.chapters_2_to_4.error_surface import STUDIES
from support.quick_study import quick_findings


def test_caption_of_figure_4_6_contradicts_the_text() -> None:
    """0.000016 px is Table 4.3's for s = 3 px, as the text has it, not for s = 1 px."""
    findings = quick_findings(STUDIES[0])
    assert 'so the text is right' in findings.shows
    assert [check.met for check in findings.checks] == [True]

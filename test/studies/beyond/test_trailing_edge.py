"""The study of the trailing edge: every check of its quick run."""

from __future__ import annotations

from blob_tracker.studies.beyond.trailing_edge import STUDY
from support.quick_study import quick_findings


def test_the_filter_is_known_and_taken_off() -> None:
    """To 2 %, and the blob is where it is."""
    findings = quick_findings(STUDY)
    assert [check for check in findings.checks if not check.met] == []
    assert len(findings.checks) == 4

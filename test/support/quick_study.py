"""A study done in this process, its results as JSON keeps them."""

from __future__ import annotations

import json

from blob_tracker.studies.study import Findings, Study


def quick_findings(study: Study) -> Findings:
    """Return what comes of the quick run."""
    return study.conclude([
        (case, json.loads(json.dumps(study.measure(case), allow_nan=False)))
        for case in study.cases(True)
    ])


def by_name(studies: tuple[Study, ...]) -> dict[str, Study]:
    """Return the studies of a module by their names."""
    return {study.name: study for study in studies}

"""Studies done in this process, each case once in a run of the tests."""

from __future__ import annotations

from collections.abc import Sequence
import fcntl
import json
import os
from pathlib import Path

from blob_tracker.studies.runner.kept import Kept
from blob_tracker.studies.study import Case, Findings, Measured, Study


def folder() -> Path:
    """Return where the processes of this run keep what they measured, as the runner has it."""
    return Path(os.environ['QUICK_STUDIES'])  # see conftest.py


def measured(study: Study, *cases: Case) -> list[Measured]:
    """Return what a study measures, as JSON keeps it, or what another test has it measure."""
    kept = Kept(folder())
    found: list[Measured] = []
    with (folder() / f'{study.name}.lock').open('w') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # who comes second finds it done
        for case in cases:
            if kept.get(study.name, case) is None:
                whole = json.dumps(study.measure(case), allow_nan=False)
                kept.put(study.name, case, json.loads(whole))
            again = kept.get(study.name, case)
            assert again is not None
            found.append(again)
    return found


def quick_findings(study: Study, cases: Sequence[Case] | None = None) -> Findings:
    """Return what comes of the quick run, or of these cases of it."""
    chosen = study.cases(True) if cases is None else cases
    return study.conclude(list(zip(chosen, measured(study, *chosen), strict=True)))


def by_name(studies: tuple[Study, ...]) -> dict[str, Study]:
    """Return the studies of a module by their names."""
    return {study.name: study for study in studies}

"""Run studies: jobs to the workers, what they find to the disk, conclusions as they are due."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    BrokenExecutor, CancelledError, Executor, FIRST_COMPLETED, Future, wait,
)
from dataclasses import dataclass, field, replace
from io import BytesIO
import json
import time
import traceback
from typing import Any

from blob_tracker.studies.registry import STUDIES
from blob_tracker.studies.runner.kept import Kept, version
from blob_tracker.studies.study import Case, Check, Measured, Study, Table
from matplotlib.figure import Figure

CONCLUSION = -1  # in place of the number of a case
DOTS_PER_INCH = 110


@dataclass(frozen=True)
class Outcome:
    """
    A study that is done.

    Parameters
    ----------
    name : str
        Of the study.
    shows, agreement : str
        See `Findings`; of a study that failed, what went wrong.
    tables : sequence of Table
        Its data.
    pictures : dict of bytes
        PNG files by the names of the figures.
    checks : sequence of Check
        What was to be shown.
    failed : bool
        Whether a job or the conclusion raised an error.
    seconds : float
        That its jobs took in this run, all together, s.

    """

    name: str
    shows: str
    agreement: str = ''
    tables: Sequence[Table] = ()
    pictures: dict[str, bytes] = field(default_factory=dict)
    checks: Sequence[Check] = ()
    failed: bool = False
    seconds: float = 0.0


def run(
    studies: Sequence[Study],
    *,
    quick: bool,
    kept: Kept,
    executor: Executor,
    ahead: int,
    tick: Callable[[str], None],
) -> Iterator[Outcome]:
    """
    Run studies; yield each as soon as it is done.

    Parameters
    ----------
    studies : sequence of Study
        Which.
    quick : bool
        Whether the short form of each will do.
    kept : Kept
        What was measured already; what is measured now is added.
    executor : Executor
        Runs the jobs.
    ahead : int
        Jobs that it is given at a time, so that a study is concluded as soon as it can be.
    tick : callable
        Told the name of the study after each job, also of one that was kept.

    Yields
    ------
    Outcome
        In the order in which they end.

    Raises
    ------
    BrokenExecutor
        If a worker or the cluster is gone, or has another version of the package.

    """
    cases = {study.name: list(study.cases(quick)) for study in studies}
    found: dict[str, dict[int, Measured]] = {name: {} for name in cases}
    seconds = dict.fromkeys(cases, 0.0)
    failed: set[str] = set()
    waiting: deque[tuple[str, int]] = deque()  # study and number of the case
    jobs: dict[Future[Any], tuple[str, int]] = {}

    def begin(name: str, place: int) -> None:
        if place == CONCLUSION:
            whole = [(case, found[name][place]) for place, case in enumerate(cases[name])]
            future: Future[Any] = executor.submit(_conclude, name, whole)
        else:
            future = executor.submit(_measure, name, cases[name][place])
        jobs[future] = name, place

    for name in cases:
        for place, case in enumerate(cases[name]):
            measured = kept.get(name, case)
            if measured is None:
                waiting.append((name, place))
            else:
                found[name][place] = measured
                tick(name)
        if len(found[name]) == len(cases[name]):
            waiting.append((name, CONCLUSION))
    while waiting or jobs:
        while waiting and len(jobs) < ahead:
            begin(*waiting.popleft())
        for future in wait(jobs, return_when=FIRST_COMPLETED).done:
            name, place = jobs.pop(future)
            if place == CONCLUSION:
                yield replace(future.result(), seconds=seconds[name])
                continue
            tick(name)
            case = cases[name][place]
            try:
                measured, took, theirs = future.result()
            except BrokenExecutor:
                raise  # nothing that follows would be done
            except CancelledError:
                raise BrokenExecutor('the scheduler of the cluster is gone') from None
            except Exception as error:  # of this study; the others go on
                if name not in failed:
                    failed.add(name)
                    yield Outcome(name, f'{case}: {type(error).__name__}: {error}', failed=True)
                continue
            if theirs != version():
                raise BrokenExecutor('the workers have another version of blob_tracker')
            kept.put(name, case, measured)
            found[name][place] = measured
            seconds[name] += took
            if len(found[name]) == len(cases[name]):
                waiting.appendleft((name, CONCLUSION))


def _measure(name: str, case: Case) -> tuple[Measured, float, str]:
    """Do one job; return what it found, as JSON keeps it, the seconds, and the version."""
    began = time.perf_counter()
    measured: Measured = json.loads(json.dumps(STUDIES[name].measure(case)))
    return measured, time.perf_counter() - began, version()


def _conclude(name: str, whole: Sequence[tuple[Case, Measured]]) -> Outcome:
    """Draw the conclusions of a study, and its figures."""
    try:
        findings = STUDIES[name].conclude(whole)
        pictures = {key: _png(figure) for key, figure in findings.figures.items()}
    except Exception:
        return Outcome(name, traceback.format_exc(), failed=True)
    return Outcome(
        name, findings.shows, findings.agreement, findings.tables, pictures, findings.checks
    )


def _png(figure: Figure) -> bytes:
    """Return a figure as the bytes of a PNG file."""
    file = BytesIO()
    figure.savefig(file, format='png', dpi=DOTS_PER_INCH, bbox_inches='tight')
    return file.getvalue()

"""The command `study`: the thesis' tables and figures done again, and what goes beyond them."""

from __future__ import annotations

import argparse
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack
from datetime import datetime, timezone
from difflib import get_close_matches
import os
from pathlib import Path
import re
import sys
import time

from blob_tracker.studies.registry import STUDIES
from blob_tracker.studies.runner.kept import Kept
from blob_tracker.studies.runner.report import write_report, write_study
from blob_tracker.studies.runner.run import Outcome, run
from blob_tracker.studies.runner.workers import ClusterError, workers
from blob_tracker.studies.study import Study
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

EVERY = 'all'
AHEAD = 2  # jobs that wait for each worker
KEPT = 'What was measured is kept: the same command goes on from there.'
INTERRUPTED = 130  # exit code of what Ctrl-C ended


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker study`."""
    parser.description = (
        "Does the thesis' tables and figures again and compares, and goes beyond them: CSV files, "
        'pictures and one report to open in a browser. Without a NAME: the list of them.'
    )
    parser.add_argument(
        'names', nargs='*', metavar='NAME', help=f'which studies; {EVERY}: every one'
    )
    parser.add_argument(
        '--out', type=Path, default=Path('out/studies'), metavar='DIR',
        help='folder for the results (default out/studies)',
    )
    parser.add_argument(
        '--quick', action='store_true', help='fewer repeats and coarser sweeps: minutes for all'
    )
    parser.add_argument(
        '--jobs', type=int, default=os.cpu_count() or 1, metavar='N',
        help='processes on this machine (default: one for each core)',
    )
    parser.add_argument(
        '--dask', metavar='ADDRESS',
        help='spread the jobs over the Dask cluster of this scheduler, as tcp://192.168.1.5:8786',
    )


def main(arguments: argparse.Namespace) -> int:
    """
    Run studies.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        0 done; 1 a study failed; 2 called wrongly; 130 interrupted.

    """
    console = Console()
    if not arguments.names:
        _list(console)
        return 0
    try:
        studies = _chosen(arguments.names)
        if arguments.jobs < 1:
            raise ValueError(f'--jobs is {arguments.jobs}; it must be 1 or more')
        kept = Kept(arguments.out / 'kept')
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f'--out {arguments.out}: {error.strerror}; name a folder that can be written to',
              file=sys.stderr)
        return 2
    began = time.monotonic()
    outcomes: dict[str, Outcome] = {}
    try:
        with ExitStack() as stack:
            executor, at_once = stack.enter_context(workers(arguments.jobs, arguments.dask))
            progress = stack.enter_context(_progress(console))
            count = sum(len(study.cases(arguments.quick)) for study in studies)
            task = progress.add_task('', total=count)
            try:
                for outcome in run(
                    studies, quick=arguments.quick, kept=kept, executor=executor,
                    ahead=AHEAD * at_once,
                    tick=lambda name: progress.update(task, advance=1, description=name),
                ):
                    outcomes[outcome.name] = outcome
                    write_study(arguments.out, outcome)
                    _print(progress.console, outcome)
            except KeyboardInterrupt:
                progress.stop()
                print(f'\nInterrupted; a moment. {KEPT}', file=sys.stderr)
                return INTERRUPTED
    except ClusterError as error:
        print(error, file=sys.stderr)
        return 2
    except BrokenExecutor as error:
        print(f'{error}\nIf a process was killed for lack of memory: fewer --jobs. {KEPT}',
              file=sys.stderr)
        return 1
    except OSError as error:
        print(f'--out {arguments.out}: {error.strerror}. {KEPT}', file=sys.stderr)
        return 1
    done = [outcomes[study.name] for study in studies]
    path = write_report(
        arguments.out, done, quick=arguments.quick, when=datetime.now(timezone.utc)
    )
    unmet = sum(not check.met for outcome in done for check in outcome.checks)
    checks = sum(len(outcome.checks) for outcome in done)
    failed = sum(outcome.failed for outcome in done)
    console.print(
        f'\n{len(done)} studies in {time.monotonic() - began:.0f} s: {checks - unmet} of {checks} '
        f'checks met' + (f', {failed} failed' if failed else '') + f'\nreport: {path}',
        highlight=False,
    )
    return 1 if failed else 0


def _chosen(names: list[str]) -> list[Study]:
    """Return the studies of these names, in the order of the list; raise ValueError for others."""
    chosen = {_containing(name) for name in names}
    for name in chosen:
        if name != EVERY and name not in STUDIES:
            near = get_close_matches(name.lower(), [EVERY, *STUDIES], 3, 0.4)
            hint = f'did you mean {", ".join(near)}?' if near else 'see the list'
            raise ValueError(
                f"there is no study '{name}'; {hint} (python3 -m blob_tracker study lists them)"
            )
    return [study for study in STUDIES.values() if EVERY in chosen or study.name in chosen]


def _containing(name: str) -> str:
    """Return the study that holds a figure or table which has none of its own, or the name."""
    found = re.fullmatch(r'(figure|table)_(\d+)_(\d+)', name)
    if found and name not in STUDIES:
        pattern = rf'{found[1]} {found[2]}\.{found[3]}\b'
        for study in STUDIES.values():
            if re.search(pattern, study.source, re.IGNORECASE):
                return study.name
    return name


def _list(console: Console) -> None:
    """Print what there is."""
    table = Table(title='Studies', title_justify='left')
    for heading in ('name', 'what', 'in the thesis'):
        table.add_column(heading)
    for study in STUDIES.values():
        table.add_row(study.name, study.title, study.source)
    console.print(table)
    console.print(f'python3 -m blob_tracker study NAME ... | {EVERY} [--quick]', highlight=False)


def _progress(console: Console) -> Progress:
    return Progress(
        BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn('{task.description}'),
        console=console, transient=True,
    )


def _print(console: Console, outcome: Outcome) -> None:
    """Print what came of a study."""
    if outcome.failed:
        console.print(f'[bold red]{outcome.name} failed[/]\n{escape(outcome.shows)}')
        return
    console.print(f'[bold]{outcome.name}[/]  {escape(outcome.agreement)}', highlight=False)
    console.print(f'  {escape(outcome.shows)}', highlight=False)
    for check in outcome.checks:
        mark = '[green]met[/]' if check.met else '[bold red]NOT MET[/]'
        console.print(
            f'  {mark}: {escape(check.what)}: {escape(check.found)} (asked: '
            f'{escape(check.asked)})', highlight=False,
        )

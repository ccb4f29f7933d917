"""How the findings are told: to a person, or to a program."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict
import json
import sys

from blob_tracker.commands.doctor.finding import Finding, Level

STYLES = {Level.OK: 'green', Level.WARN: 'yellow', Level.ERROR: 'bold red'}
LEVEL_WIDTH, SUBJECT_WIDTH = 5, 14  # characters
ENDLESS = 10_000  # characters: into a file or a pipe each finding goes as one line


def as_json(findings: Iterable[Finding]) -> str:
    """Return the findings as a JSON list of objects."""
    return json.dumps(
        [{**asdict(finding), 'level': finding.level.value} for finding in findings], indent=2
    )


def summary(findings: Sequence[Finding]) -> str:
    """Return the last line."""
    levels = [finding.level for finding in findings]
    errors, warnings = levels.count(Level.ERROR), levels.count(Level.WARN)
    if not errors and not warnings:
        return 'All is well.'
    return f'{errors} error{"s" * (errors != 1)}, {warnings} warning{"s" * (warnings != 1)}'


class Report:
    """
    Print findings as they come.

    Where rich is missing, one of the things that the doctor is there to tell, they are printed
    plainly.
    """

    def __init__(self) -> None:
        try:
            from rich.console import Console
        except ImportError:
            self._console = None
        else:
            self._console = Console(width=None if sys.stdout.isatty() else ENDLESS)

    def looking_at(self, subject: str) -> AbstractContextManager[object]:
        """Show what is being looked at, while it lasts."""
        return nullcontext() if self._console is None else self._console.status(subject)

    def tell(self, finding: Finding) -> None:
        """Print one finding; a command stands alone, unbroken, to be copied."""
        words = f'{finding.message}; {finding.advice}' if finding.advice else finding.message
        words += ':' * bool(finding.command)
        indent = ' ' * (LEVEL_WIDTH + 2)
        if self._console is None:
            level, subject = finding.level.value, finding.subject
            print(f'{level:{LEVEL_WIDTH}}  {subject:{SUBJECT_WIDTH}}  {words}')
            if finding.command:
                print(f'{indent}{finding.command}')
            return
        from rich.table import Table
        from rich.text import Text

        line = Table.grid(padding=(0, 2, 0, 0))
        line.add_column(width=LEVEL_WIDTH)
        line.add_column(width=SUBJECT_WIDTH)
        line.add_column(overflow='fold')
        verdict = Text(finding.level.value, style=STYLES[finding.level])
        line.add_row(verdict, finding.subject, Text(words))
        self._console.print(line)
        if finding.command:
            self._console.print(
                Text(f'{indent}{finding.command}', style='bold'), soft_wrap=True
            )

    def conclude(self, findings: Sequence[Finding]) -> None:
        """Print the last line."""
        print(f'\n{summary(findings)}')

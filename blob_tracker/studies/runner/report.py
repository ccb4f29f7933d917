"""The results on disk: CSV and PNG files, one HTML page with everything in it, and a summary."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
import csv
from datetime import datetime
from html import escape
from importlib.resources import files
import os
from pathlib import Path
import platform

from blob_tracker.studies.registry import STUDIES
from blob_tracker.studies.runner.run import Outcome
from blob_tracker.studies.study import Cell, Table

LONG = 12  # rows; a longer table is folded
DIGITS = 6  # of a number that is read; the CSV has them all
TITLE = 'Blob location: the thesis done again'


def write_study(folder: Path, outcome: Outcome) -> None:
    """Write the tables of a study as CSV files, and its figures as PNG files, into its folder."""
    own = folder / outcome.name
    own.mkdir(parents=True, exist_ok=True)
    for table in outcome.tables:
        with open(own / f'{table.name}.csv', 'w', newline='', encoding='utf-8') as file:
            writer = csv.writer(file)
            writer.writerow(table.columns)
            writer.writerows(table.rows)
    for name, picture in outcome.pictures.items():
        (own / f'{name}.png').write_bytes(picture)


def write_report(
    folder: Path, outcomes: Sequence[Outcome], *, quick: bool, when: datetime
) -> Path:
    """
    Write a page that needs no other file, and of all studies the table of docs/thesis.md.

    report.html and summary.md are of all studies, part.html of some; a quick run adds _quick, so
    that it leaves the page of the full one.

    Parameters
    ----------
    folder : Path
        Where to.
    outcomes : sequence of Outcome
        In their order.
    quick : bool
        Whether they are of the short run.
    when : datetime
        Of the run.

    Returns
    -------
    Path
        Of the report.

    """
    run = (
        f'{"Quick" if quick else "Full"} run of {when:%Y-%m-%d %H:%M} UTC, '
        f'{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}.'
    )
    style = (files('blob_tracker.studies.runner') / 'report.css').read_text(encoding='utf-8')
    page = [
        '<!DOCTYPE html>',
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<title>{TITLE}</title><style>{style}</style></head><body>',
        f'<header><h1>{TITLE}</h1><p>{run}</p></header>',
        '<main>',
        _overview(outcomes),
        *(_section(outcome) for outcome in outcomes),
        '</main></body></html>',
    ]
    whole = len(outcomes) == len(STUDIES)
    ending = '_quick' if quick else ''
    path = folder / f'{"report" if whole else "part"}{ending}.html'
    path.write_text('\n'.join(page), encoding='utf-8')
    if whole:
        (folder / f'summary{ending}.md').write_text(summary(outcomes), encoding='utf-8')
    return path


def summary(outcomes: Sequence[Outcome]) -> str:
    """Return the table that says, line by line, what of the thesis is reproduced, as Markdown."""
    lines = ['| Thesis | How closely | `python3 -m blob_tracker study` ... |', '|---|---|---|']
    for outcome in outcomes:
        closely = 'failed' if outcome.failed else outcome.agreement
        lines.append(f'| {STUDIES[outcome.name].source} | {closely} | `{outcome.name}` |')
    return '\n'.join(lines) + '\n'


def _overview(outcomes: Sequence[Outcome]) -> str:
    """Return the table of all studies."""
    rows = []
    for outcome in outcomes:
        study = STUDIES[outcome.name]
        met = sum(check.met for check in outcome.checks)
        state = 'failed' if outcome.failed else f'{met} of {len(outcome.checks)}'
        good = not outcome.failed and met == len(outcome.checks)
        rows.append(
            f'<tr><td><a href="#{study.name}">{study.name}</a></td><td>{escape(study.title)}</td>'
            f'<td>{escape(study.source)}</td><td>{escape(outcome.agreement)}</td>'
            f'<td class="{"met" if good else "unmet"}">{state}</td></tr>'
        )
    return (
        '<section><h2>Overview</h2><div class="wide"><table><thead><tr><th>study</th>'
        '<th>what</th><th>in the thesis</th><th>how closely</th><th>checks met</th></tr></thead>'
        f'<tbody>{"".join(rows)}</tbody></table></div></section>'
    )


def _section(outcome: Outcome) -> str:
    """Return the part of the page that a study has."""
    study = STUDIES[outcome.name]
    parts = [f'<section id="{study.name}"><h2>{escape(study.title)}</h2>']
    parts.append(
        f'<p class="source"><code>{study.name}</code> &middot; {escape(study.source)}</p>'
    )
    if outcome.failed:
        return ''.join([*parts, f'<pre class="unmet">{escape(outcome.shows)}</pre></section>'])
    parts.append(f'<p class="shows">{escape(outcome.shows)}</p>')
    if outcome.checks:
        parts.append('<ul class="checks">')
        for check in outcome.checks:
            word = 'met' if check.met else 'unmet'
            parts.append(
                f'<li class="{word}">{escape(check.what)}: <b>{escape(check.found)}</b> '
                f'(asked: {escape(check.asked)})</li>'
            )
        parts.append('</ul>')
    for name, picture in outcome.pictures.items():
        parts.append(
            f'<img alt="{escape(name)}" src="data:image/png;base64,'
            f'{b64encode(picture).decode()}">'
        )
    parts += [_table(table) for table in outcome.tables]
    return ''.join([*parts, '</section>'])


def _table(table: Table) -> str:
    """Return a table, folded where it is long."""
    head = ''.join(f'<th>{escape(column)}</th>' for column in table.columns)
    rows = ''.join(
        '<tr>' + ''.join(f'<td>{escape(_text(cell))}</td>' for cell in row) + '</tr>'
        for row in table.rows
    )
    opened = ' open' if len(table.rows) <= LONG else ''
    return (
        f'<details{opened}><summary>{escape(table.title)} ({len(table.rows)} rows, '
        f'{escape(table.name)}.csv)</summary><div class="wide"><table><thead><tr>{head}</tr>'
        f'</thead><tbody>{rows}</tbody></table></div></details>'
    )


def _text(cell: Cell) -> str:
    """Return a cell as it is read."""
    if cell is None:
        return ''
    if isinstance(cell, float):
        return f'{cell:.{DIGITS}g}'
    return str(cell)

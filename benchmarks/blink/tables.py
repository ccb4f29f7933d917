"""The table of blinking lights."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

from benchmarks.blink import label, Row
from rich.table import Table


def table(rows: Sequence[Row]) -> Table:
    """Return a line for each case."""
    out = Table(
        'lights', 'found, %', 'visible, %', 'AMI, %', 'wrong > 5 px, %', 'wrong name, %',
        'rms, px', 'NEES/2', 'frames to the name', 'ms a frame',
        title='Lights that blink and move: lit frames with the right name within 2 px',
        caption='NEES/2: of the place at its stamp; ms: of the tracker, beside the search; AMI: '
        'Lakemann et al. 2025 (arXiv 2502.01172), tuned to the speed, on frames drawn alike',
    )
    for row in rows:
        out.add_row(
            label(row.case), f'{row.found:.2f}', f'{row.visible:.2f}',
            '' if isnan(row.peer) else f'{row.peer:.0f}', f'{row.wrong:.2f}', f'{row.named:.2f}',
            f'{row.rms:.3f}', f'{row.nees:.2f}', f'{row.first:.0f}', f'{row.ms:.2f}',
        )
    return out

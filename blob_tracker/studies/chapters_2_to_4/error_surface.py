"""Figure 4.6: the log-linear fit's error over all displacements in x and y."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.studies.axes import new_axes
from blob_tracker.studies.chapters_2_to_4.row_sweeps import says
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import FINE, locate_stack, ONE, windows
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Findings, Measured, Study, Table
import numpy as np

_WINDOW = 5  # px


def _cases(quick: bool) -> list[Case]:
    """Return the s of the text and that of the caption."""
    return [{'s': 3.0}, {'s': 1.0}]


def measure(case: Case) -> Measured:
    """Return the error along x at each pair of displacements, px."""
    stack, x = windows(ONE, _WINDOW, case['s'], FINE)
    return {'error': (locate_stack(stack, 'gaussian_linear') - x).tolist()}


def _conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Draw both surfaces and look at their largest errors."""
    printed = load('figure_4_6')
    figure, panels = new_axes(2)
    cells: list[list[Cell]] = []
    largest = {}
    for axes, (case, measured) in zip(panels, results):
        error = np.array(measured['error']).reshape(FINE.size, FINE.size)
        largest[case['s']] = float(np.abs(error).max())
        picture = axes.pcolormesh(FINE, FINE, error * 1e15, cmap='cividis', shading='nearest')
        figure.colorbar(picture, ax=axes, label='error along x, 1e-15 px')
        axes.set(
            xlabel='displacement along x, px', ylabel='displacement along y, px',
            title=f's = {case["s"]:g} px',
        )
        for dy, line in zip(FINE, error):
            cells += [[case['s'], float(dx), float(dy), float(v)] for dx, v in zip(FINE, line)]
    statement = printed.statements['largest']
    table = {row[:2]: row[5] for row in load('table_4_3').rows}
    of_text, of_caption = table['5', '3'], table['5', '1']
    whose = {of_text: 'the text is right', of_caption: 'the caption is right'}
    return Findings(
        shows=(
            f'In double precision the largest error is {largest[3.0]:.1g} px at s = 3 px and '
            f'{largest[1.0]:.1g} px at s = 1 px: no pattern, and {statement.value} px as printed '
            'is that of single precision. The text has s = 3 px and the caption s = 1 px; Table '
            f'4.3 prints {of_text} and {of_caption} px for these, so '
            f'{whose.get(statement.value, "neither is right")}. Without noise the Cramer-Rao '
            'bound is 0.'
        ),
        agreement=f'smaller than printed by {float(statement.value) / largest[3.0]:.1g} times',
        tables=[Table(
            'figure_4_6', f'{printed.source}: the error along x',
            ['s, px', 'displacement along x, px', 'along y, px', 'error, px'], cells,
        )],
        figures={'figure_4_6': figure},
        checks=[says(
            statement, f'<= {statement.value} px, which is of single precision',
            f'{largest[3.0]:.1g} px', largest[3.0] <= float(statement.value),
        )],
    )


STUDIES = (
    Study(
        'figure_4_6', 'Log-linear fit over all displacements in 5 px x 5 px',
        load('figure_4_6').source, _cases, measure, _conclude,
    ),
)

"""Table 2.1 and Figure 2.3: what a lens resolves, and what rounding does."""

from __future__ import annotations

from blob_tracker.studies.axes import COLOURS, legend_below, new_axes
from blob_tracker.studies.chapters_2_to_4.digit_comparison import compare_digits, Results
from blob_tracker.studies.chapters_2_to_4.lens_table import computed, WIDTH_IN_THE_TEXT
from blob_tracker.studies.chapters_2_to_4.row_sweeps import says
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import ONE, rounded, ROUNDING, rows
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
import numpy as np

_BIN = 0.02  # levels


def _lenses(quick: bool) -> list[Case]:
    """Return a case for each focal length."""
    return [{'focal_length': float(row[0])} for row in load('table_2_1').rows]


def _measure_lens(case: Case) -> Measured:
    """Return the least angle and the field of view, and the field of the sensor of the text."""
    angle, field = computed(case['focal_length'])
    return {
        'columns': [float(angle), float(field)],
        'field_in_text': float(computed(case['focal_length'], WIDTH_IN_THE_TEXT)[1]),
    }


def _conclude_lenses(results: Results) -> Findings:
    """Conclude for Table 2.1."""
    printed = load('table_2_1')
    comparison = compare_digits(
        'table_2_1', f'{printed.source}: ours, printed, difference', printed, 1,
        [measured['columns'] for _, measured in results],
    )
    lengths = [case['focal_length'] for case, _ in results]
    figure, panels = new_axes(2)
    for k, (axes, name) in enumerate(zip(panels, printed.columns[1:])):
        axes.plot(
            lengths, [measured['columns'][k] for _, measured in results], color=COLOURS[0],
            label='ours',
        )
        axes.plot(
            lengths, [float(row[1 + k]) for row in printed.rows], 'o', color=COLOURS[1],
            fillstyle='none', label=printed.source,
        )
        axes.set(xlabel='focal length, mm', ylabel=name, xscale='log', yscale='log')
    panels[1].plot(
        lengths, [measured['field_in_text'] for _, measured in results], '--', color=COLOURS[2],
        label=f'a sensor {WIDTH_IN_THE_TEXT} mm wide, as the text has it',
    )
    legend_below(figure, panels[1])
    text = sum(
        abs(measured['field_in_text'] - float(row[2])) < 0.005
        for (_, measured), row in zip(results, printed.rows)
    )
    return Findings(
        shows=(
            f'{comparison.sentence().capitalize()}, for the 641 pixels of 10 um of eq. 2.2; with '
            f'the sensor of {WIDTH_IN_THE_TEXT} mm that the text describes {text} of '
            f'{len(results)} fields of view would agree.'
        ),
        agreement=comparison.sentence(),
        tables=[comparison.table],
        figures={'table_2_1': figure},
        checks=[Check(
            'every printed digit', f'{comparison.off.size} of {comparison.off.size}',
            f'{comparison.same} of {comparison.off.size}',
            comparison.same == comparison.off.size,
        )],
    )


def _pulses(quick: bool) -> list[Case]:
    """Return a case for each window of the text."""
    return [{'window': window} for window in (15, 25, 33, 50)]


def _measure_rounding(case: Case) -> Measured:
    """Return the rounding errors of pulses of s = 0.5 to 9.5 px, and the pulses, in levels."""
    values = np.concatenate([
        rows(ONE, case['window'], s, np.zeros(1))[0] for s in np.arange(0.5, 9.51, 0.5)
    ])
    # The text keeps three decimals.
    return {'error': np.round(rounded(values) - values, 3).tolist(), 'value': values.tolist()}


def _conclude_rounding(results: Results) -> Findings:
    """Conclude for Figure 2.3."""
    printed = load('figure_2_3')
    error = np.concatenate([measured['error'] for _, measured in results])
    value = np.concatenate([measured['value'] for _, measured in results])
    lit = value >= 0.5
    edges = np.arange(-0.5 - _BIN / 2, 0.5 + _BIN, _BIN)
    share, of_lit = (np.histogram(part, edges)[0] / (error.size * _BIN) for part in (
        error, error[lit]
    ))
    middles = edges[:-1] + _BIN / 2
    figure, (axes,) = new_axes()
    axes.bar(middles, share, _BIN, color=COLOURS[4], label='all pixels')
    axes.step(
        middles, of_lit, where='mid', color=COLOURS[0], label='pixels that round to 1 and above'
    )
    level = lit.mean()
    axes.axhline(
        level, linestyle='--', color=COLOURS[1], label='even, with the variance 1/12 (eq. 2.6)'
    )
    axes.set(xlabel='rounded less true, levels', ylabel='density, 1/level', yscale='symlog')
    legend_below(figure, axes, 3)
    variance = float(error[lit].var())
    spike = float(middles[share.argmax()])
    dark = float((~lit & (np.abs(error) < 0.0005)).mean())
    statements = printed.statements
    cells: list[list[Cell]] = [
        [float(middle), float(a), float(b)] for middle, a, b in zip(middles, share, of_lit)
    ]
    return Findings(
        shows=(
            f'Of {error.size} rounding errors {100 * dark:.0f} % are zero to three decimals, all '
            f'in the tails below half a level; the pixels above have a variance of '
            f'{variance:.4f}, where an even error has {ROUNDING:.4f}. That is the noise '
            'with which the bounds of the figures of rounded pulses are drawn.'
        ),
        agreement='the same shape: even, with a spike at 0',
        tables=[Table(
            'figure_2_3', f'{printed.source}: density of the rounding error',
            ['rounded less true, levels', 'all pixels, 1/level', 'pixels of 1 and above, 1/level'],
            cells,
        )],
        figures={'figure_2_3': figure},
        checks=[
            says(
                statements['range'], f'<= {statements["range"].value} levels',
                f'{np.abs(error).max():.3f} at most',
                bool(np.abs(error).max() <= float(statements['range'].value)),
            ),
            says(
                statements['spike'], f'at {statements["spike"].value} levels within {_BIN:g}',
                f'at {abs(spike):.2f}, {share.max() / level:.0f} times the rest',
                abs(spike - float(statements['spike'].value)) < _BIN,
            ),
            Check(
                'the error of lit pixels is even: its variance', f'{ROUNDING:.4f} within a tenth',
                f'{variance:.4f}', abs(variance / ROUNDING - 1.0) < 0.1,
            ),
        ],
    )


STUDIES = (
    Study(
        'table_2_1', 'What a lens resolves and sees', load('table_2_1').source, _lenses,
        _measure_lens, _conclude_lenses,
    ),
    Study(
        'figure_2_3', 'Rounding as noise', load('figure_2_3').source, _pulses, _measure_rounding,
        _conclude_rounding,
    ),
)

"""The signal-to-noise ratios of the 1-D figures: Tables 3.1, 3.2, 4.1, 4.2, 4.6 and 4.7."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from blob_tracker.studies.axes import COLOURS, legend_below, new_axes
from blob_tracker.studies.chapters_2_to_4.digit_comparison import compare_digits, Results
from blob_tracker.studies.chapters_2_to_4.noise_readings import (
    CENTROID_READINGS, LOGARITHM_READINGS, Reading,
)
from blob_tracker.studies.chapters_2_to_4.row_sweeps import says
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import (
    Blob,
    COARSE,
    FINE,
    Numbers,
    ONE,
    rounded,
    rows,
    signal_to_noise,
    THREE,
)
from blob_tracker.studies.chapters_2_to_4.sampling import place_among
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
import numpy as np


@dataclass(frozen=True)
class _Table:
    """A row of so many pixels at these displacements, with noise by a reading, or without."""

    blob: Blob
    window: int
    shifts: Numbers
    reading: Reading | None
    without: str = ''  # the table of the same pulses without noise
    centroid: bool = False
    lit_only: bool = False  # pixels that round to zero are left out


_TABLES = {
    'table_3_1': _Table(ONE, 25, FINE, None, centroid=True),
    'table_3_2': _Table(ONE, 7, FINE, CENTROID_READINGS[0], 'table_3_1', centroid=True),
    'table_4_1': _Table(ONE, 9, FINE, None, lit_only=True),
    'table_4_2': _Table(ONE, 9, FINE, LOGARITHM_READINGS[0], 'table_4_1'),
    'table_4_6': _Table(THREE, 7, COARSE, None),
    'table_4_7': _Table(THREE, 7, COARSE, CENTROID_READINGS[0], 'table_4_6'),
}
# Of Figure 4.11, whose s the printed table does not have.
_FIGURE_4_11 = (2.0, 3.0, 5.0, 7.0, 10.0, 15.0)


def _cases(name: str, quick: bool) -> list[Case]:
    """Return a case for each s."""
    widths = [float(row[0]) for row in load(name).rows]
    if name == 'table_4_7':
        widths += [s for s in _FIGURE_4_11 if s not in widths]
    return [
        {'table': name, 's': s, 'repeats': 200 if quick else 2000, 'seed': k}
        for k, s in enumerate(widths)
    ]


def measure(case: Case) -> Measured:
    """Return the SNR averaged over the displacements, once for each repeat."""
    plan = _TABLES[case['table']]
    clean = rows(plan.blob, plan.window, case['s'], plan.shifts)
    if plan.reading is not None:
        random = np.random.default_rng(case['seed'])
        drawn = [plan.reading.apply(clean, random) for _ in range(case['repeats'])]
    else:
        seen = rounded(clean)
        used = (seen > 0.0) | (not plan.lit_only)
        drawn = [(seen, np.where(used, seen - clean, 0.0))]
    # As in the 2-D tables: the centroid's SNR is of the pulse before anything is done to it,
    # that of the fits of what they fit.
    return {'snr': [
        float(signal_to_noise(clean if plan.centroid else seen, error).mean())
        for seen, error in drawn
    ]}


def _conclude_rounded(name: str, what: str, results: Results) -> Findings:
    """Conclude for a table without noise: its digits are to agree."""
    printed = load(name)
    found = [measured['snr'] for _, measured in results]
    comparison = compare_digits(name, f'{printed.source}: ours, printed', printed, 1, found)
    figure, (axes,) = new_axes()
    widths = [case['s'] for case, _ in results]
    axes.plot(widths, [row[0] for row in found], color=COLOURS[0], label='ours')
    axes.plot(
        widths, [float(row[1]) for row in printed.rows], 'o', color=COLOURS[1], fillstyle='none',
        label=printed.source,
    )
    axes.set(xlabel='s, px', ylabel='mean SNR')
    legend_below(figure, axes)
    checks = [Check(
        'every number within one unit of the last printed digit', 'all',
        f'{comparison.same + comparison.one_off} of {comparison.off.size}',
        bool(np.abs(comparison.off).max() <= 1),
    )]
    if 'rises' in printed.statements:
        statement = printed.statements['rises']
        ours, theirs = (
            int((np.diff(values) > 0.0).sum())
            for values in ([row[0] for row in found], [float(row[1]) for row in printed.rows])
        )
        # The table contradicts its text: what is to come out again is the table.
        checks.append(says(
            statement, f'{theirs} as in the printed table (the text: {statement.value})',
            f'{ours}', ours == theirs,
        ))
    return Findings(
        shows=f'{what} {comparison.sentence().capitalize()}.' + (
            f' What differs lies {comparison.edge:.2g} units from where it would be rounded to '
            'what is printed.' if comparison.one_off else ''
        ),
        agreement=comparison.sentence(),
        tables=[comparison.table], figures={name: figure}, checks=checks,
    )


def _without_noise(name: str, s: float) -> float:
    """Return the mean SNR at an s, with the window and displacements of a table without noise."""
    return float(measure({'table': name, 's': s})['snr'][0])


def _conclude_noisy(name: str, what: str, results: Results) -> Findings:
    """Conclude for a table with noise: what is printed is to be a likely draw."""
    plan, printed = _TABLES[name], load(name)
    digits = {float(row[0]): row[1] for row in printed.rows}
    cells: list[list[Cell]] = []
    inside, scores = 0, []
    for case, measured in results:
        repeats = np.array(measured['snr'])
        line: list[Cell] = [case['s'], float(repeats.mean()), float(repeats.std(ddof=1))]
        if case['s'] in digits:
            place = place_among(digits[case['s']], repeats)
            inside += place.within_95
            scores.append(place.score)
            line += [digits[case['s']], place.score]
        else:
            line += [None, None]
        cells.append(line)
    figure, (axes,) = new_axes()
    ordered = sorted((case['s'], np.array(measured['snr'])) for case, measured in results)
    axes.errorbar(
        [s for s, _ in ordered], [one.mean() for _, one in ordered],
        [2.0 * one.std(ddof=1) for _, one in ordered], color=COLOURS[0], capsize=3,
        label='ours, with twice the standard deviation of a repeat',
    )
    axes.plot(
        list(digits), [float(value) for value in digits.values()], 'o', color=COLOURS[1],
        fillstyle='none', label=printed.source,
    )
    axes.set(xlabel='s, px', ylabel='mean SNR')
    legend_below(figure, axes)
    statement = printed.statements['ratio']
    over, under = statement.value.split('/')
    stated = float(over) / float(under)
    ratios = [
        float(np.mean(measured['snr'])) / _without_noise(plan.without, case['s'])
        for case, measured in results
    ]
    lower = f'{min(ratios):.2f} to {max(ratios):.2f}'
    if name == 'table_4_7':
        # Numbers of other pulses: where they lie among ours means nothing.
        copied = sum(row == other for row, other in zip(printed.rows, load('table_3_2').rows))
        sentence = (
            f'Ours are {lower} times those without noise, where the text (page {statement.page}) '
            f'has about {statement.value}.'
        )
        agreement = 'Table 3.2 is printed again in its place'
        checks = [Check(
            'what is printed is Table 3.2, digit for digit',
            f'{len(printed.rows)} of {len(printed.rows)} rows', f'{copied} rows',
            copied == len(printed.rows),
        )]
    else:
        sentence = (
            f'The printed SNR lie {min(scores):+.1f} to {max(scores):+.1f} standard deviations '
            f'from the mean of {len(results[0][1]["snr"])} repeats.'
        )
        agreement = f'{inside} of {len(scores)} numbers in the 95 % interval of our repeats'
        checks = [
            Check(
                'printed SNR in the 95 % interval of our repeats',
                f'{len(scores)} of {len(scores)}', f'{inside} of {len(scores)}',
                inside == len(scores),
            ),
            says(
                statement, f'{statement.value} within a fifth', f'{lower}, ours',
                all(abs(ratio / stated - 1.0) <= 0.2 for ratio in ratios),
            ),
        ]
    return Findings(
        shows=f'{what} {sentence}', agreement=agreement,
        tables=[Table(
            name, f'{printed.source}: our repeats, and what is printed',
            ['s, px', 'mean SNR: mean of repeats', 'sd', 'printed', 'score'], cells,
        )],
        figures={name: figure}, checks=checks,
    )


def _study(name: str, title: str, what: str) -> Study:
    """Return the study of a table."""
    conclude = _conclude_rounded if _TABLES[name].reading is None else _conclude_noisy
    return Study(
        name, title, load(name).source, partial(_cases, name), measure,
        partial(conclude, name, what),
    )


STUDIES = (
    _study(
        'table_3_1', 'SNR of rounded 1-D pulses, window 25 px',
        'Rounding alone leaves the pulses of Figure 3.4 an SNR above 400.',
    ),
    _study(
        'table_3_2', 'SNR of noisy 1-D pulses, window 7 px',
        'Noise of 1 DN beside the rounding divides the SNR by sqrt(13) = 3.6 in one window; that '
        'of Table 3.1, which the text compares, is not 7 px but 25 px wide.',
    ),
    _study(
        'table_4_1', 'SNR of rounded 1-D pulses, window 9 px',
        'Pixels that round to zero are left out, as the fit leaves them out.',
    ),
    _study(
        'table_4_2', 'SNR of noisy 1-D pulses, window 9 px',
        'Noise of 1 DN beside the rounding divides the SNR by sqrt(13) = 3.6, which the text '
        'calls about 4.',
    ),
    _study(
        'table_4_6', 'SNR of rounded three-Gaussian pulses, window 7 px',
        'These digits give away what the thesis does not print: 12 displacements in steps of '
        '0.09 px about w / 2 = 3.5 px, the first pixel being 0. The table is of all '
        'displacements, as in Figure 4.9 that the text names, not as in Figure 4.10 that the '
        'caption names.',
    ),
    _study(
        'table_4_7', 'SNR of noisy three-Gaussian pulses, window 7 px',
        'What is printed is Table 3.2 again, digit for digit: s = 1.0, 1.1 and 2.0, and not the '
        's = 2 to 15 of Figure 4.11; ours has those too.',
    ),
)

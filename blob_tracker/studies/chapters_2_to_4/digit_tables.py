"""The tables without noise: 3.3, 3.4, 4.3, 4.4, 4.8 and 4.9, beside what is printed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from blob_tracker.studies.chapters_2_to_4.digit_comparison import (
    compare_digits, DigitComparison, draw_errors, MEAN_OF_NORMAL, Results,
)
from blob_tracker.studies.chapters_2_to_4.row_sweeps import says
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import (
    Blob,
    bound,
    COARSE,
    error_summary,
    FINE,
    locate_stack,
    Numbers,
    ONE,
    rounded,
    ROUNDING,
    signal_to_noise,
    THREE,
    windows,
)
from blob_tracker.studies.printed import load, unit
from blob_tracker.studies.study import Case, Check, Findings, Measured, Study
import numpy as np

ASTRAY = 1e-5  # px: what double precision does not err by

_METHODS: dict[str, tuple[str, Blob]] = {
    'table_3_3': ('centroid', ONE),
    'table_3_4': ('centroid', ONE),
    'table_4_3': ('gaussian_linear', ONE),
    'table_4_4': ('gaussian_linear', ONE),
    'table_4_8': ('multi_gaussian_lm', THREE),
    'table_4_9': ('multi_gaussian_lm', THREE),
}


def _cases(name: str, quick: bool) -> list[Case]:
    """Return a case for each row: nothing is random, and quick enough to be done in full."""
    return [{'table': name, 'window': int(row[0]), 's': float(row[1])} for row in load(name).rows]


def measure(case: Case) -> Measured:
    """Locate the pulses of a row; return its error columns, its SNR and the bound."""
    name, size, s = case['table'], case['window'], case['s']
    method, blob = _METHODS[name]
    stack, x = windows(blob, size, s, FINE if blob is ONE else COARSE)
    quantised = name in ('table_3_4', 'table_4_4', 'table_4_9')
    seen = rounded(stack) if quantised else stack
    error = locate_stack(seen, method) - x
    result: Measured = {
        'columns': error_summary(error),
        'lost': int(np.isnan(error).sum()),
        'second': float(np.sort(np.abs(error[np.isfinite(error)]))[-2]),
        'astray': int((np.abs(error) > ASTRAY).sum()),
        'rms': float(np.sqrt(np.nanmean(error**2))),
    }
    if name == 'table_3_3':
        result['single'] = error_summary(_single_precision_error(stack, x))
    if quantised:
        noise = seen - stack
        if method == 'gaussian_linear':
            # The fit leaves the dark pixels out, and so does the printed SNR.
            noise = np.where(seen > 0.0, noise, 0.0)
        # Table 3.4's is of the pulse before it is rounded, the others' of what is located.
        signal = stack if method == 'centroid' else seen
        result['columns'].append(float(signal_to_noise(signal, noise).mean()))
        result['bound'] = bound(blob, size, s, ROUNDING)
    return result


def _single_precision_error(stack: Numbers, x: Numbers) -> Numbers:
    """Return the centroid's error where every sum is of single precision, columns first."""
    middle = (stack.shape[2] - 1) / 2
    places = (np.arange(stack.shape[2]) - middle).astype(np.float32)
    single = stack.astype(np.float32)
    columns = np.add.accumulate(single, axis=1, dtype=np.float32)[:, -1]
    total = np.add.accumulate(columns, axis=1, dtype=np.float32)[:, -1]
    moment = np.add.accumulate(places * columns, axis=1, dtype=np.float32)[:, -1]
    return (moment / total - (x - middle).astype(np.float32)).astype(np.float64)


def _compare(name: str, results: Results) -> DigitComparison:
    """Return the printed table beside ours."""
    printed = load(name)
    return compare_digits(
        name, f'{printed.source}: ours, printed, difference', printed, 2,
        [measured['columns'] for _, measured in results],
    )


def _figure_parts(name: str, results: Results) -> tuple[list[list[float]], list[float] | None]:
    """Return the columns, and the bound of the mean error where there is rounding."""
    found = [measured['columns'] for _, measured in results]
    if 'bound' not in results[0][1]:
        return found, None
    return found, [MEAN_OF_NORMAL * measured['bound'] for _, measured in results]


def _conclude_digits(name: str, what: str, results: Results) -> Findings:
    """Conclude for a table whose digits are to agree."""
    printed = load(name)
    comparison = _compare(name, results)
    found, bounds = _figure_parts(name, results)
    rows = comparison.off.shape[0]
    worst = max((row[1] for row in found))
    best = min((row[1] for row in found))
    shows = (
        f'{what} The mean error runs from {best:.2g} to {worst:.2g} px. '
        f'{comparison.sentence().capitalize()} ({comparison.rows_same} of {rows} rows in full).'
    )
    if bounds is None:
        shows += ' Without noise the Cramer-Rao bound is 0.'
    lost = sum(measured['lost'] for _, measured in results)
    if lost:
        shows += f' {lost} windows could not be located.'
    if comparison.same < comparison.off.size:
        shows += (
            f' What differs lies {comparison.edge:.2g} units or less from where it would be '
            'rounded to what is printed.'
        )
        shows += _remark(name, comparison, results)
    return Findings(
        shows=shows,
        agreement=comparison.sentence(),
        tables=[comparison.table],
        figures={name: draw_errors(
            printed, found, bounds, 1e-7,
            'bound on the mean error, rounding taken for noise of 1/12 DN^2',
        )},
        checks=[
            Check(
                'every number within one unit of the last printed digit',
                f'{comparison.off.size} of {comparison.off.size}',
                f'{comparison.same + comparison.one_off} of {comparison.off.size}',
                bool(np.abs(comparison.off).max() <= 1),
            ),
            Check(
                'every printed digit', f'{comparison.off.size} of {comparison.off.size}',
                f'{comparison.same} of {comparison.off.size}',
                comparison.same == comparison.off.size,
            ),
            *_of_the_text(name, results),
        ],
    )


def _of_the_text(name: str, results: Results) -> list[Check]:
    """Return the checks of what the text says of Table 3.4: of s = 1, 3, 5 in 25 px."""
    if name != 'table_3_4':
        return []
    said = load(name).statements
    ours = {
        case['s']: measured['columns'] for case, measured in results
        if case['window'] == 25 and case['s'] <= 5.0
    }
    best = min(ours, key=lambda s: float(ours[s][1]))
    snr = [columns[4] for columns in ours.values()]
    return [
        says(
            said['best'], f's = {said["best"].value} px',
            f's = {best:g} px, of mean errors ' + ', '.join(
                f'{columns[1]:.6f}' for columns in ours.values()
            ) + ' px', best == float(said['best'].value),
        ),
        says(
            said['snr'], f'{said["snr"].value} within 3 %',
            ', '.join(f'{value:.2f}' for value in snr),
            all(abs(value / float(said['snr'].value) - 1.0) <= 0.03 for value in snr),
        ),
    ]


def _remark(name: str, comparison: DigitComparison, results: Results) -> str:
    """Return what is known of the digits that differ."""
    if name == 'table_3_3':
        single = compare_digits(
            name, '', load(name), 2, [measured['single'] for _, measured in results]
        )
        return (
            ' All that differ are printed one higher, as sums of less than double precision may '
            f'be: with column sums of single precision {single.same} of {single.off.size} agree.'
        )
    if name == 'table_4_4':
        slack = [float(row[5]) for row in load('table_4_3').rows]
        within = sum(
            abs(float(printed[5]) - measured['columns'][3]) <= 0.00005 + spare
            for printed, (_, measured), spare in zip(load(name).rows, results, slack)
        )
        return (
            ' Those that differ are largest errors of wide pulses, for which Table 4.3 shows '
            f"errors of the thesis' own precision of as much: within those {within} of "
            f'{len(slack)} largest errors agree.'
        )
    if name == 'table_4_9':
        largest, second = results[0][1]['columns'][3], results[0][1]['second']
        return (
            f' The largest error in the window of 5 px at s = 1 is that of one place, '
            f'{largest:.4f} px at the minimum of the squares, where a start at the true '
            f'parameters ends too; the next largest is {second:.4f} px.'
        )
    return ''


def _conclude_unrounded(smaller: float, name: str, what: str, results: Results) -> Findings:
    """Conclude for a table of the printed program's precision: ours errs so many times less."""
    printed = load(name)
    comparison = _compare(name, results)
    found, _ = _figure_parts(name, results)
    # A printed zero is anything that is rounded to it.
    ratios = [
        max(float(row[5]), 0.5 * unit(row[5])) / max(ours[3], 1e-16)
        for row, ours in zip(printed.rows, found)
    ]
    better = sum(ratio >= smaller for ratio in ratios)
    larger = sum(ratio < 1.0 for ratio in ratios)
    ours, most = max(row[3] for row in found), max((row[5] for row in printed.rows), key=float)
    agreement = (
        f'largest errors larger than printed in {larger} of {len(ratios)} rows ({ours:.2g} px '
        f'where {most} px is printed), smaller in the others' if larger else
        f'{len(ratios)} of {len(ratios)} largest errors smaller than printed, by '
        f'{np.median(ratios):.2g} times in the middle'
    )
    return Findings(
        shows=(
            f'{what} The largest error is {ours:.2g} px, where {most} px is printed; row by row '
            f'the printed one is {min(ratios):.2g} to {max(ratios):.2g} times ours. '
            'Without noise the Cramer-Rao bound is 0.' + _astray(results)
        ),
        agreement=agreement,
        tables=[comparison.table],
        figures={name: draw_errors(printed, found, None, 1e-16, '')},
        checks=[Check(
            'largest error below the printed one in every row'
            + (f', {smaller:g} times' if smaller > 1.0 else ''),
            f'{len(ratios)} of {len(ratios)} rows', f'{better} rows', better == len(ratios),
        )],
    )


def _astray(results: Results) -> str:
    """Return what is to be said of fits that end away from the truth."""
    far = [(case['window'], case['s'], measured['astray']) for case, measured in results]
    places = ', '.join(f'{n} of 144 at {w} px, s = {s:g}' for w, s, n in far if n)
    return (
        f' Fits that end more than {ASTRAY:g} px away: {places}. Narrow pulses end in another '
        'minimum, where two of the three widths have become one, wide ones before the last '
        'digits; a start at the true parameters, which no image gives, would be at the end.'
    ) if places else ''


def _study(name: str, title: str, what: str, conclude: Callable[..., Findings]) -> Study:
    """Return the study of a table."""
    return Study(
        name, title, load(name).source, partial(_cases, name), measure,
        partial(conclude, name, what),
    )


STUDIES = (
    _study(
        'table_3_3', 'Centroid of sampled pulses', 'The skew error of the centroid on 2500 '
        'sub-pixel places: it is small where the window reaches 2.5 s to either side, and '
        'approaches the displacement itself where it does not.', _conclude_digits,
    ),
    _study(
        'table_3_4', 'Centroid of rounded pulses', 'Rounding to 8 bit adds a few thousandths of a '
        'pixel at most to the skew error of the centroid.', _conclude_digits,
    ),
    _study(
        'table_4_3', 'Log-linear fit to sampled pulses', 'The log-linear fit is exact: what is '
        # Double precision is of nine digits more: three of them are asked for.
        "printed is the thesis' single precision.", partial(_conclude_unrounded, 1000.0),
    ),
    _study(
        'table_4_4', 'Log-linear fit to rounded pulses', 'On rounded pulses the log-linear fit '
        'errs by hundredths of a pixel where the window is wide for the pulse, since it gives a '
        'pixel of 1 DN the weight of one of 255.', _conclude_digits,
    ),
    _study(
        'table_4_8', 'Three-Gaussian fit to sampled pulses', 'The fit of three Gaussians by '
        'Levenberg-Marquardt, from the image alone and without the true parameters as a start.',
        partial(_conclude_unrounded, 1.0),
    ),
    _study(
        'table_4_9', 'Three-Gaussian fit to rounded pulses', 'The displacements that the thesis '
        'does not print are 12 by 12 in steps of 0.09 px, the middle is half a pixel beside the '
        "middle pixel's: with these all four SNR agree.", _conclude_digits,
    ),
)

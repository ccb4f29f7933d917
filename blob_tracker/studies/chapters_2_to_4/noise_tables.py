"""The tables with noise, 3.5, 4.5 and 4.10: whether what is printed is one draw of ours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from blob_tracker.studies.chapters_2_to_4.digit_comparison import (
    draw_errors, MEAN_OF_NORMAL, Results,
)
from blob_tracker.studies.chapters_2_to_4.noise_readings import (
    CENTROID_READINGS, LOGARITHM_READINGS, Reading,
)
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import (
    Blob,
    bound,
    COARSE,
    error_summary,
    FINE,
    locate_stack,
    ONE,
    ROUNDING,
    signal_to_noise,
    THREE,
    windows,
)
from blob_tracker.studies.chapters_2_to_4.sampling import likely_count, place_among
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
import numpy as np

STATISTICS = ('mean error, px', 'variance of the error, px^2', 'largest error, px', 'mean SNR')
EXCLUDED = 5.0  # standard deviations, beyond which a reading is not that of the table


@dataclass(frozen=True)
class _Table:
    """How a table is repeated: rows of `tried`, each a window and an s, also by other readings."""

    method: str
    blob: Blob
    readings: tuple[Reading, ...]
    repeats: tuple[int, int]  # quick, full
    a_case: int  # repeats in one case
    tried: tuple[tuple[int, int], ...]


_TABLES = {
    'table_3_5': _Table(
        'centroid', ONE, CENTROID_READINGS, (5, 200), 25, ((5, 1), (25, 1), (25, 3), (5, 15))
    ),
    'table_4_5': _Table(
        'gaussian_linear', ONE, LOGARITHM_READINGS, (4, 48), 6, ((5, 1), (9, 1), (25, 1), (5, 15))
    ),
    'table_4_10': _Table(
        'multi_gaussian_lm', THREE, CENTROID_READINGS, (4, 100), 10, ((15, 1), (15, 7))
    ),
}


def _cases(name: str, quick: bool) -> list[Case]:
    """Return cases for each row by the first reading, and for some rows by the others."""
    plan = _TABLES[name]
    repeats = plan.repeats[0 if quick else 1]
    cases: list[Case] = []
    for row in load(name).rows:
        size, s = int(row[0]), int(row[1])
        if quick and name == 'table_4_5' and s not in (1, 5, 15):
            continue
        for reading in range(len(plan.readings)):
            if reading and (size, s) not in plan.tried:
                continue
            wanted = repeats if reading == 0 else max(plan.repeats[0], repeats // 10)
            for first in range(0, wanted, plan.a_case):
                cases.append({
                    'table': name, 'window': size, 's': s, 'reading': reading, 'seed': first,
                    'repeats': min(plan.a_case, wanted - first),
                })
    return cases


def measure(case: Case) -> Measured:
    """Repeat a row's experiment; return its statistics, each time."""
    plan = _TABLES[case['table']]
    size, s = case['window'], case['s']
    random = np.random.default_rng([case['seed'], case['reading'], size, s])
    clean, x = windows(plan.blob, size, s, FINE if plan.blob is ONE else COARSE)
    reading = plan.readings[case['reading']]
    repeats, squares, lost = [], [], 0
    for _ in range(case['repeats']):
        seen, noise = reading.apply(clean, random)
        error = locate_stack(seen, plan.method) - x
        lost += int(np.isnan(error).sum())
        squares.append(float(np.nanmean(error**2)))
        # As in Tables 3.4 and 4.4: the centroid's is of the pulse before anything is done to it.
        signal = clean if plan.method == 'centroid' else seen
        repeats.append(error_summary(error) + [float(signal_to_noise(signal, noise).mean())])
    return {
        'repeats': repeats, 'rms': float(np.sqrt(np.mean(squares))), 'lost': lost,
        'bound': bound(plan.blob, size, s, 1.0 + ROUNDING) if case['reading'] == 0 else None,
    }


def _gathered(results: Results) -> dict[tuple[int, int, int], list[Measured]]:
    """Return the results by window, s and reading."""
    found: dict[tuple[int, int, int], list[Measured]] = {}
    for case, measured in results:
        key = case['window'], case['s'], case['reading']
        found.setdefault(key, []).append(measured)
    return found


def _conclude(name: str, what: str, results: Results) -> Findings:
    """Count how many printed numbers are likely draws of ours."""
    printed, found = load(name), _gathered(results)
    cells: list[list[Cell]] = []
    rows, means, bounds = [], [], []
    within = {0.95: 0, 0.99: 0}
    scores: list[tuple[float, str]] = []
    for row in printed.rows:
        key = int(row[0]), int(row[1]), 0
        if key not in found:
            continue
        repeats = np.concatenate([np.array(part['repeats']) for part in found[key]])
        line: list[Cell] = [row[0], row[1]]
        for k, heading in enumerate(STATISTICS):
            place = place_among(row[3 + k], repeats[:, 1 + k])
            line += [place.middle, place.spread, row[3 + k], place.score]
            within[0.95] += place.within_95
            within[0.99] += place.within_99
            scores.append((place.score, f'{heading.split(",")[0]} at {row[0]} px, s = {row[1]}'))
        rms = float(np.sqrt(np.mean([part['rms'] ** 2 for part in found[key]])))
        cells.append([*line, rms, found[key][0]['bound']])
        rows.append(row)
        means.append(repeats.mean(axis=0).tolist())
        bounds.append(MEAN_OF_NORMAL * found[key][0]['bound'])
    count = len(scores)
    worst = max(scores, key=lambda pair: abs(pair[0]))
    columns = ['window, px', 's, px']
    for heading in STATISTICS:
        columns += [f'{heading}: mean of repeats', 'sd', 'printed', 'score']
    columns += ['rms error, px', 'Cramer-Rao bound, px']
    drawn = type(printed)(printed.source, printed.columns, tuple(rows), {})
    times = len(np.concatenate([np.array(p['repeats']) for p in found[key]]))
    first = [(case, measured) for case, measured in results if case['reading'] == 0]
    lost = sum(measured['lost'] for _, measured in first)
    places = (FINE if _TABLES[name].blob is ONE else COARSE).size ** 2
    located = places * sum(case['repeats'] for case, _ in first)
    readings = _readings_table(name, found)
    return Findings(
        shows=(
            f'{what} Of {count} printed numbers {within[0.95]} lie in the 95 % interval of '
            f'{times} repeats and {within[0.99]} in the 99 % interval (expected '
            f'{0.95 * count:.0f} and {0.99 * count:.0f}); the farthest is the {worst[1]}, '
            f'{worst[0]:+.1f} standard deviations. {readings[1]}'
            + (f' {lost} of {located} fits did not end.' if lost else '')
        ),
        agreement=(
            f'{within[0.95]} of {count} numbers in the 95 % interval of our repeats, '
            f'{within[0.99]} in the 99 %'
        ),
        tables=[
            Table(name, f'{printed.source}: our repeats, and what is printed', columns, cells),
            readings[0],
        ],
        figures={name: draw_errors(
            drawn, means, bounds, 1e-7, 'bound on the mean error, noise of 1 + 1/12 DN^2'
        )},
        checks=[
            Check(
                f'printed numbers in the {100 * share:.0f} % interval',
                f'at least {likely_count(count, share)} of {count} (1 % by chance fewer)',
                f'{inside} of {count}', inside >= likely_count(count, share),
            )
            for share, inside in within.items()
        ],
    )


def _readings_table(
    name: str, found: dict[tuple[int, int, int], list[Measured]]
) -> tuple[Table, str]:
    """Return the scores of the rows that were tried by each reading, and a sentence on them."""
    plan, printed = _TABLES[name], {row[:2]: row for row in load(name).rows}
    cells: list[list[Cell]] = []
    worst: dict[int, float] = {}
    for (size, s, reading), parts in found.items():
        if (size, s) not in plan.tried:
            continue
        repeats = np.concatenate([np.array(part['repeats']) for part in parts])
        row = printed[str(size), str(s)]
        scores = [place_among(row[3 + k], repeats[:, 1 + k]).score for k in range(4)]
        cells.append([plan.readings[reading].says, size, s, *scores])
        worst[reading] = max(worst.get(reading, 0.0), *map(abs, scores))
    table = Table(
        f'{name}_readings', 'Ways to put the noise on: printed less ours, in standard deviations',
        ['reading', 'window, px', 's, px', *STATISTICS], cells,
    )
    excluded = sum(score > EXCLUDED for reading, score in worst.items() if reading)
    return table, (
        f'So it is with this reading: {plan.readings[0].says}. {excluded} of the '
        f'{len(worst) - 1} others that were tried on {len(plan.tried)} rows put a printed number '
        f'more than {EXCLUDED:g} standard deviations away.'
    )


def _study(name: str, title: str, what: str) -> Study:
    """Return the study of a table."""
    return Study(
        name, title, load(name).source, partial(_cases, name), measure,
        partial(_conclude, name, what),
    )


STUDIES = (
    _study(
        'table_3_5', 'Centroid of pulses with noise',
        "The noise of the empty pixels is the centroid's error where the window is wide.",
    ),
    _study(
        'table_4_5', 'Log-linear fit to pulses with noise',
        'The logarithm of faint pixels is most of the error where the window is wide. The text '
        '(page 69) adds the noise to the rounded pulse; the table is of noise before rounding.',
    ),
    _study(
        'table_4_10', 'Three-Gaussian fit to pulses with noise',
        'On 12 by 12 displacements of 0.09 px, as in Table 4.9. The text (page 91) adds the noise '
        'to the rounded pulse.',
    ),
)

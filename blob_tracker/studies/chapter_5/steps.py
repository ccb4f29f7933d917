"""Tables 5.2 to 5.7 and Figures 5.5 to 5.7: steps of a target that the camera is moved by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from blob_tracker.studies.chapter_5.displacements import (
    bound, draw, figures_of, inches_per_pixel, LABORATORY, LOOKS, placed, PLACES,
    SEGMENTATIONS, STEPS, TARGETS, WHOLE,
)
from blob_tracker.studies.chapter_5.pictures import draw_places, draw_spread
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
import numpy as np
from numpy.typing import NDArray

SHIO_OTSU = 'otsu_window'
TOGETHER = 4  # seeds in a case: some seconds at most
FEWEST = 20  # sequences of which 5 and 95 % can be told


@dataclass(frozen=True)
class _Fit:
    """One column of a printed table: the method, and its pair of columns (0 or 1)."""

    method: str
    elliptical: bool
    pair: int
    row: str = ''  # heading of the printed row where it is not the segmentation's


@dataclass(frozen=True)
class _Trial:
    """A table: its number, page, target, methods and segmentations; and the figure of the text."""

    number: str
    page: int
    target: str
    title: str
    fits: tuple[_Fit, ...]
    segmentations: tuple[str, ...]
    seeds: tuple[int, int]  # quick and full
    figure: str = ''
    figure_page: int = 0
    figure_step: str = ''


CENTROID = (_Fit('centroid', False, 0),)
LINEAR = (_Fit('gaussian_linear', False, 0), _Fit('gaussian_linear_elliptical', False, 1))
MULTI = (
    _Fit('multi_gaussian_simplex', False, 0),
    _Fit('multi_gaussian_simplex', True, 1),
    _Fit('multi_gaussian_lm', False, 0, 'Least Squares'),
    _Fit('multi_gaussian_lm', True, 1, 'Least Squares'),
)
THREE = ('otsu_window', 'histogram', 'histogram_extended')
FOUR = tuple(SEGMENTATIONS)
TRIALS = (
    _Trial('5_2', 108, 'passive', 'centroid, passive target', CENTROID, THREE, (12, 200)),
    _Trial('5_3', 109, 'active', 'centroid, active target', CENTROID, THREE, (12, 200),
           '5_5', 110, '0.10'),
    _Trial('5_4', 111, 'passive', 'one Gaussian, linear, passive target', LINEAR, FOUR, (4, 100)),
    _Trial('5_5', 112, 'active', 'one Gaussian, linear, active target', LINEAR, FOUR, (4, 100),
           '5_6', 113, '1.00'),
    _Trial('5_6', 114, 'passive', 'three Gaussians, passive target', MULTI, (SHIO_OTSU,), (2, 24)),
    _Trial('5_7', 115, 'active', 'three Gaussians, active target', MULTI, (SHIO_OTSU,), (2, 24),
           '5_7', 116, '0.05'),
)


def _cases(trial: _Trial, quick: bool) -> Sequence[Case]:
    """Return a case for each step and each few seeds."""
    count = trial.seeds[0] if quick else trial.seeds[1]
    together = 1 if trial.fits is MULTI else TOGETHER
    return [
        {'table': trial.number, 'step': step, 'seeds': list(range(first, first + together))}
        for step in STEPS
        for first in range(0, count, together)
    ]


def measure(case: Case) -> Measured:
    """Take the sequences of a few seeds and locate them by all methods of the table."""
    trial = next(trial for trial in TRIALS if trial.number == case['table'])
    found: dict[str, list[Any]] = {}
    places: dict[str, list[float | None]] = {}
    for seed in case['seeds']:
        sequence = draw(TARGETS[trial.target], case['step'], LABORATORY, seed)
        for segmentation in trial.segmentations:
            for fit in trial.fits:
                for averaged in (False, True):
                    for removed in (False, True):
                        if removed and fit.method.endswith('simplex'):
                            continue  # it finds the minimum of multi_gaussian_lm
                        x = placed(
                            sequence, segmentation, fit.method, averaged=averaged,
                            removed=removed, elliptical=fit.elliptical,
                        )
                        key = _key(segmentation, fit, averaged, removed)
                        found.setdefault(key, []).append(figures_of(x, sequence.truth))
                        if seed == 0:
                            places[key] = _jsonable(x)
        if trial.fits is LINEAR:
            x = placed(sequence, WHOLE, LINEAR[0].method, averaged=False, removed=False)
            key = _key(WHOLE, LINEAR[0], False, False)
            found.setdefault(key, []).append(figures_of(x, sequence.truth))
            if seed == 0:
                places[key] = _jsonable(x)
        if seed == 0:
            places['truth'] = [float(value) for value in sequence.truth]
    return {'found': found, 'places': places}


def _jsonable(x: NDArray[np.float64]) -> list[float | None]:
    """Return places as JSON can hold them."""
    return [None if np.isnan(value) else float(value) for value in x]


def _key(segmentation: str, fit: _Fit, averaged: bool, removed: bool) -> str:
    """Name a way to locate."""
    shape = 'elliptical' if fit.pair else 'circular'
    return ' '.join([
        segmentation, fit.method, shape, 'multi' if averaged else 'single',
        'removed' if removed else 'raw',
    ])


def _conclude(trial: _Trial, results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Lay the printed numbers beside the spread of ours."""
    printed = load(f'table_{trial.number}')
    target = TARGETS[trial.target]
    limits = {
        looks: bound(target, count) for looks, count in (('single', 1), ('multi', LOOKS))
    }
    rows: list[list[Cell]] = []
    within, compared, worst = 0, 0, []
    for entry in printed.rows:
        step, heading, looks = entry[:3]
        for fit in trial.fits:
            segmentation = _segmentation(trial, fit, heading)
            if segmentation is None:
                continue
            raw = _gathered(results, step, _key(segmentation, fit, looks == 'multi', False))
            clean = _gathered(results, step, _key(segmentation, fit, looks == 'multi', True))
            mean, variance = (float(entry[3 + 2 * fit.pair + i]) for i in (0, 1))
            means, variances = raw['mean'], raw['variance']
            low, high = np.quantile(variances, [0.05, 0.95])
            within += bool(low <= variance <= high)
            compared += 1
            worst.append(float(np.median(raw['worst'])))
            caliper = LABORATORY.caliper / inches_per_pixel(step)
            floor = float(np.hypot(limits[looks], caliper))
            rows.append([
                step, heading, looks, 'elliptical' if fit.pair else 'circular', fit.method,
                mean, _median(means), mean - _median(means), *_interval(means),
                _below(means, mean), variance, _median(variances), variance - _median(variances),
                float(low), float(high), _below(variances, variance),
                _median(raw['rms']), _median(raw['apart']), _median(raw['worst']),
                _median(clean['apart']) if clean else None, limits[looks], 2.0 * floor**2,
                int(sum(raw['lost'])),
            ])
    table = Table(
        f'table_{trial.number}',
        f'Table {trial.number.replace("_", ".")}, page {trial.page}: {trial.title}',
        [
            'expected step, px', 'segmentation', 'looks', 'shape', 'method',
            'mean step printed, px', 'mean step, median, px', 'difference, px', '5 %', '95 %',
            'of ours below the printed, %', 'variance printed, px^2', 'variance, median, px^2',
            'difference, px^2', '5 %', '95 %', 'of ours below the printed, %',
            'rms of places, px', 'less their offset, px', 'worst place, px',
            'rms less offset, background removed, px', 'bound of a place, px',
            'variance at bound and caliper, px^2', 'places lost',
        ],
        rows,
    )
    apart = [float(str(row[18])) for row in rows]
    figures = {f'variances_{trial.number}': draw_spread(
        f'Variance of the steps, {trial.title}', rows, 'variance of the ten steps, px$^2$',
    )}
    if trial.figure:
        places = next(
            measured['places'] for case, measured in results
            if case['step'] == trial.figure_step and 0 in case['seeds']
        )
        figures[f'figure_{trial.figure}'] = draw_places(
            f'Figure {trial.figure.replace("_", ".")}: {trial.title}, steps of '
            f'{trial.figure_step} px',
            _shown(trial, places), places['truth'], limits,
        )
    centred = sum(float(str(row[8])) <= float(str(row[5])) <= float(str(row[9])) for row in rows)
    if _seeds(results) < FEWEST:
        spread = agreement = 'too few sequences for a spread (quick run)'
    else:
        spread = f'{within} of {compared} between our 5 and 95 %'
        agreement = f'{centred} means and {within} variances of {compared} within our 5 to 95 %'
    window = ''
    if trial.fits is LINEAR:
        steps = _gathered(results, '1.00', _key(WHOLE, LINEAR[0], False, False))['mean']
        window = (
            ' The steps that the thesis prints, far too small, are not found again in windows '
            'that follow the target. One that does not shrinks them, though less: fitted to the '
            f'whole crop, with its background, those of 1.00 px come out as {_median(steps):.2f} '
            'px.'
        )
    return Findings(
        shows=(
            f'Over {_seeds(results)} sequences each, the places scatter by '
            f'{min(apart):.3f} to {max(apart):.3f} px rms about the truth and their common offset '
            f'(the trailing edge), the worst of eleven by {min(worst):.2f} to {max(worst):.2f} px'
            f'; the bound is {limits["single"]:.4f} px for one look. Of what is printed: '
            f'{agreement}.{window}'
        ),
        agreement=agreement,
        tables=[table],
        figures=figures,
        checks=_checks(trial, rows, worst, apart, spread),
    )


def _checks(
    trial: _Trial, rows: Sequence[Sequence[Cell]], worst: Sequence[float],
    apart: Sequence[float], spread: str,
) -> list[Check]:
    """Hold the rows against what the thesis says of its method."""
    text = load('figure_5_5').statements['accuracy']
    middle = float(np.median(worst))
    ratio = _median([float(str(row[11])) / float(str(row[12])) for row in rows])
    checks = []
    if trial.fits is CENTROID:
        checks.append(Check(
            f'the centroid is good to about {text.value} px (page {text.page})',
            f'the worst of eleven places within a factor of 2 of {text.value} px',
            f'{middle:.3f} px, the median over rows and seeds',
            0.5 <= middle / float(text.value) <= 2.0,
        ))
        checks.append(Check(
            'the printed variances are of the size of ours',
            'the median of their ratio over the rows is within a factor of 4',
            f'{ratio:.2f} times ours; {spread}',
            0.25 <= ratio <= 4.0,
        ))
    if trial.fits is LINEAR:
        whole = _median([float(str(row[6])) for row in rows if row[0] == '1.00'])
        checks.append(Check(
            'one Gaussian by linear least squares follows steps of 1.00 px',
            '0.9 to 1.1 px; the thesis prints 0.07 to 0.34 px', f'{whole:.3f} px',
            0.9 <= whole <= 1.1,
        ))
    if trial.fits is MULTI:
        checks.append(Check(
            'three Gaussians place the target to 0.05 px but for their common offset',
            '0.05 px rms; the thesis has 0.25 px', f'{max(apart):.3f} px at most',
            max(apart) <= 0.05,
        ))
    return checks


def _segmentation(trial: _Trial, fit: _Fit, heading: str) -> str | None:
    """Return the segmentation of a printed row, None if it is not of this method."""
    if fit.row or heading == 'Least Squares':
        return trial.segmentations[0] if fit.row == heading else None
    return next(key for key, name in SEGMENTATIONS.items() if name == heading)


def _gathered(
    results: Sequence[tuple[Case, Measured]], step: str, key: str
) -> dict[str, list[float]]:
    """Return each figure of all seeds; nothing where the way was not gone."""
    entries = [
        entry for case, measured in results if case['step'] == step
        for entry in measured['found'].get(key, [])
    ]
    if not entries:
        return {}
    return {
        name: [entry[name] for entry in entries if entry[name] is not None] for name in entries[0]
    }


def _shown(trial: _Trial, places: dict[str, Any]) -> dict[str, list[float | None]]:
    """Return the curves of the figure: the extended histogram's, or Shio and Otsu's, raw."""
    segmentation = (
        'histogram_extended' if 'histogram_extended' in trial.segmentations else SHIO_OTSU
    )
    return {
        key.removesuffix(' raw'): x for key, x in places.items()
        if key.startswith((segmentation + ' ', WHOLE + ' ')) and key.endswith(' raw')
        and 'circular' in key
    }


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))


def _interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the 5th and the 95th percentile."""
    low, high = np.quantile(values, [0.05, 0.95])
    return float(low), float(high)


def _below(values: Sequence[float], printed: float) -> float:
    """Return how many of a hundred are below the printed value."""
    return float(100.0 * np.mean(np.asarray(values) < printed))


def _seeds(results: Sequence[tuple[Case, Measured]]) -> int:
    """Return how many sequences were taken of each step."""
    return sum(len(case['seeds']) for case, _ in results) // len(STEPS)


def _study(trial: _Trial) -> Study:
    """Return the study of a table."""
    conclude: Callable[[Sequence[tuple[Case, Measured]]], Findings] = partial(_conclude, trial)
    figure = (
        f'; Figure {trial.figure.replace("_", ".")}, page {trial.figure_page}'
        if trial.figure else ''
    )
    return Study(
        name=f'table_{trial.number}',
        title=f'Steps between {PLACES} places: {trial.title}',
        source=f'Table {trial.number.replace("_", ".")}, page {trial.page}{figure}',
        cases=partial(_cases, trial),
        measure=measure,
        conclude=conclude,
    )


STUDIES = tuple(_study(trial) for trial in TRIALS)

"""A row of pixels located at many displacements or widths: the 1-D figures' machinery."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from blob_tracker.location.centroid import centroid_1d
from blob_tracker.location.gaussian_linear import gaussian_linear_1d
from blob_tracker.location.multi_gaussian_lm import multi_gaussian_lm_1d
from blob_tracker.location.multi_gaussian_simplex import multi_gaussian_simplex_1d
from blob_tracker.studies.axes import COLOURS, GOAL, legend_below, new_axes
from blob_tracker.studies.chapters_2_to_4.noise_readings import CENTROID_READINGS
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import (
    Blob,
    Numbers,
    rounded,
    ROUNDING,
    row_bound,
    rows,
)
from blob_tracker.studies.printed import load, Statement
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
from blob_tracker.types import LocationError
from matplotlib.figure import Figure
import numpy as np

_FITS: dict[str, Callable[[Numbers], Any]] = {
    'gaussian_linear': gaussian_linear_1d,
    'multi_gaussian_lm': multi_gaussian_lm_1d,
    'multi_gaussian_simplex': multi_gaussian_simplex_1d,
}
_VARIANCE = {'rounded': ROUNDING, 'noisy': 1.0 + ROUNDING}  # DN^2
_BOUND = {
    'rounded': 'Cramer-Rao bound, rounding taken for noise of 1/12 DN^2',
    'noisy': 'Cramer-Rao bound, noise of 1 + 1/12 DN^2',
}
_NAMES = {'s': 's', 'window': 'window', 'shift': 'displacement'}
_LETTERS = {'s': 's', 'window': 'w', 'shift': 'd'}
_METHODS = {
    'multi_gaussian_simplex': 'simplex', 'multi_gaussian_lm': 'Levenberg-Marquardt',
}


@dataclass(frozen=True)
class Sweep:
    """
    A figure: a curve for each of some values, along an axis of others.

    Parameters
    ----------
    name : str
        Of the study.
    methods : tuple of str
        The first is the figure's; the others are measured beside it.
    blob : Blob
        What is sampled.
    pixels : str
        'sampled', 'rounded' or 'noisy'.
    curves, along : (str, tuple of float)
        What tells the curves apart, and what runs along them: 's', 'window' or 'shift', px.
    fixed : (str, float)
        The third of these.
    repeats : (int, int)
        With noise: quick and full.

    """

    name: str
    methods: tuple[str, ...]
    blob: Blob
    pixels: str
    curves: tuple[str, tuple[float, ...]]
    along: tuple[str, tuple[float, ...]]
    fixed: tuple[str, float]
    repeats: tuple[int, int] = (1, 1)


@dataclass(frozen=True)
class Curve:
    """
    One curve of a sweep.

    Parameters
    ----------
    value : float
        What tells it from the others, px.
    along : (P,) array
        px.
    error : dict of (P,) array
        By method: estimate less truth of the first repeat, px; NaN if there is none.
    rms : dict of (P,) array
        By method: over the repeats, px.
    bound : (P,) array
        Cramer-Rao bound, px; NaN where the pixels do not determine the pulse.

    """

    value: float
    along: Numbers
    error: dict[str, Numbers]
    rms: dict[str, Numbers]
    bound: Numbers


def locate_rows(values: Numbers, method: str) -> Numbers:
    """Return the (M,) places of (M, n) rows, px from the first pixel; NaN if there is none."""
    if method == 'centroid':
        return centroid_1d(values)
    places = np.full(len(values), np.nan)
    for n, row in enumerate(values):
        try:
            places[n] = _FITS[method](row)[0]
        except LocationError:
            pass
    return places


def cases(sweep: Sweep, thin: int, quick: bool) -> list[Case]:
    """Return a case for each curve and method; quick takes each `thin`-th place along them."""
    along = sweep.along[1][::thin] if quick else sweep.along[1]
    return [
        {
            'method': method, 'pixels': sweep.pixels, 'centred': sweep.blob.centred,
            'amplitudes': list(sweep.blob.amplitudes), 'widths': list(sweep.blob.widths),
            'curve': [sweep.curves[0], value], 'along': [sweep.along[0], list(along)],
            'fixed': list(sweep.fixed), 'seed': seed,
            'repeats': sweep.repeats[0 if quick else 1] if sweep.pixels == 'noisy' else 1,
        }
        for seed, value in enumerate(sweep.curves[1]) for method in sweep.methods
    ]


def measure(case: Case) -> Measured:
    """Locate the rows of one curve by one method."""
    blob = Blob(tuple(case['amplitudes']), tuple(case['widths']), case['centred'])
    random = np.random.default_rng(case['seed'])
    name, values = case['along']
    where = dict([case['curve'], case['fixed']])
    errors, bounds = [], []
    for value in values:
        where[name] = value
        count, shift = int(where['window']), float(where['shift'])
        clean = rows(blob, count, where['s'], np.full(case['repeats'], shift))
        seen = clean
        if case['pixels'] == 'rounded':
            seen = rounded(clean)
        elif case['pixels'] == 'noisy':
            seen = CENTROID_READINGS[0].apply(clean, random)[0]
        errors.append(locate_rows(seen, case['method']) - blob.middle(count) - shift)
        bounds.append(
            row_bound(blob, count, where['s'], shift, _VARIANCE[case['pixels']])
            if case['pixels'] in _VARIANCE else 0.0
        )
    every = np.array(errors)
    known = np.isfinite(every)
    count_known = known.sum(axis=1)
    squares = np.where(known, every, 0.0) ** 2
    rms = np.sqrt(squares.sum(axis=1) / np.maximum(count_known, 1))
    # What JSON can hold: None for what is not known.
    return {
        'error': [float(v) if np.isfinite(v) else None for v in every[:, 0]],
        'rms': [float(v) if n else None for v, n in zip(rms, count_known)],
        'bound': [float(v) if np.isfinite(v) else None for v in bounds],
        'lost': int((~known).sum()), 'located': int(known.size),
    }


def curves_of(sweep: Sweep, results: Sequence[tuple[Case, Measured]]) -> list[Curve]:
    """Return the curves, all methods of each together."""
    found = []
    for value in sweep.curves[1]:
        parts = [(case, measured) for case, measured in results if case['curve'][1] == value]
        found.append(Curve(
            value, np.array(parts[0][0]['along'][1]),
            {case['method']: np.array(measured['error'], float) for case, measured in parts},
            {case['method']: np.array(measured['rms'], float) for case, measured in parts},
            np.array(parts[0][1]['bound'], float),
        ))
    return found


def says(statement: Statement, asked: str, found: str, met: bool) -> Check:
    """Return the check of what the text says; `asked` has its number, relation and unit."""
    return Check(f'page {statement.page}: {statement.says}', asked, found, met)


def conclude(
    sweep: Sweep,
    what: str,
    look: Callable[[list[Curve]], tuple[str, list[Check]]],
    results: Sequence[tuple[Case, Measured]],
) -> Findings:
    """
    Conclude for a figure.

    Parameters
    ----------
    sweep : Sweep
        The figure.
    what : str
        What it shows, before the numbers.
    look : callable
        From the curves to a sentence with the numbers, and the checks of what the text says.
    results : sequence
        As measured.

    """
    curves = curves_of(sweep, results)
    sentence, checks = look(curves)
    lost = sum(measured['lost'] for _, measured in results)
    located = sum(measured['located'] for _, measured in results)
    shows = f'{what} {sentence}'
    if lost:
        shows += f' {lost} of {located} rows could not be located.'
    if any(np.isnan(curve.bound).any() for curve in curves):
        shows += ' The bound is drawn where the pixels determine all the parameters.'
    if sweep.pixels == 'sampled':
        shows += ' Without noise the Cramer-Rao bound is 0.'
    met = sum(check.met for check in checks)
    return Findings(
        shows=shows,
        agreement=f'{met} of {len(checks)} statements of the text hold' if checks else '',
        tables=[_table(sweep, curves)],
        figures={sweep.name: draw(sweep, curves)},
        checks=checks,
    )


def _table(sweep: Sweep, curves: list[Curve]) -> Table:
    """Return all numbers of a figure."""
    columns = [f'{_NAMES[sweep.curves[0]]}, px', f'{_NAMES[sweep.along[0]]}, px']
    for method in sweep.methods:
        columns += [f'{method}: error, px', f'{method}: rms error, px']
    columns.append('Cramer-Rao bound, px')
    cells: list[list[Cell]] = []
    for curve in curves:
        for n, place in enumerate(curve.along):
            line: list[Cell] = [curve.value, float(place)]
            for method in sweep.methods:
                line += [_known(curve.error[method][n]), _known(curve.rms[method][n])]
            cells.append([*line, _known(curve.bound[n])])
    return Table(sweep.name, f'{load(sweep.name).source}: all that is drawn', columns, cells)


def _known(value: float) -> float | None:
    """Return a number, or None if there is none."""
    return float(value) if np.isfinite(value) else None


def draw(sweep: Sweep, curves: list[Curve]) -> Figure:
    """Draw the errors as the thesis does, and beside them their size against the bound."""
    figure, (left, right) = new_axes(2)
    method = sweep.methods[0]
    by_s = sweep.along[0] == 's'
    # Below this all is rounding of the sums.
    least = 1e-16 if sweep.pixels == 'sampled' else 1e-5
    for curve, colour in zip(curves, COLOURS):
        label = f'{_LETTERS[sweep.curves[0]]} = {curve.value:g} px'
        left.plot(curve.along, curve.error[method], color=colour, linewidth=1.0, label=label)
        for name, style in zip(sweep.methods, ('-', ':')):
            size = np.maximum(curve.rms[name], least)
            right.plot(curve.along, size, style, color=colour, linewidth=1.0)
        if sweep.pixels != 'sampled':
            right.plot(curve.along, curve.bound, '--', color=colour, linewidth=0.8)
    if sweep.pixels != 'sampled':
        left.plot([], [], '--', color='black', linewidth=0.8, label=_BOUND[sweep.pixels])
    if len(sweep.methods) > 1:
        for name, style in zip(sweep.methods, ('-', ':')):
            left.plot([], [], style, color='black', linewidth=1.0, label=_METHODS[name])
    right.axhline(GOAL, color='grey', linewidth=0.8)
    right.annotate(
        f'{GOAL:g} px', (0.99, GOAL), xycoords=('axes fraction', 'data'), ha='right', va='bottom',
        fontsize='small', color='grey',
    )
    name = 's, px' if by_s else 'displacement, px'
    left.set(xlabel=name, ylabel='estimate less truth, px')
    right.set(
        xlabel=name, yscale='log',
        ylabel='rms error, px' if sweep.pixels == 'noisy' else '|error|, px',
    )
    legend_below(figure, left, 4)
    return figure


def study(
    sweep: Sweep,
    title: str,
    what: str,
    look: Callable[[list[Curve]], tuple[str, list[Check]]],
    thin: int = 1,
) -> Study:
    """Return the study of a figure."""
    return Study(
        sweep.name, title, load(sweep.name).source, partial(cases, sweep, thin), measure,
        partial(conclude, sweep, what, look),
    )

"""The thesis' future work: locales as a table, its accuracy and its speed beside the others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from blob_tracker.studies.axes import GOAL
from blob_tracker.studies.beyond.locale_table_measurements import cases, KINDS, measure, METHODS
from blob_tracker.studies.beyond.locale_table_pictures import (
    draw_phase, draw_pictures, draw_sizes, draw_snr,
)
from blob_tracker.studies.study import Case, Check, Findings, Measured, Study, Table


def _conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Draw and judge."""
    by_kind = {
        kind: [(case, found) for case, found in results if case['kind'] == kind]
        for kind in KINDS
    }
    locales, snr, phase = by_kind['locales'], by_kind['snr'], by_kind['phase']
    thesis = next(
        found for case, found in locales if (case['s'], case['amplitude']) == (1.0, 255.0)
    )
    sure = [found for case, found in snr if case['snr'] >= 10.0]
    ratio = max(found['locale_table']['rms'] / found['bound'] for found in sure)
    nees = [found['locale_table']['nees'] for found in sure]
    bias = max(abs(found['locale_table']['bias']) for _, found in phase)
    faster = {}
    for method in METHODS:
        ratios = [found['locale_table'] / found[method] for _, found in by_kind['speed']]
        faster[method] = f'{min(ratios):.1f} to {max(ratios):.1f} times'
    single = by_kind['speed'][0][1]['single']
    # Of a node that places one window in each frame.
    saved = 1e6 * (single['maximum_likelihood'] - single['locale_table'])
    shapes = {case['shape']: found for case, found in by_kind['shape']}
    tilted = shapes['ellipse, axes 1.5 to 1, at 45 degrees']
    tilted = tilted['locale_table']['rms'] / tilted['maximum_likelihood']['rms']
    clipped = shapes['Gaussian, clipped at half its peak']['locale_table']['located']
    shows = (
        f"The locales of the thesis' pulse (A 255 DN, s 1 px) leave {thesis['locale_rms']:.4f} px "
        f'rms and {thesis["locale_most"]:.4f} px at most to a map that knows its amplitude and '
        f'width, which is below what rounding leaves to anybody else ({thesis["bound"]:.4f} px). '
        'A table of normalised ratios, which needs to know neither, stays within '
        f'{ratio:.2f} times the Cramer-Rao bound from SNR 10 to 500, at '
        f'{faster["maximum_likelihood"]} the fits a second of maximum likelihood and '
        f'{faster["centroid"]} those of the centroid, in stacks of windows. A single call saves '
        f'{saved:.0f} of {1e6 * single["maximum_likelihood"]:.0f} us: the rest is the call '
        f'itself. With tilted blobs its rms error is {tilted:.1f} times that of maximum '
        f'likelihood, and of clipped ones it places {100.0 * clipped:.0f} %.'
    )
    return Findings(
        shows=shows,
        agreement=(
            f'a table is within {ratio:.2f} times the Cramer-Rao bound, at '
            f'{faster["maximum_likelihood"]} the fits a second of maximum likelihood'
        ),
        tables=(
            _locale_rows(locales),
            _error_rows('locale_table_snr', 'rms error over peak SNR; 9 x 9, sigma 1.5 px',
                        'peak SNR', snr, 'snr'),
            _error_rows('locale_table_phase',
                        'error over sub-pixel phase; 9 x 9, sigma 1.2 px, SNR 100',
                        'phase, px', phase, 'phase'),
            _shape_rows(by_kind['shape']),
            _speed_rows(by_kind['speed']),
        ),
        figures={
            'locale_table_locales': draw_pictures(by_kind['picture']),
            'locale_table_sizes': draw_sizes(locales),
            'locale_table_snr': draw_snr(snr),
            'locale_table_phase': draw_phase(phase),
        },
        checks=(
            Check('rms error of locale_table from SNR 10 to 500', '<= 1.05 x the bound',
                  f'{ratio:.3f} x', ratio <= 1.05),
            Check('its covariance from SNR 10 to 500', 'NEES 1.9 to 2.1 of 2',
                  f'{min(nees):.2f} to {max(nees):.2f}', 1.9 <= min(nees) and max(nees) <= 2.1),
            Check('its bias over the sub-pixel phase', '<= 0.005 px', f'{bias:.4f} px',
                  bias <= 0.005),
            Check("the locales of the thesis' pulse", f'<= {GOAL:g} px',
                  f'{thesis["locale_most"]:.4f} px at most', thesis['locale_most'] <= GOAL),
        ),
    )


def _locale_rows(locales: Iterable[tuple[Case, Measured]]) -> Table:
    return Table(
        'locale_table_sizes',
        "Locales of the thesis' sampled pulse, rounded, and locators that do not know of them",
        ('s, px', 'A, DN', 'exact map rms, px', 'exact map most, px', 'bound of 1/12 DN^2, px',
         *(f'{method} {what}, px' for method in METHODS for what in ('rms', 'most'))),
        [
            (case['s'], case['amplitude'], found['locale_rms'], found['locale_most'],
             found['bound'], *(found[method][what] for method in METHODS
                               for what in ('rms', 'most')))
            for case, found in locales
        ],
    )


def _error_rows(
    name: str, title: str, heading: str, results: Iterable[tuple[Case, Measured]], key: str
) -> Table:
    kinds = ('rms', 'bias', 'nees', 'located')
    units = {'rms': 'rms, px', 'bias': 'mean in x, px', 'nees': 'NEES', 'located': 'located'}
    return Table(
        name, title,
        (heading, 'bound, px', *(f'{method} {units[kind]}' for method in METHODS
                                 for kind in kinds)),
        [
            (case[key], found['bound'], *(found[method][kind] for method in METHODS
                                          for kind in kinds))
            for case, found in results
        ],
    )


def _shape_rows(shapes: Iterable[tuple[Case, Measured]]) -> Table:
    return Table(
        'locale_table_shapes', 'Where it loses: rms error by shape; 15 x 15, SNR 50',
        ('shape', *(f'{method} {what}' for method in METHODS
                    for what in ('rms, px', 'NEES', 'located'))),
        [
            (case['shape'], *(found[method][what] for method in METHODS
                              for what in ('rms', 'nees', 'located')))
            for case, found in shapes
        ],
    )


def _speed_rows(speeds: Iterable[tuple[Case, Measured]]) -> Table:
    others = [method for method in METHODS if method != 'locale_table']
    return Table(
        'locale_table_speed',
        'Fits a second of one core, and locale_table over the others in the same run',
        ('window, px', 'sigma, px', *(f'{method}, 1/s' for method in METHODS),
         *(f'over {method}' for method in others),
         *(f'one call of {method}, us' for method in METHODS)),
        [
            (case['size'], case['sigma'], *(round(found[method]) for method in METHODS),
             *(round(found['locale_table'] / found[method], 2) for method in others),
             *(round(1e6 * found['single'][method], 1) for method in METHODS))
            for case, found in speeds
        ],
    )


STUDY = Study(
    name='locale_table',
    title='Locales as a look-up: what a table of them can do, and how fast',
    source='Sections 2.3 and 6.1, pages 21 and 118',
    cases=cases,
    measure=measure,
    conclude=_conclude,
)

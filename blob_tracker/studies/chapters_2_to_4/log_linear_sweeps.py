"""Figures 4.1 to 4.5: one Gaussian fitted to the logarithm of a row of pixels."""

from __future__ import annotations

from functools import partial

from blob_tracker.studies.axes import GOAL
from blob_tracker.studies.chapters_2_to_4.row_sweeps import Curve, says, study, Sweep
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import FINE, ONE
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Check
import numpy as np

_SHIFTS = tuple(FINE.tolist())
_WIDTHS = (1.0, 3.0, 5.0, 7.0, 10.0, 15.0)
_METHODS = ('gaussian_linear',)
Look = tuple[str, list[Check]]


def _largest(curve: Curve) -> float:
    """Return the largest error of a curve, px."""
    return float(np.nanmax(np.abs(curve.error['gaussian_linear'])))


def _rms(curve: Curve) -> float:
    """Return the rms error of a curve, px."""
    return float(np.sqrt(np.nanmean(curve.rms['gaussian_linear'] ** 2)))


def _sampled(name: str, curves: list[Curve]) -> Look:
    """Look at sampled pulses along the displacement."""
    printed = load(name).statements
    largest = {curve.value: _largest(curve) for curve in curves}
    worst = max(largest, key=lambda s: largest[s])
    ours = max(largest.values())
    return (
        f'The largest error is {ours:.1g} px, at s = {worst:g} px: the rounding of double '
        'precision, which leaves no more pattern than the single precision of the thesis.',
        [
            says(
                printed['order'], f's = {printed["order"].value} px', f's = {worst:g} px',
                worst == float(printed['order'].value),
            ),
            says(
                printed['small'], f'< {printed["small"].value} px', f'{ours:.1g} px',
                ours < float(printed['small'].value),
            ),
        ],
    )


def _figure_4_3(curves: list[Curve]) -> Look:
    """Look at sampled pulses along s."""
    statement = load('figure_4_3').statements['zero']
    ours = max(_largest(curve) for curve in curves)
    inside = max(
        float(np.abs(curve.error['gaussian_linear'][
            (curve.along >= 1.0) & (curve.along <= float(statement.value))
        ]).max()) for curve in curves
    )
    return (
        f'The largest error is {inside:.1g} px up to half of the window and {ours:.1g} px up to '
        's = 25 px: the same rise, in double precision.',
        [says(
            statement, f'zero, to 1e-9 px, up to s = {statement.value} px',
            f'{inside:.1g} px up to there, {ours:.1g} px in all', inside < 1e-9,
        )],
    )


def _figure_4_4(curves: list[Curve]) -> Look:
    """Look at rounded pulses along the displacement."""
    statement = load('figure_4_4').statements['limit']
    largest = {curve.value: _largest(curve) for curve in curves}
    within = [s for s, error in largest.items() if error <= GOAL]
    beyond = [error for s, error in largest.items() if s > 4.5]
    rms = [_rms(curve) for curve in curves]
    limits = [float(np.sqrt(np.mean(curve.bound**2))) for curve in curves]
    return (
        'The largest error is '
        + ', '.join(f'{error:.3f} px at s = {s:g} px' for s, error in largest.items())
        + f'; s = {", ".join(f"{s:g}" for s in within)} px stay within 0.05 px. The rms error is '
        + ', '.join(f'{error / limit:.1f}' for error, limit in zip(rms, limits))
        + ' times the bound.',
        [says(
            statement, f'> {statement.value} px at s = 15 px, and rising with s',
            ', '.join(f'{error:.3f}' for error in beyond) + ' px for s = 5 to 15 px',
            beyond[-1] > float(statement.value) and beyond == sorted(beyond),
        )],
    )


def _figure_4_5(curves: list[Curve]) -> Look:
    """Look at noisy pulses along the displacement."""
    statement = load('figure_4_5').statements['limit']
    largest = [_largest(curve) for curve in curves]
    ratios = [
        _rms(curve) / float(np.sqrt(np.mean(curve.bound**2))) for curve in curves
    ]
    return (
        'The rms error is ' + ', '.join(f'{_rms(curve):.3f}' for curve in curves)
        + ' px for s = 2, 3, 5, 7, 10 and 15 px, '
        + ', '.join(f'{ratio:.1f}' for ratio in ratios) + ' times the bound.',
        [says(
            statement, f'> {statement.value} px',
            'largest of 50 places ' + ', '.join(f'{value:.2f}' for value in largest) + ' px',
            max(largest) > float(statement.value),
        )],
    )


STUDIES = (
    study(
        Sweep(
            'figure_4_1', _METHODS, ONE, 'sampled', ('s', _WIDTHS), ('shift', _SHIFTS),
            ('window', 5.0),
        ),
        'Log-linear fit in 5 px along the displacement',
        'Without rounding the fit is exact.', partial(_sampled, 'figure_4_1'),
    ),
    study(
        Sweep(
            'figure_4_2', _METHODS, ONE, 'sampled', ('s', _WIDTHS), ('shift', _SHIFTS),
            ('window', 25.0),
        ),
        'Log-linear fit in 25 px along the displacement',
        'Without rounding the fit is exact, also for a pulse that is narrow in its window: pixels '
        'below half a DN are left out, which in single precision would underflow.',
        partial(_sampled, 'figure_4_2'),
    ),
    study(
        Sweep(
            'figure_4_3', _METHODS, ONE, 'sampled', ('shift', (0.1, 0.3, 0.5)),
            ('s', (0.9, *np.arange(1.0, 25.01, 0.25).tolist())), ('window', 15.0),
        ),
        'Log-linear fit in 15 px along s', 'Without rounding the fit is exact.', _figure_4_3,
    ),
    study(
        Sweep(
            'figure_4_4', _METHODS, ONE, 'rounded', ('s', _WIDTHS), ('shift', _SHIFTS),
            ('window', 9.0),
        ),
        'Log-linear fit to rounded pulses along the displacement',
        'Rounding moves the faint pixels of a narrow pulse and the flat top of a wide one.',
        _figure_4_4,
    ),
    study(
        Sweep(
            'figure_4_5', _METHODS, ONE, 'noisy', ('s', (2.0, 3.0, 5.0, 7.0, 10.0, 15.0)),
            ('shift', _SHIFTS), ('window', 9.0), (10, 200),
        ),
        'Log-linear fit to noisy pulses along the displacement',
        'Noise of 1 DN at a peak of 255 DN.', _figure_4_5,
    ),
)

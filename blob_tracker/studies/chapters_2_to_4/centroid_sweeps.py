"""Figures 3.1 to 3.7: the centroid of a row of pixels."""

from __future__ import annotations

from blob_tracker.location.skew import skew_error
from blob_tracker.studies.axes import GOAL
from blob_tracker.studies.chapters_2_to_4.row_sweeps import Curve, says, study, Sweep
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import ONE
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Check
import numpy as np

_SHIFTS = tuple(np.linspace(-0.5, 0.5, 51).round(2).tolist())
_WIDTHS = tuple(np.arange(0.5, 25.01, 0.25).tolist())
_WINDOWS = (3.0, 9.0, 19.0)  # px: those that the text gives for Figure 3.7
_SHIFT = 0.3  # px
Look = tuple[str, list[Check]]


def _largest(curve: Curve) -> float:
    """Return the largest error of a curve, px."""
    return float(np.nanmax(np.abs(curve.error['centroid'])))


def _apart(curves: list[Curve]) -> float:
    """Return by how much the centroid's error differs from the closed form, px."""
    return max(
        float(np.abs(
            curve.error['centroid']
            - skew_error(9, 4.0 + curve.along, curve.value / np.sqrt(2.0), sampled=True)
        ).max())
        for curve in curves
    )


def _figure_3_1(curves: list[Curve]) -> Look:
    """Look at the skew error of narrow pulses along the displacement."""
    printed = load('figure_3_1').statements
    largest = {curve.value: _largest(curve) for curve in curves}
    return (
        f'At most it is {largest[1.0]:.5f}, {largest[1.1]:.5f} and {largest[2.0]:.4f} px at '
        's = 1, 1.1 and 2 px.',
        [
            says(
                printed['s_2'], f'< {printed["s_2"].value} px', f'{largest[2.0]:.4f} px',
                largest[2.0] < float(printed['s_2'].value),
            ),
            says(
                printed['identity'], 'zero, to 1e-12 px', f'{_apart(curves):.1g} px',
                _apart(curves) < 1e-12,
            ),
        ],
    )


def _figure_3_2(curves: list[Curve]) -> Look:
    """Look at the skew error of wide pulses along the displacement."""
    printed = load('figure_3_2').statements
    largest = {curve.value: _largest(curve) for curve in curves}
    return (
        f'At most it is {largest[4.5]:.3f}, {largest[9.0]:.3f} and {largest[18.0]:.3f} px at '
        's = 4.5, 9 and 18 px.',
        [
            # 0.25 with an "about" before it: the last digit is worth 0.01.
            says(
                printed['s_4_5'], f'{printed["s_4_5"].value} px within 0.01 px',
                f'{largest[4.5]:.3f} px',
                abs(largest[4.5] - float(printed['s_4_5'].value)) <= 0.01,
            ),
            says(
                printed['s_18'], f'more than 90 % of {printed["s_18"].value} px, and not all',
                f'{largest[18.0]:.3f} px',
                0.9 < largest[18.0] / float(printed['s_18'].value) < 1.0,
            ),
        ],
    )


def _at(curve: Curve, s: float) -> float:
    """Return the error of a curve at an s, px."""
    return float(curve.error['centroid'][np.abs(curve.along - s).argmin()])


def _reach(curve: Curve) -> float:
    """Return the largest s up to which the error stays below the goal from s = 1 on, px."""
    beyond = (np.abs(curve.error['centroid']) > GOAL) & (curve.along >= 1.0)
    return float(curve.along[beyond.argmax() - 1]) if beyond.any() else float(curve.along[-1])


def _figure_3_3(curves: list[Curve]) -> Look:
    """Look at the skew error along s."""
    printed = load('figure_3_3').statements
    wide = [_at(curve, 25.0) for curve in curves]
    narrow = [abs(_at(curve, 1.0)) for curve in curves[1:]]
    # Half a window over the s up to which the error is small.
    seconds = [(curve.value / 2.0) / _reach(curve) for curve in curves[1:]]
    return (
        'The error at s = 25 px is ' + ', '.join(f'{value:.3f}' for value in wide)
        + ' px in windows of 3, 9 and 19 px; it stays below 0.05 px up to s = '
        + ' and '.join(f'{_reach(curve):g}' for curve in curves[1:]) + ' px in the latter two.',
        [
            says(
                printed['small'], '< 0.001 px at s = 1 px',
                f'{max(narrow):.5f} px (9 and 19 px)', max(narrow) < 0.001,
            ),
            says(
                printed['limit'], f'{printed["limit"].value} px within a tenth at s = 25 px',
                f'{-wide[0]:.3f}, {-wide[1]:.3f}, {-wide[2]:.3f} px',
                all(abs(-value / _SHIFT - 1.0) < 0.1 for value in wide),
            ),
            says(
                printed['rule'], f'<= {printed["rule"].value} s',
                ' and '.join(f'{value:.2f}' for value in seconds)
                + ' s of half a window where 0.05 px is reached (s is sqrt2 sigma)',
                all(value <= float(printed['rule'].value) for value in seconds),
            ),
        ],
    )


def _figure_3_4(curves: list[Curve]) -> Look:
    """Look at rounded pulses along the displacement."""
    printed = load('figure_3_4').statements
    odd = max(
        float(np.abs(curve.error['centroid'] + curve.error['centroid'][::-1]).max())
        for curve in curves
    )
    largest = [_largest(curve) for curve in curves]
    return (
        f'The largest error is {max(largest):.4f} px.',
        [
            says(printed['symmetric'], 'zero, to 1e-9 px', f'{odd:.1g} px', odd < 1e-9),
            says(
                printed['limit'], f'< {printed["limit"].value} px', f'{max(largest):.4f} px',
                max(largest) < float(printed['limit'].value),
            ),
        ],
    )


def _figure_3_5(curves: list[Curve]) -> Look:
    """Look at rounded pulses along s."""
    printed = load('figure_3_5').statements
    wide = [-_at(curve, 25.0) for curve in curves]
    return (
        'The error at s = 25 px is ' + ', '.join(f'{-value:.3f}' for value in wide) + ' px.',
        [says(
            printed['trend'], f'{printed["trend"].value} px within a tenth at s = 25 px',
            ', '.join(f'{value:.3f}' for value in wide) + ' px',
            all(abs(value / _SHIFT - 1.0) < 0.1 for value in wide),
        )],
    )


def _figure_3_6(curves: list[Curve]) -> Look:
    """Look at noisy pulses along the displacement."""
    printed = load('figure_3_6').statements
    largest = [_largest(curve) for curve in curves]
    rms = [float(np.sqrt(np.mean(curve.rms['centroid'] ** 2))) for curve in curves]
    limits = [float(np.sqrt(np.mean(curve.bound**2))) for curve in curves]
    return (
        'The rms error is ' + ', '.join(f'{value:.4f}' for value in rms)
        + ' px at s = 1, 1.1 and 2 px, '
        + ', '.join(f'{value / limit:.1f}' for value, limit in zip(rms, limits))
        + ' times the bound.',
        [says(
            printed['limit'], f'> {printed["limit"].value} px',
            'largest of 51 places ' + ', '.join(f'{value:.3f}' for value in largest) + ' px',
            max(largest) > float(printed['limit'].value),
        )],
    )


def _figure_3_7(curves: list[Curve]) -> Look:
    """Look at noisy pulses along s."""
    printed = load('figure_3_7').statements
    best = [float(np.nanmin(curve.rms['centroid'])) for curve in curves]
    where = [float(curve.along[np.nanargmin(curve.rms['centroid'])]) for curve in curves]
    return (
        'The least rms error is ' + ', '.join(
            f'{error:.4f} px at s = {s:g} px' for error, s in zip(best, where)
        ) + ' in windows of 3, 9 and 19 px.',
        [says(
            printed['limit'], f'< {printed["limit"].value} px in 9 and 19 px',
            ', '.join(f'{value:.4f}' for value in best) + ' px rms at best',
            all(value < float(printed['limit'].value) for value in best[1:]),
        )],
    )


STUDIES = (
    study(
        Sweep(
            'figure_3_1', ('centroid',), ONE, 'sampled', ('s', (1.0, 1.1, 2.0)),
            ('shift', _SHIFTS), ('window', 9.0),
        ),
        'Skew error of narrow pulses along the displacement',
        'The skew error of the centroid is small where the window holds the pulse.', _figure_3_1,
    ),
    study(
        Sweep(
            'figure_3_2', ('centroid',), ONE, 'sampled', ('s', (4.5, 9.0, 18.0)),
            ('shift', _SHIFTS), ('window', 9.0),
        ),
        'Skew error of wide pulses along the displacement',
        'The skew error of the centroid all but reaches the displacement where the pulse is wider '
        'than the window.', _figure_3_2,
    ),
    study(
        Sweep(
            'figure_3_3', ('centroid',), ONE, 'sampled', ('window', _WINDOWS), ('s', _WIDTHS),
            ('shift', _SHIFT),
        ),
        'Skew error along s', 'The skew error of the centroid at a displacement of 0.3 px.',
        _figure_3_3,
    ),
    study(
        Sweep(
            'figure_3_4', ('centroid',), ONE, 'rounded', ('s', (1.0, 1.1, 2.0)),
            ('shift', _SHIFTS), ('window', 25.0),
        ),
        'Centroid of rounded pulses along the displacement',
        'Rounding replaces the smooth skew error by steps, odd in the displacement.', _figure_3_4,
    ),
    study(
        Sweep(
            'figure_3_5', ('centroid',), ONE, 'rounded', ('window', _WINDOWS), ('s', _WIDTHS),
            ('shift', _SHIFT),
        ),
        'Centroid of rounded pulses along s', 'Rounding leaves the trend of Figure 3.3.',
        _figure_3_5,
    ),
    study(
        Sweep(
            'figure_3_6', ('centroid',), ONE, 'noisy', ('s', (1.0, 1.1, 2.0)),
            ('shift', _SHIFTS), ('window', 7.0), (200, 2000),
        ),
        'Centroid of noisy pulses along the displacement', 'Noise of 1 DN at a peak of 255 DN.',
        _figure_3_6,
    ),
    study(
        Sweep(
            'figure_3_7', ('centroid',), ONE, 'noisy', ('window', _WINDOWS),
            ('s', _WIDTHS[:-2]), ('shift', _SHIFT), (200, 2000),
        ),
        'Centroid of noisy pulses along s',
        'Between noise where the window is wide and skew where it is narrow lies a best s.',
        _figure_3_7,
    ),
)

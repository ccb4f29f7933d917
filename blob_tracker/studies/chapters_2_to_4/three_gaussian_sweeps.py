"""Figures 4.7 to 4.12: three Gaussians with one mean fitted to a row of pixels."""

from __future__ import annotations

from blob_tracker.studies.axes import GOAL
from blob_tracker.studies.chapters_2_to_4.row_sweeps import Curve, says, study, Sweep
from blob_tracker.studies.chapters_2_to_4.sampled_pulse import COARSE, THREE
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Check
import numpy as np

_SHIFTS = tuple(COARSE.tolist())
_WIDTHS = (1.0, 3.0, 5.0, 7.0, 10.0, 15.0)
_LONG = tuple(np.arange(0.5, 25.01, 0.5).tolist())
_DISPLACEMENTS = (-0.5, -0.3, -0.1, 0.1, 0.3)
_SIMPLEX, _LM = 'multi_gaussian_simplex', 'multi_gaussian_lm'
_METHODS = (_SIMPLEX, _LM)
_BIASED = (
    ' A fit that ends before the seven parameters are told apart may err less than the '
    'bound, which is for estimates without bias.'
)
Look = tuple[str, list[Check]]


def _largest(curve: Curve, method: str = _SIMPLEX) -> float:
    """Return the largest error of a curve, px."""
    return float(np.nanmax(np.abs(curve.error[method])))


def _middle(curves: list[Curve], method: str) -> float:
    """Return the median of the rms errors where both methods have one, px."""
    both = np.concatenate([np.isfinite(c.rms[_SIMPLEX] + c.rms[_LM]) for c in curves])
    return float(np.median(np.concatenate([curve.rms[method] for curve in curves])[both]))


def _listed(curves: list[Curve], digits: int = 3) -> str:
    """Return the largest errors of the curves."""
    return ', '.join(f'{_largest(c):.{digits}f} px at s = {c.value:g}' for c in curves)


def _figure_4_7(curves: list[Curve]) -> Look:
    """Look at sampled pulses along the displacement."""
    statement = load('figure_4_7').statements['ends']
    order = sorted(curves, key=_largest, reverse=True)
    ends = sum(curve.value in (1.0, 15.0) for curve in order[:2])
    return (
        f'The largest error is {_listed(curves, 5)}; in the middle it is '
        f'{_middle(curves, _SIMPLEX):.1g} px, and {_middle(curves, _LM):.1g} px by '
        'Levenberg-Marquardt.',
        [says(
            statement, f'{statement.value} of the two largest',
            f'{ends}: the largest are at s = {order[0].value:g} and {order[1].value:g} px',
            ends == int(statement.value),
        )],
    )


def _figure_4_8(curves: list[Curve]) -> Look:
    """Look at sampled pulses along s."""
    printed = load('figure_4_8').statements
    simplex = np.concatenate([np.abs(curve.error[_SIMPLEX]) for curve in curves])
    other = np.concatenate([np.abs(curve.error[_LM]) for curve in curves])
    both = np.isfinite(simplex + other)
    orders = float(np.median(
        np.log10(np.maximum(simplex[both], 1e-16) / np.maximum(other[both], 1e-16))
    ))
    filled = max(
        float(np.nanmax(np.abs(curve.error[_SIMPLEX][curve.along >= 1.0]))) for curve in curves
    )
    return (
        f'By the simplex the error from s = 1 px on is {filled:.4f} px at most; that of '
        f'Levenberg-Marquardt is smaller by {orders:.1f} orders of magnitude in the middle.',
        [
            says(
                printed['orders'], f'>= {printed["orders"].value} in the middle',
                f'{orders:.1f}', orders >= float(printed['orders'].value),
            ),
            says(
                printed['fills'], f'< {printed["fills"].value} px from s = 1 px on',
                f'{filled:.4f} px', filled < float(printed['fills'].value),
            ),
        ],
    )


def _figure_4_9(curves: list[Curve]) -> Look:
    """Look at rounded pulses along the displacement."""
    statement = load('figure_4_9').statements['limit']
    within = [f'{curve.value:g}' for curve in curves if _largest(curve) <= GOAL]
    return (
        f'The largest error is {_listed(curves)}; in the middle of all it is '
        f'{_middle(curves, _SIMPLEX):.4f} px by the simplex and {_middle(curves, _LM):.4f} px by '
        'Levenberg-Marquardt.',
        [says(
            statement, f's = 1 px alone within {statement.value} px',
            f's = {", ".join(within)} px', within == ['1'],
        )],
    )


def _figure_4_10(curves: list[Curve]) -> Look:
    """Look at rounded pulses along s."""
    printed = load('figure_4_10').statements
    along = curves[0].along
    worst = np.nanmax([np.abs(curve.error[_SIMPLEX]) for curve in curves], axis=0)
    narrow, three = float(worst[0]), float(worst[np.abs(along - 3.0).argmin()])
    beyond = worst[along > 5.0]
    limit = float(printed['wide'].value)
    return (
        f'Of five displacements the largest error is {narrow:.3f} px at s = 0.5 px and '
        f'{three:.4f} px at s = 3 px; beyond s = 5 px it is {beyond.min():.3f} to '
        f'{beyond.max():.3f} px.',
        [
            says(
                printed['narrow'], f'falls, to < {printed["narrow"].value} px at s = 3 px',
                f'{narrow:.3f} px, then {three:.4f} px',
                three < float(printed['narrow'].value) and three < narrow,
            ),
            says(
                printed['wide'], f'> {printed["wide"].value} px at every s',
                f'at {(beyond > limit).sum()} of {beyond.size} s',
                bool((beyond > limit).all()),
            ),
        ],
    )


def _figure_4_11(curves: list[Curve]) -> Look:
    """Look at noisy pulses along the displacement."""
    statement = load('figure_4_11').statements['limit']
    return (
        f'The largest error is {_listed(curves)}.',
        [says(
            statement, f'> {statement.value} px',
            f'{max(map(_largest, curves)):.2f} px at most',
            max(map(_largest, curves)) > float(statement.value),
        )],
    )


def _figure_4_12(curves: list[Curve]) -> Look:
    """Look at noisy pulses along s."""
    statement = load('figure_4_12').statements['less']
    ratio = _middle(curves, _LM) / _middle(curves, _SIMPLEX)
    return (
        f'In the middle of all places the rms error is {_middle(curves, _SIMPLEX):.4f} px by the '
        f'simplex and {_middle(curves, _LM):.4f} px by Levenberg-Marquardt.',
        [says(
            statement, f'< {statement.value} in the middle', f'{ratio:.3f}',
            ratio < float(statement.value),
        )],
    )


STUDIES = (
    study(
        Sweep(
            'figure_4_7', _METHODS, THREE, 'sampled', ('s', _WIDTHS), ('shift', _SHIFTS),
            ('window', 9.0),
        ),
        'Three-Gaussian fit along the displacement',
        'The simplex ends where its values are close; the true parameters are not given to it.',
        _figure_4_7,
    ),
    study(
        Sweep(
            'figure_4_8', _METHODS, THREE, 'sampled', ('shift', _DISPLACEMENTS), ('s', _LONG),
            ('window', 9.0),
        ),
        'Three-Gaussian fit along s', 'Without rounding the fit has only its own end to err by.',
        _figure_4_8, 3,
    ),
    study(
        Sweep(
            'figure_4_9', _METHODS, THREE, 'rounded', ('s', _WIDTHS), ('shift', _SHIFTS),
            ('window', 7.0),
        ),
        'Three-Gaussian fit to rounded pulses along the displacement',
        'Seven parameters from seven pixels: the fit follows the rounding.' + _BIASED,
        _figure_4_9,
    ),
    study(
        Sweep(
            'figure_4_10', _METHODS, THREE, 'rounded', ('shift', _DISPLACEMENTS), ('s', _LONG),
            ('window', 7.0),
        ),
        'Three-Gaussian fit to rounded pulses along s',
        'Seven parameters from seven pixels: the fit follows the rounding.' + _BIASED,
        _figure_4_10, 3,
    ),
    study(
        Sweep(
            'figure_4_11', _METHODS, THREE, 'noisy', ('s', (2.0, *_WIDTHS[1:])),
            ('shift', _SHIFTS), ('window', 7.0), (2, 20),
        ),
        'Three-Gaussian fit to noisy pulses along the displacement',
        'Noise of 1 DN at a peak of 254 DN.' + _BIASED, _figure_4_11,
    ),
    study(
        Sweep(
            'figure_4_12', _METHODS, THREE, 'noisy', ('shift', (*_DISPLACEMENTS, 0.5)),
            ('s', _LONG[:-1]), ('window', 7.0), (8, 12),
        ),
        'Three-Gaussian fit to noisy pulses along s',
        'Noise of 1 DN at a peak of 254 DN.' + _BIASED,
        _figure_4_12, 7,
    ),
)

"""Residuals on real pixels to catalogue and grid, and what of them follows the pixel phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import os
from pathlib import Path

from benchmarks import dots, stars
from benchmarks.accuracy import Tick
from benchmarks.contender import Contender, Covariances, inside, SLOW
from benchmarks.field import Field, Residuals, residuals
from benchmarks.ours import CHAMPION, estimate
from benchmarks.windows import Positions, Windows
from blob_tracker.location import (
    correct_phase, EffectivePsf, Estimates, learn_phase_correction, learn_pulse,
)
import numpy as np
from numpy.typing import NDArray

VARIABLE = 'BLOB_TRACKER_DATA'
BINS = 10
MANY = 150  # windows of a field that a pulse is learned from
FEW = 300  # many times the unknowns of the maps
BRIGHT = (20.0, 40.0)  # peak SNR above which it is less and less the noise that limits
CORRECTED = f'{CHAMPION} + phase correction'
LEARNED = f'{CHAMPION} + learned pulse'


@dataclass(frozen=True)
class Row:
    """
    One contender on one kind of frame, all frames of it together.

    Parameters
    ----------
    kind, contender : str
        Stars or dots; name.
    rms : float
        Residual to the map, px, x and y together, every frame with a map of its own.
    found, total : int
        Blobs within four standard deviations of the map, and all.
    harmonic : float
        Amplitude of the residual's first harmonic in the sub-pixel phase, px: the larger of
        x and y.
    phase_rms : float
        Rms over the phase of the residual's mean at a phase, its own noise taken off, px.
    phase, mean : list
        Middle of each bin and mean residual in it, x and y together, px.
    nees : float
        Mean square of the residuals over their covariances, 2 where these are true; NaN where
        there are none.

    """

    kind: str
    contender: str
    rms: float
    found: int
    total: int
    harmonic: float
    phase_rms: float
    phase: list[float]
    mean: list[float]
    nees: float = np.nan


def data_folder() -> Path | None:
    """Return the folder that BLOB_TRACKER_DATA names, or None if it is not set."""
    name = os.environ.get(VARIABLE)
    if not name:
        return None
    folder = Path(name)
    if not folder.is_dir():
        raise FileNotFoundError(f'{VARIABLE} is {name}, which is not a folder')
    return folder


def run(contenders: Sequence[Contender], data: Path, tick: Tick) -> list[Row]:
    """Return the rows of stars and dots; all contenders get the same blobs."""
    rows: list[Row] = []
    for kind, load in (('stars', stars.fields), ('dots', dots.fields)):
        tick(f'real {kind}')
        fields = load(data)
        left: dict[str, list[Residuals]] = {}
        covariances: dict[str, list[Covariances]] = {}
        for each in contenders:
            left[each.name] = [_residuals(field, each) for field in fields]
            if each.name == CHAMPION:
                found = {CHAMPION: [estimate(field.windows, CHAMPION) for field in fields]}
                if len(fields) > 1:
                    found[CORRECTED] = phase_corrected(fields)
                found[LEARNED] = learned(fields)
                for name, estimates in found.items():
                    left[name] = [
                        residuals(field, _positions(field, one))
                        for field, one in zip(fields, estimates)
                    ]
                    covariances[name] = [one.covariance for one in estimates]
        snr = np.concatenate([field.snr for field in fields])
        rows += [
            _row(kind, name, each, snr > 0, covariances.get(name)) for name, each in left.items()
        ]
        for least in BRIGHT if (snr < BRIGHT[-1]).any() else ():
            bright = f'{kind}, SNR {least:.0f} or more'
            rows += [
                _row(bright, name, each, snr >= least, covariances.get(name))
                for name, each in left.items()
            ]
    return rows


def phase_corrected(fields: Sequence[Field]) -> list[Estimates]:
    """
    Return what the default method finds in each field, the phase correction applied.

    What is applied to a field is learned from the positions located in the other fields; no
    catalogue comes in, nor any star that is judged.
    """
    found = [estimate(field.windows, CHAMPION) for field in fields]
    corrected = []
    for mine in found:
        others = [each for each in found if each is not mine]
        x = np.concatenate([each.x[each.ok] for each in others])
        y = np.concatenate([each.y[each.ok] for each in others])
        corrected.append(correct_phase(mine, learn_phase_correction(x, y)))
    return corrected


def learned(fields: Sequence[Field]) -> list[Estimates]:
    """
    Return what is found in each field with a pulse that was learned in the others.

    A field that is alone is judged by halves, each with the pulse of the other one. Where phases
    can be corrected, they are, by the positions with that pulse in the other fields.
    """
    if len(fields) == 1:
        return [_by_halves(fields[0].windows)]
    out = []
    for mine in fields:
        others = [each.windows for each in fields if each is not mine]
        pulse = _pulse(others)
        seen = [estimate(each, CHAMPION, pulse=pulse) for each in others]
        correction = learn_phase_correction(
            np.concatenate([each.x[each.ok] for each in seen]),
            np.concatenate([each.y[each.ok] for each in seen]),
        )
        out.append(correct_phase(estimate(mine.windows, CHAMPION, pulse=pulse), correction))
    return out


def _by_halves(windows: Windows) -> Estimates:
    """Return what is found in each half of the windows with the pulse of the other."""
    halves = [replace(windows, lit=windows.lit[half::2]) for half in range(2)]
    found = [
        estimate(mine, CHAMPION, pulse=_pulse([other]))
        for mine, other in zip(halves, halves[::-1])
    ]
    whole = estimate(windows, CHAMPION)
    for half, part in enumerate(found):
        for name in ('x', 'y', 'covariance', 'failure'):
            getattr(whole, name)[half::2] = getattr(part, name)
    return whole


def _pulse(windows: Sequence[Windows]) -> EffectivePsf:
    """Return the pulse of these windows."""
    stacks = [
        (each.lit[np.linspace(0, len(each.lit) - 1, min(len(each.lit), MANY)).astype(int)], None)
        for each in windows
    ]
    first = windows[0]
    # Stars differ in size with their colour, dots with the lens.
    return learn_pulse(
        stacks, noise=first.noise, saturation=first.saturation, varies=True
    ).pulse


def _positions(field: Field, found: Estimates) -> Positions:
    positions = np.where(found.ok, found.x, np.nan), np.where(found.ok, found.y, np.nan)
    return inside(positions, field.windows.lit.shape[1:])


def _row(
    kind: str, name: str, left: Sequence[Residuals], chosen: NDArray[np.bool_],
    covariances: Sequence[Covariances] | None = None,
) -> Row:
    """Return the figures of the chosen blobs of all fields together."""
    errors = [np.concatenate([getattr(each, axis) for each in left]) for axis in 'xy']
    phases = [np.concatenate([getattr(each, f'phase_{axis}') for each in left]) for axis in 'xy']
    freedom = np.concatenate([np.full(len(each.x), each.freedom) for each in left])
    kept = chosen & np.isfinite(errors[0])
    errors, phases = [error[kept] for error in errors], [phase[kept] for phase in phases]
    harmonics = [_first_harmonic(phase, error) for phase, error in zip(phases, errors)]
    both = np.concatenate(errors)
    if not len(both):
        return Row(kind, name, np.nan, 0, int(chosen.sum()), np.nan, np.nan, [], [])
    middles, mean, noise = _against_phase(np.concatenate(phases), both)
    return Row(
        kind,
        name,
        float(np.sqrt(np.mean((both * np.tile(freedom[kept], 2)) ** 2))),
        int(kept.sum()),
        int(chosen.sum()),
        max(harmonics),
        float(np.sqrt(np.maximum(np.mean(mean**2 - noise**2), 0.0))),
        middles.tolist(),
        mean.tolist(),
        _nees(errors, freedom[kept], covariances, kept),
    )


def _nees(
    errors: Sequence[NDArray[np.float64]], freedom: NDArray[np.float64],
    covariances: Sequence[Covariances] | None, kept: NDArray[np.bool_],
) -> float:
    """Return the mean square of the errors over their covariances."""
    if covariances is None:
        return float(np.nan)
    inverse = np.linalg.inv(np.concatenate(covariances)[kept])
    both = np.stack(errors, axis=1) * freedom[:, None]
    return float(np.einsum('ni,nij,nj->n', both, inverse, both).mean())


def _residuals(field: Field, contender: Contender) -> Residuals:
    """Return the residuals; a slow contender locates only FEW blobs spread over the field."""
    windows = field.windows
    count = len(windows.lit)
    few = min(count, FEW) if contender.share < SLOW else count
    chosen = np.unique(np.linspace(0, count - 1, few).astype(int))
    located = np.full((2, count), np.nan)
    located[:, chosen] = inside(
        contender.locate(replace(windows, lit=windows.lit[chosen])), windows.lit.shape[1:]
    )
    return residuals(field, (located[0], located[1]))


def _against_phase(
    phase: NDArray[np.float64], error: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the bins' middles, the mean error in each and that mean's standard error, px."""
    edges = np.linspace(-0.5, 0.5, BINS + 1)
    place = np.clip(np.digitize(phase, edges) - 1, 0, BINS - 1)
    groups = [error[place == index] for index in range(BINS)]
    filled = np.array([len(group) > 1 for group in groups])
    groups = [group for group in groups if len(group) > 1]
    mean = np.array([group.mean() for group in groups])
    noise = np.array([group.std() / np.sqrt(len(group)) for group in groups])
    return ((edges[1:] + edges[:-1]) / 2)[filled], mean, noise


def _first_harmonic(phase: NDArray[np.float64], error: NDArray[np.float64]) -> float:
    """Return the amplitude of a sin + b cos of 2 pi phase, px, by least squares."""
    turn = 2 * np.pi * phase
    terms = np.stack([np.sin(turn), np.cos(turn), np.ones(len(turn))], axis=1)
    return float(np.hypot(*np.linalg.lstsq(terms, error, rcond=None)[0][:2]))

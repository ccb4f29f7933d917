"""Residuals on real pixels to catalogue and grid, and what of them follows the pixel phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import os
from pathlib import Path

from benchmarks import dots, stars
from benchmarks.accuracy import Tick
from benchmarks.contender import Contender, inside, SLOW
from benchmarks.field import Field, Residuals, residuals
from benchmarks.ours import CHAMPION, estimate
from benchmarks.windows import Positions
from blob_tracker.location import correct_phase, learn_phase_correction
import numpy as np
from numpy.typing import NDArray

VARIABLE = 'BLOB_TRACKER_DATA'
BINS = 10
FEW = 300  # many times the unknowns of the maps
BRIGHT = (20.0, 40.0)  # peak SNR above which it is less and less the noise that limits
CORRECTED = f'{CHAMPION} + phase correction'


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


def data_folder() -> Path | None:
    """Return the folder that BLOB_TRACKER_DATA names, or None where it is not set."""
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
        for each in contenders:
            left[each.name] = [_residuals(field, each) for field in fields]
            if each.name == CHAMPION and len(fields) > 1:
                places = zip(fields, phase_corrected(fields))
                left[CORRECTED] = [residuals(field, place) for field, place in places]
        snr = np.concatenate([field.snr for field in fields])
        rows += [_row(kind, name, each, snr > 0) for name, each in left.items()]
        for least in BRIGHT if (snr < BRIGHT[-1]).any() else ():
            bright = f'{kind}, SNR {least:.0f} or more'
            rows += [_row(bright, name, each, snr >= least) for name, each in left.items()]
    return rows


def phase_corrected(fields: Sequence[Field]) -> list[Positions]:
    """
    Return each field's positions by the default method, the phase correction applied.

    What is applied to a field is learned from the positions located in the other fields; no
    catalogue comes in, nor any star that is judged.
    """
    found = [estimate(field.windows, CHAMPION) for field in fields]
    corrected = []
    for index, mine in enumerate(found):
        others = [each for each in found if each is not mine]
        x = np.concatenate([each.x[each.ok] for each in others])
        y = np.concatenate([each.y[each.ok] for each in others])
        moved = correct_phase(mine, learn_phase_correction(x, y))
        positions = np.where(moved.ok, moved.x, np.nan), np.where(moved.ok, moved.y, np.nan)
        corrected.append(inside(positions, fields[index].windows.lit.shape[1:]))
    return corrected


def _row(kind: str, name: str, left: Sequence[Residuals], chosen: NDArray[np.bool_]) -> Row:
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
    )


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

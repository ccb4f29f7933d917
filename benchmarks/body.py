"""Places of a body's lights, as `calibrate body` finds them: beside their stated covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

from benchmarks.accuracy import Tick
from benchmarks.limit import Limit, worst
from blob_tracker.calibration.body import calibrate_body
from blob_tracker.calibration.body_start import BodyCalibrationError
from blob_tracker.calibration.rays import Rays
from blob_tracker.simulation.turned_body import places_error, TurnedBody
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PLACES = np.array([
    [0.2, 0.15, 0.0], [0.2, -0.15, 0.02], [-0.25, 0.1, 0.1], [0.0, 0.0, 0.2], [-0.2, -0.1, -0.05],
])
SECONDS = 10.0
LENGTH_SIGMA = 1e-4  # m, of the distance that is given
SHARE = 20  # of the sights of `pose`, a draw here is one in so many


@dataclass(frozen=True)
class Case:
    """So many lights, each with stamps of its own or all at once, lit for a share of the time."""

    lights: int
    at_once: bool = False
    lit: float = 1.0

    @property
    def name(self) -> str:
        """Say it in words."""
        return (
            f'{self.lights} lights, {"at once" if self.at_once else "each its stamps"}'
            f'{f", lit {100.0 * self.lit:.0f} %" if self.lit < 1.0 else ""}'
        )


@dataclass(frozen=True)
class Row:
    """
    Draws of one case.

    Parameters
    ----------
    case : Case
        What was given.
    rms_mm, sigma_mm : float
        rms error of a place along an axis, and what is stated, mm.
    nees : float
        Squared error over the covariance, per number that is determined.
    refused : int
        Draws that gave none.
    seconds : float
        Time of a calibration, median.
    count : int
        Draws.

    """

    case: Case
    rms_mm: float
    sigma_mm: float
    nees: float
    refused: int
    seconds: float
    count: int


def cases() -> list[Case]:
    """Return all that is measured."""
    return [Case(4, at_once=True), Case(5), Case(5, lit=0.6)]


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(cases())


def run(count: int, tick: Tick) -> list[Row]:
    """Return a row for each case, from a draw for each 20 sights."""
    rows = []
    for case in cases():
        tick(f'body {case.name}')
        rows.append(_row(case, max(count // SHARE, 2)))
    return rows


def limits(rows: Sequence[Row]) -> list[Limit]:
    """Return each target, see `worst`."""
    return [
        worst('body: NEES per number, greatest', 1.2, rows, lambda row: row.nees),
        worst('body: NEES per number, least', 0.8, rows, lambda row: row.nees, True),
    ]


def _row(case: Case, count: int) -> Row:
    """Return what comes of so many draws of a case."""
    places = PLACES[:case.lights]
    names = tuple(f'light{number}' for number in range(case.lights))
    length = float(np.linalg.norm(places[0] - places[1]))
    squares, errors, sigmas, times = [], [], [], []
    for seed in range(count):
        rng = np.random.default_rng(3000 + seed)
        seen = TurnedBody(places).seen(
            rng, seconds=SECONDS, at_once=case.at_once, lit=case.lit)
        known = length + LENGTH_SIGMA * rng.standard_normal()
        begin = perf_counter()
        try:
            result = calibrate_body(
                [Rays(*each) for each in seen], names,
                distance=(names[0], names[1], known, LENGTH_SIGMA),
            )
        except BodyCalibrationError:
            continue
        times.append(perf_counter() - begin)
        squared, degrees, rms = places_error(
            result.places, result.covariance, result.size_sigma, places)
        squares.append(squared / degrees)
        errors.append(rms)
        beside = result.size_sigma * (result.places - result.places.mean(axis=0)).ravel()
        sigmas.append(np.sqrt(np.mean(result.covariance.diagonal() + beside**2)))
    if not squares:
        return Row(case, np.nan, np.nan, np.nan, count, np.nan, count)
    return Row(
        case, 1e3 * float(np.sqrt(np.mean(np.square(errors)))), 1e3 * float(np.mean(sigmas)),
        float(np.mean(squares)), count - len(squares), float(np.median(times)), count,
    )

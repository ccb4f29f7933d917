"""Places and pulse of the same windows in turn, each by the other, until they settle."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, fields, replace
import math
from typing import TypeVar

from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.learned_pulse import learned_pulse, pulse_of
from blob_tracker.location.pulse_surface import centre_of, Equations, Grid, STEP
from blob_tracker.types import LocationError, SensorNoise
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Stack = tuple[Floats, 'Floats | None']
Result = TypeVar('Result')
Slices = Generator[None, None, Result]  # of work, after each of which something else may be done

LEAST_WINDOWS = 100
LEAST_SNR = 8.0  # of the peak: below it the place is too uncertain to learn a shape from
SLICE = 4096  # pixels that are fitted at a time: half a millisecond
ROUNDS = 8  # of places and pulse in turn
SETTLED = 3e-4  # px that places move from round to round at the end: no pulse is placed so well
OUTLIER = 4.0  # times the median chi2: another light is in the window
SURE = 9.0  # variances: the square of what even phases have once in 400 times


@dataclass(frozen=True)
class Places:
    """Where the blobs of a stack are: (N,) arrays."""

    x: Floats
    y: Floats
    amplitude: Floats
    background: Floats
    scale: Floats
    used: NDArray[np.bool_]
    chi2: Floats

    def of(self, chosen: NDArray[np.int64]) -> Places:
        """Return those of some windows."""
        return Places(*(getattr(self, each.name)[chosen] for each in fields(self)))


@dataclass(frozen=True)
class Task:
    """The windows and all that does not change while a pulse is learned from them."""

    stacks: Sequence[Stack]
    noise: SensorNoise
    saturation: float | None
    grid: Grid

    def surface(
        self, places: Sequence[Places], roughness: float
    ) -> Slices[tuple[EffectivePsf, float]]:
        """Return the pulse of these places, and its roughness."""
        equations = Equations(self.grid)
        shot, floor = 1.0 / self.noise.gain, self.noise.read_noise**2 + 1.0 / 12.0
        limit = math.inf if self.saturation is None else self.saturation
        for (lit, unlit), at in zip(self.stacks, places):
            told = np.stack([at.x, at.y, at.amplitude, at.background, at.scale])
            for part in slices_of(lit):
                chosen = np.flatnonzero(at.used[part]) + part.start
                equations.add(
                    lit[chosen], None if unlit is None else unlit[chosen],
                    np.ascontiguousarray(told[:, chosen]), shot, floor, limit,
                )
                yield
        return equations.pulse(roughness)

    def fit(self, pulse: EffectivePsf, varies: bool) -> Slices[list[tuple[Places, Floats]]]:
        """Return the places by a pulse, with their SNR."""
        told = pulse_of(pulse, varies)
        found = []
        for lit, unlit in self.stacks:
            parts = []
            for part in slices_of(lit):
                parts.append(learned_pulse(
                    lit[part], None if unlit is None else unlit[part], self.noise,
                    self.saturation, told,
                )[0])
                yield
            places, snr = joined(parts)
            scale = np.where(places.used, places.scale / pulse.sigma, 1.0)
            found.append((replace(places, scale=scale), snr))
        return found

    def of(self, chosen: Sequence[NDArray[np.int64]]) -> Task:
        """Return that of some windows."""
        return replace(self, stacks=[
            (lit[which], None if unlit is None else unlit[which])
            for (lit, unlit), which in zip(self.stacks, chosen)
        ])


def alternate(
    task: Task, start: Sequence[Places], varies: bool
) -> Slices[tuple[EffectivePsf, list[Places]]]:
    """Return the pulse and the places after both in turn, until the places settle."""
    places = list(start)
    roughness = 0.0
    for _ in range(ROUNDS):
        pulse, roughness = yield from task.surface(places, roughness)
        found = yield from task.fit(pulse, varies)
        chi2 = np.concatenate([each.chi2[each.used] for each, _ in found])
        if chi2.size < LEAST_WINDOWS // 2:
            raise LocationError('the windows do not show one pulse: most of them fit none')
        limit = OUTLIER * float(np.median(chi2))
        last, places = places, [
            replace(each, used=each.used & (each.chi2 < limit) & (snr > LEAST_SNR))
            for each, snr in found
        ]
        scales = np.concatenate([each.scale[each.used] for each in places])
        usual = float(np.exp(np.median(np.log(scales))))
        places = _centred(
            [replace(each, scale=each.scale / usual) for each in places], centre_of(pulse)
        )
        if task.grid.step < STEP:
            places = _evenly(places)
        yield
        if _moved(last, places) < SETTLED:
            break
    pulse, _ = yield from task.surface(places, roughness)
    places = _centred(places, centre_of(pulse))
    pulse, _ = yield from task.surface(places, roughness)
    return replace(pulse, varies=varies), places


def _moved(before: Sequence[Places], after: Sequence[Places]) -> float:
    """Return the rms by which places moved against each other, px."""
    moves = np.concatenate([
        np.stack([one.x - other.x, one.y - other.y])[:, one.used & other.used]
        for one, other in zip(after, before)
    ], axis=1)
    return float(np.sqrt(moves.var(axis=1).sum() / 2.0)) if moves.size else math.inf


def _centred(places: Sequence[Places], centre: tuple[float, float]) -> list[Places]:
    """Return the places from the centre of the pulse that they were had with."""
    return [
        replace(at, x=at.x + centre[0] * at.scale, y=at.y + centre[1] * at.scale)
        for at in places
    ]


def _evenly(places: Sequence[Places]) -> list[Places]:
    """
    Take off the places what follows the sub-pixel phase, by its first harmonic.

    Places that all err by one function of their phase make a pulse under which the windows are
    as likely: an undersampled pulse cannot tell. The phases can, which are even where the target
    moves far enough: `learn_phase_correction`. A round pulse errs by one a sin along x and y;
    what the axes differ by, and the cosines of a lopsided one, are taken off only as far as even
    phases do not have them by chance.
    """
    turns = [
        2.0 * np.pi * np.concatenate([getattr(at, axis)[at.used] for at in places])
        for axis in 'xy'
    ]
    count = turns[0].size
    across, down = (2.0 * float(np.cos(turn).mean()) for turn in turns)
    common = _beyond(0.5 * (across + down), 1.0 / count)
    apart = _beyond(0.5 * (across - down), SURE / count)
    moved = []
    for axis, turn, a in zip('xy', turns, (common + apart, common - apart)):
        b = _beyond(2.0 * float(np.sin(turn).mean()), 2.0 * SURE / count)
        moved.append([
            getattr(at, axis) + (
                a * np.sin(2.0 * np.pi * getattr(at, axis))
                - b * np.cos(2.0 * np.pi * getattr(at, axis))
            ) / (2.0 * np.pi)
            for at in places
        ])
    return [replace(at, x=x, y=y) for at, x, y in zip(places, *moved)]


def _beyond(value: float, square: float) -> float:
    """Return what a value has beyond a square that is noise (James and Stein, 1961)."""
    return value * max(0.0, 1.0 - square / max(value * value, 1e-12))


def slices_of(lit: Floats) -> list[slice]:
    """Return the windows that are fitted at a time."""
    each = max(SLICE // (lit.shape[1] * lit.shape[2]), 1)
    return [slice(k, k + each) for k in range(0, len(lit), each)]


def joined(parts: Sequence[Estimates]) -> tuple[Places, Floats]:
    """Return the places of the windows of a stack, those used that have one, and their SNR."""
    x, y, amplitude, background, sigma, ok, chi2, snr = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ('x', 'y', 'amplitude', 'background', 'sigma', 'ok', 'chi2', 'snr')
    )
    return Places(x, y, amplitude, background, np.where(ok, sigma, 1.0), ok, chi2), snr

"""Learn the pulse of a light from windows of it in all sub-pixel phases."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, fields, replace
import math
from typing import TypeVar

from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.learned_pulse import learned_pulse, pulse_of
from blob_tracker.location.maximum_likelihood import fit_gaussians
from blob_tracker.location.moments import moments
from blob_tracker.location.pulse import integrated_profile
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
WIDEST_GAP = 0.2  # px of the pixel in which no window's centre lies, along x or y
MOST_NODES = 81  # along an axis: a wider pulse gets a coarser grid
SLICE = 4096  # pixels that are fitted at a time: half a millisecond
ROUNDS = 8  # of places and pulse in turn
SETTLED = 3e-4  # px that places move from round to round at the end: no pulse is placed so well
OUTLIER = 4.0  # times the median chi2: another light is in the window
FITTED = 0.8  # of the windows, that a Gaussian must fit to be started from
HOPELESS = 1e3  # chi2 of a Gaussian where there is none that fits
SURE = 9.0  # variances: the square of what even phases have once in 400 times
STEADY = 3.0  # chi-square a window that scales of their own take off where the sizes do vary


@dataclass(frozen=True)
class Learned:
    """
    A pulse, and what it was learned from.

    Parameters
    ----------
    pulse : EffectivePsf
        The pulse.
    windows : int
        That were used.
    gap : float
        The widest part of a pixel without a window's centre, along x or y, px.
    gain : float
        How much likelier the pulse makes windows than a Gaussian does: half the difference of
        their chi-squares a window, each judged by a pulse that was learned from the others.
    chi2 : float
        Median of the windows' fits, per degree of freedom.
    noise : SensorNoise
        That it was learned with.

    """

    pulse: EffectivePsf
    windows: int
    gap: float
    gain: float
    chi2: float
    noise: SensorNoise

    @property
    def better(self) -> bool:
        """Whether the pulse fits windows better from which it was not learned."""
        return self.gain > 0.0


@dataclass(frozen=True)
class _Places:
    """Where the blobs of a stack are: (N,) arrays."""

    x: Floats
    y: Floats
    amplitude: Floats
    background: Floats
    scale: Floats
    used: NDArray[np.bool_]
    chi2: Floats

    def of(self, chosen: NDArray[np.int64]) -> _Places:
        """Return those of some windows."""
        return _Places(*(getattr(self, each.name)[chosen] for each in fields(self)))


def learn_pulse(
    stacks: Sequence[Stack],
    *,
    noise: SensorNoise,
    saturation: float | None = None,
    varies: bool | None = None,
) -> Learned:
    r"""
    Learn the effective PSF of a light from N windows, without their true places.

    In turn, the windows are placed with the pulse by maximum likelihood, and the pulse is the
    surface that fits all of them best at those places,

        sum_nk (d_nk - A_n P((k - x_n) / s_n))^2 / V_nk + lambda |D c|^2 -> min

    with d the pixels above the background (lit - unlit where there is an unlit window), D the
    third differences along either axis of what the coefficients depart from those of the nearest
    Gaussian by, and 1 / lambda their mean square, so that they are smoothed as far as the noise
    of the windows asks for and no further. The phases of an undersampled pulse are held even, as
    `learn_phase_correction` does. The centre is the point about which the pulse is most
    symmetric, so that it stays where it is as the pulse grows. The error that is left is had from
    two halves of the windows: of the places by the one and by the other.

    Parameters
    ----------
    stacks : sequence of (lit, unlit)
        (N, h, w) windows of one size each, DN; unlit may be None.
    noise : SensorNoise
        Of a pixel.
    saturation : float or None
        DN of a clipped pixel.
    varies : bool or None
        Whether the blob's size may vary; found from the windows where left out.

    Returns
    -------
    Learned
        The pulse and how it was had.

    Raises
    ------
    LocationError
        Where there are too few windows, or too few phases among them.

    References
    ----------
    Anderson and King, PASP 112 (2000) 1360. Eilers and Marx, Flexible smoothing with B-splines
    and penalties, Statistical Science 11 (1996).

    """
    slices = learning(stacks, noise=noise, saturation=saturation, varies=varies)
    while True:
        try:
            next(slices)
        except StopIteration as done:
            learned: Learned = done.value
            return learned


def learning(
    stacks: Sequence[Stack],
    *,
    noise: SensorNoise,
    saturation: float | None = None,
    varies: bool | None = None,
    most_nodes: int = MOST_NODES,
) -> Slices[Learned]:
    """
    Do what `learn_pulse` does, in slices of half a millisecond or so.

    Parameters
    ----------
    stacks, noise, saturation, varies
        As those of `learn_pulse`.
    most_nodes : int
        Of the surface along an axis. Its equations are solved in one slice, whose time goes with
        the fourth power: 2 ms for 41, 40 ms for 81.

    """
    clean, level, limit = _prepared(stacks, noise, saturation)
    start, sigma = yield from _first_places(clean, level, limit)
    count = int(sum(each.used.sum() for each in start))
    if count < LEAST_WINDOWS:
        raise LocationError(
            f'{count} windows with a peak of {LEAST_SNR:g} standard deviations or more are too '
            f'few to learn a pulse from; it takes {LEAST_WINDOWS}'
        )
    extent = max(max(lit.shape[1:]) for lit, _ in clean)
    task = _Task(clean, level, limit, Grid.over(extent, sigma, most_nodes))
    scales = varies is True
    pulse, places = yield from _alternate(task, start, scales)
    if varies is None and (yield from _scales_vary(task, places, pulse)):
        scales = True
        pulse, places = yield from _alternate(task, places, scales)
    gap, axis = max(
        (gap_of(np.concatenate([getattr(at, axis)[at.used] for at in places])), axis)
        for axis in 'xy'
    )
    if gap > WIDEST_GAP:
        raise LocationError(
            f'the windows leave {gap:.2f} px of the pixel without a centre along {axis}, '
            f'{WIDEST_GAP:g} px at most let the pulse be learned; let the target move over '
            'many pixels in both directions'
        )
    covariance, gain = yield from _by_halves(task, start, places, scales)
    chi2 = np.concatenate([each.chi2[each.used] for each in places])
    return Learned(
        replace(pulse, covariance=covariance), int(chi2.size), gap, gain,
        float(np.median(chi2)), noise,
    )


def _prepared(
    stacks: Sequence[Stack], noise: SensorNoise, saturation: float | None
) -> tuple[list[Stack], SensorNoise, float | None]:
    """Return the stacks as numbers less the black level, and noise and saturation to go with."""
    black = noise.black_level
    clean: list[Stack] = []
    for lit, unlit in stacks:
        lit = np.ascontiguousarray(lit, dtype=float) - black
        whole = np.isfinite(lit).all(axis=(1, 2)) & (np.ptp(lit, axis=(1, 2)) > 0.0)
        if unlit is not None:
            unlit = np.ascontiguousarray(unlit, dtype=float) - black
            whole &= np.isfinite(unlit).all(axis=(1, 2))
            unlit = unlit[whole]
        if whole.any():
            clean.append((lit[whole], unlit))
    limit = None if saturation is None else saturation - black
    return clean, replace(noise, black_level=0.0), limit


def _first_places(
    stacks: Sequence[Stack], noise: SensorNoise, saturation: float | None
) -> Slices[tuple[list[_Places], float]]:
    """Return where a Gaussian, or the centroid where that does not fit, has them; its sigma."""
    found = []
    for lit, unlit in stacks:
        parts = []
        for part in _slices(lit):
            parts.append(fit_gaussians(
                lit[part], None if unlit is None else unlit[part], noise, saturation
            )[0])
            yield
        found.append(_joined(parts))
    bright = [each.used & (snr > LEAST_SNR) for each, snr in found]
    count = sum(each.size for each in bright)
    if sum(each.sum() for each in bright) >= FITTED * count > 0:
        sigma = float(np.median(np.concatenate([
            each.scale[used] for (each, _), used in zip(found, bright)
        ])))
        unit = float(integrated_profile(1, 0.0, sigma)[0][0]) ** 2
        places = [
            replace(
                each, amplitude=each.amplitude * unit, scale=np.ones(used.size), used=used
            )
            for (each, _), used in zip(found, bright)
        ]
        return places, sigma
    places, widths = [], []
    for lit, unlit in stacks:
        seen = moments(lit, unlit, noise)
        light = lit - (seen.background[:, None, None] if unlit is None else unlit)
        # The brightest twentieth, not the brightest pixel: that one is noise.
        peak = np.quantile(light, 0.95, axis=(1, 2))
        level = np.zeros_like(peak) if unlit is not None else seen.background
        dark = np.sqrt(noise.read_noise**2 + 1.0 / 12.0 + np.maximum(peak, 0.0) / noise.gain)
        used = (seen.failure == 0) & (peak > LEAST_SNR * dark)
        places.append(_Places(
            seen.value[:, 0], seen.value[:, 1], np.maximum(peak, 1e-3), level,
            np.ones(peak.size), used, np.ones(peak.size),
        ))
        widths.append(seen.value[used, 2])
    second = np.concatenate(widths) if widths else np.ones(1)
    return places, float(np.sqrt(np.median(second))) if second.size else 1.0


def _slices(lit: Floats) -> list[slice]:
    """Return the windows that are fitted at a time."""
    each = max(SLICE // (lit.shape[1] * lit.shape[2]), 1)
    return [slice(k, k + each) for k in range(0, len(lit), each)]


def _joined(parts: Sequence[Estimates]) -> tuple[_Places, Floats]:
    """Return the places of the windows of a stack, those used that have one, and their SNR."""
    x, y, amplitude, background, sigma, ok, chi2, snr = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ('x', 'y', 'amplitude', 'background', 'sigma', 'ok', 'chi2', 'snr')
    )
    return _Places(x, y, amplitude, background, np.where(ok, sigma, 1.0), ok, chi2), snr


def _alternate(
    task: _Task, start: Sequence[_Places], varies: bool
) -> Slices[tuple[EffectivePsf, list[_Places]]]:
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


def _moved(before: Sequence[_Places], after: Sequence[_Places]) -> float:
    """Return the rms by which places moved against each other, px."""
    moves = np.concatenate([
        np.stack([one.x - other.x, one.y - other.y])[:, one.used & other.used]
        for one, other in zip(after, before)
    ], axis=1)
    return float(np.sqrt(moves.var(axis=1).sum() / 2.0)) if moves.size else math.inf


def _centred(places: Sequence[_Places], centre: tuple[float, float]) -> list[_Places]:
    """Return the places from the centre of the pulse that they were had with."""
    return [
        replace(at, x=at.x + centre[0] * at.scale, y=at.y + centre[1] * at.scale)
        for at in places
    ]


@dataclass(frozen=True)
class _Task:
    """The windows and all that does not change while a pulse is learned from them."""

    stacks: Sequence[Stack]
    noise: SensorNoise
    saturation: float | None
    grid: Grid

    def surface(
        self, places: Sequence[_Places], roughness: float
    ) -> Slices[tuple[EffectivePsf, float]]:
        """Return the pulse of these places, and its roughness."""
        equations = Equations(self.grid)
        shot, floor = 1.0 / self.noise.gain, self.noise.read_noise**2 + 1.0 / 12.0
        limit = math.inf if self.saturation is None else self.saturation
        for (lit, unlit), at in zip(self.stacks, places):
            told = np.stack([at.x, at.y, at.amplitude, at.background, at.scale])
            for part in _slices(lit):
                chosen = np.flatnonzero(at.used[part]) + part.start
                equations.add(
                    lit[chosen], None if unlit is None else unlit[chosen],
                    np.ascontiguousarray(told[:, chosen]), shot, floor, limit,
                )
                yield
        return equations.pulse(roughness)

    def fit(self, pulse: EffectivePsf, varies: bool) -> Slices[list[tuple[_Places, Floats]]]:
        """Return the places by a pulse, with their SNR."""
        told = pulse_of(pulse, varies)
        found = []
        for lit, unlit in self.stacks:
            parts = []
            for part in _slices(lit):
                parts.append(learned_pulse(
                    lit[part], None if unlit is None else unlit[part], self.noise,
                    self.saturation, told,
                )[0])
                yield
            places, snr = _joined(parts)
            scale = np.where(places.used, places.scale / pulse.sigma, 1.0)
            found.append((replace(places, scale=scale), snr))
        return found

    def of(self, chosen: Sequence[NDArray[np.int64]]) -> _Task:
        """Return that of some windows."""
        return replace(self, stacks=[
            (lit[which], None if unlit is None else unlit[which])
            for (lit, unlit), which in zip(self.stacks, chosen)
        ])


def _evenly(places: Sequence[_Places]) -> list[_Places]:
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


def _scales_vary(task: _Task, places: Sequence[_Places], pulse: EffectivePsf) -> Slices[bool]:
    """Tell whether scales of their own fit the windows better than noise lets them."""
    found = yield from task.fit(pulse, True)
    gain, count = [], 0
    for (lit, _), one, (own, _) in zip(task.stacks, places, found):
        kept = own.used & one.used
        pixels = lit.shape[1] * lit.shape[2]
        gain.append(one.chi2[kept] * (pixels - 4) - own.chi2[kept] * (pixels - 5))
        count += int(kept.sum())
    # One more parameter a window takes a chi-square of one degree of freedom off.
    return float(np.concatenate(gain).sum()) > STEADY * count


def gap_of(places: Floats) -> float:
    """Return the widest part of the pixel without one of (N,) places along an axis, px."""
    phases = np.sort(np.mod(places, 1.0))
    return float(np.diff(phases, append=phases[0] + 1.0).max())


def _by_halves(
    task: _Task, start: Sequence[_Places], places: Sequence[_Places], varies: bool
) -> Slices[tuple[Floats, float]]:
    """Return the covariance of the pulse's error, px^2, and its gain over the Gaussian."""
    used = [np.flatnonzero(each.used) for each in places]
    whole = task.of(used)
    found = []
    for half in range(2):
        mine = [index[half::2] for index in used]
        pulse, _ = yield from _alternate(
            task.of(mine), [at.of(which) for at, which in zip(start, mine)], varies
        )
        found.append((yield from whole.fit(pulse, varies)))
    moved, gains = [], []
    free = 5 if varies else 4
    for (lit, unlit), (first, _), (second, _) in zip(whole.stacks, *found):
        pixels = lit.shape[1] * lit.shape[2]
        ok = first.used & second.used
        moved.append(np.stack([first.x - second.x, first.y - second.y], axis=1)[ok])
        parts = []
        for part in _slices(lit):
            parts.append(fit_gaussians(
                lit[part], None if unlit is None else unlit[part], task.noise, task.saturation
            )[0])
            yield
        gaussian, _ = _joined(parts)
        other = np.where(np.arange(ok.size) % 2 == 0, second.chi2, first.chi2)
        squares = np.where(gaussian.used, gaussian.chi2, HOPELESS) * (pixels - 5)
        # The Gaussian fits its width: the parameter more takes off what it takes of noise.
        gains.append(0.5 * (squares - other * (pixels - free) + 5 - free)[ok])
    apart = np.concatenate(moved)
    # Of half the windows each: their difference has four times the variance of the whole's.
    return apart.T @ apart / (4.0 * len(apart)), float(np.median(np.concatenate(gains)))

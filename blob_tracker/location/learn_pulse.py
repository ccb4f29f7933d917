"""Learn the pulse of a light from windows of it in all sub-pixel phases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.maximum_likelihood import fit_gaussians
from blob_tracker.location.moments import moments
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.location.pulse_rounds import (
    alternate, Floats, joined, LEAST_SNR, LEAST_WINDOWS, Places, Slices, slices_of, Stack, Task,
)
from blob_tracker.location.pulse_surface import Grid
from blob_tracker.types import LocationError, SensorNoise
import numpy as np

WIDEST_GAP = 0.2  # px of the pixel in which no window's centre lies, along x or y
MOST_NODES = 81  # along an axis: a wider pulse gets a coarser grid
FITTED = 0.8  # of the windows, that a Gaussian must fit to be started from
HOPELESS = 1e3  # chi2 of a Gaussian if there is none that fits
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

    Examples
    --------
    What is learned of a Gaussian fits no better than a Gaussian:

    >>> from blob_tracker.simulation import expose, pixel_integrated_gaussian
    >>> random, noise = np.random.default_rng(1), SensorNoise(gain=40.0, read_noise=0.7)
    >>> lit = np.stack([
    ...     expose(40.0 + 150.0 * pixel_integrated_gaussian((13, 13), x, y, 1.2), noise, random)
    ...     for x, y in random.uniform(5.5, 6.5, (200, 2))
    ... ])
    >>> learned = learn_pulse([(lit, None)], noise=noise, saturation=255)
    >>> learned.better, round(learned.pulse.sigma, 1)  # -, px
    (False, 1.2)

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
        Whether the blob's size may vary; found from the windows if left out.

    Returns
    -------
    Learned
        The pulse and how it was had.

    Raises
    ------
    LocationError
        If there are too few windows, or too few phases among them.

    References
    ----------
    Anderson and King, PASP 112 (2000) 1360. Eilers and Marx, Flexible smoothing with B-splines
    and penalties, Statistical Science 11 (1996).

    Examples
    --------
    Windows of the virtual lab, of a lamp behind a screen, which is no Gaussian:

    >>> from blob_tracker.simulation import expose, ThreeGaussians
    >>> random, noise = np.random.default_rng(1), SensorNoise(gain=40.0, read_noise=0.7)
    >>> lit = np.stack([
    ...     expose(40.0 + 150.0 * ThreeGaussians().over_pixels((17, 17), x, y, 1.2), noise, random)
    ...     for x, y in random.uniform(7.5, 8.5, (200, 2))
    ... ])
    >>> learned = learn_pulse([(lit, None)], noise=noise, saturation=255)
    >>> learned.windows, learned.better
    (200, True)

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
    task = Task(clean, level, limit, Grid.over(extent, sigma, most_nodes))
    scales = varies is True
    pulse, places = yield from alternate(task, start, scales)
    if varies is None and (yield from _scales_vary(task, places, pulse)):
        scales = True
        pulse, places = yield from alternate(task, places, scales)
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
) -> Slices[tuple[list[Places], float]]:
    """Return where a Gaussian, or the centroid where that does not fit, has them; its sigma."""
    found = []
    for lit, unlit in stacks:
        parts = []
        for part in slices_of(lit):
            parts.append(fit_gaussians(
                lit[part], None if unlit is None else unlit[part], noise, saturation
            )[0])
            yield
        found.append(joined(parts))
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
        places.append(Places(
            seen.value[:, 0], seen.value[:, 1], np.maximum(peak, 1e-3), level,
            np.ones(peak.size), used, np.ones(peak.size),
        ))
        widths.append(seen.value[used, 2])
    second = np.concatenate(widths) if widths else np.ones(1)
    return places, float(np.sqrt(np.median(second))) if second.size else 1.0


def _scales_vary(task: Task, places: Sequence[Places], pulse: EffectivePsf) -> Slices[bool]:
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
    task: Task, start: Sequence[Places], places: Sequence[Places], varies: bool
) -> Slices[tuple[Floats, float]]:
    """Return the covariance of the pulse's error, px^2, and its gain over the Gaussian."""
    used = [np.flatnonzero(each.used) for each in places]
    whole = task.of(used)
    found = []
    for half in range(2):
        mine = [index[half::2] for index in used]
        pulse, _ = yield from alternate(
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
        for part in slices_of(lit):
            parts.append(fit_gaussians(
                lit[part], None if unlit is None else unlit[part], task.noise, task.saturation
            )[0])
            yield
        gaussian, _ = joined(parts)
        other = np.where(np.arange(ok.size) % 2 == 0, second.chi2, first.chi2)
        squares = np.where(gaussian.used, gaussian.chi2, HOPELESS) * (pixels - 5)
        # The Gaussian fits its width: the parameter more takes off what it takes of noise.
        gains.append(0.5 * (squares - other * (pixels - free) + 5 - free)[ok])
    apart = np.concatenate(moved)
    # Of half the windows each: their difference has four times the variance of the whole's.
    return apart.T @ apart / (4.0 * len(apart)), float(np.median(np.concatenate(gains)))

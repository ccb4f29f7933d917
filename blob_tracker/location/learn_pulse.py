"""Learn the pulse of a light from windows of it in all sub-pixel phases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.effective_psf import EffectivePsf, evaluate, spline, surface_of
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.learned_pulse import learned_pulse, pulse_of
from blob_tracker.location.maximum_likelihood import fit_gaussians
from blob_tracker.location.moments import moments
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.types import LocationError, SensorNoise
import numpy as np
from numpy.typing import NDArray
import scipy

Floats = NDArray[np.float64]
Stack = tuple[Floats, Floats | None]

LEAST_WINDOWS = 100
LEAST_SNR = 8.0  # of the peak: below it the place is too uncertain to learn a shape from
WIDEST_GAP = 0.2  # px of the pixel in which no window's centre lies, along x or y
STEP = 0.5  # px between two nodes
SHARP = 0.75  # px: of pulses narrower than that the nodes lie closer
SHARP_STEP = 0.4
MOST_NODES = 81  # along an axis: a wider pulse gets a coarser grid
ROUNDS = 8  # of places and pulse in turn
SMOOTHEST = 1e-2  # of the information on a node: the penalty of a first look
PINNED = 1e3  # of the information on a node: the outermost ones are 0
EMPTY = 1e-9  # of it: a node that no pixel saw is what its neighbours make it
UNEVEN = 0.02  # of the peak: what pixels and lenses differ by, so that no one window rules
OUTLIER = 4.0  # times the median chi2: another light is in the window
FITTED = 0.8  # of the windows, that a Gaussian must fit to be started from
HOPELESS = 1e3  # chi2 of a Gaussian where there is none that fits
FAINT = 0.1  # of the peak: below it noise draws the centroid away
CENTRING = 20  # steps
CENTRED = 1e-6  # px
SURE = 12.0  # over N: the square of a harmonic that even phases have once in 400 times
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
    squares: Floats


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
    clean, level, limit = _prepared(stacks, noise, saturation)
    start, sigma = _first_places(clean, level, limit)
    count = int(sum(each.used.sum() for each in start))
    if count < LEAST_WINDOWS:
        raise LocationError(
            f'{count} windows with a peak of {LEAST_SNR:g} standard deviations or more are too '
            f'few to learn a pulse from; it takes {LEAST_WINDOWS}'
        )
    task = _Task(clean, level, limit, sigma, *_grid(clean, sigma))
    scales = varies is None or varies
    pulse, places = _alternate(task, start, scales)
    if varies is None and not _scales_vary(task, places, pulse):
        pulse, places = _alternate(task, start, False)
    gap, axis = max((_gap(places, axis), axis) for axis in 'xy')
    if gap > WIDEST_GAP:
        raise LocationError(
            f'the windows leave {gap:.2f} px of the pixel without a centre along {axis}, '
            f'{WIDEST_GAP:g} px at most let the pulse be learned; let the target move over '
            'many pixels in both directions'
        )
    covariance, gain = _by_halves(task, start, places, pulse)
    chi2 = np.concatenate([each.squares[each.used] for each in places])
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
) -> tuple[list[_Places], float]:
    """Return where a Gaussian, or the centroid where that does not fit, has them; its sigma."""
    found = [fit_gaussians(*stack, noise, saturation)[0] for stack in stacks]
    bright = [each.ok & (each.snr > LEAST_SNR) for each in found]
    count = sum(each.ok.size for each in found)
    if sum(each.sum() for each in bright) >= FITTED * count > 0:
        sigma = float(np.median(np.concatenate([
            each.sigma[used] for each, used in zip(found, bright)
        ])))
        unit = float(integrated_profile(1, 0.0, sigma)[0][0]) ** 2
        places = [
            _Places(
                each.x, each.y, each.amplitude * unit, each.background, np.ones(each.x.size),
                used, each.chi2,
            )
            for each, used in zip(found, bright)
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


def _alternate(
    task: _Task, start: Sequence[_Places], varies: bool
) -> tuple[EffectivePsf, list[_Places]]:
    """Return the pulse and the places after ROUNDS of both in turn."""
    places = list(start)
    roughness = 0.0
    for _ in range(ROUNDS):
        pulse, roughness = task.surface(places, roughness)
        fits = task.fit(pulse, varies)
        chi2 = np.concatenate([fit.chi2[fit.ok] for fit in fits])
        if chi2.size < LEAST_WINDOWS // 2:
            raise LocationError('the windows do not show one pulse: most of them fit none')
        limit = OUTLIER * float(np.median(chi2))
        places = [
            _Places(
                fit.x, fit.y, fit.amplitude, fit.background,
                np.where(fit.ok, fit.sigma / task.sigma, 1.0),
                fit.ok & (fit.chi2 < limit) & (fit.snr > LEAST_SNR), fit.chi2,
            )
            for fit in fits
        ]
        scales = np.concatenate([each.scale[each.used] for each in places])
        usual = float(np.exp(np.median(np.log(scales))))
        places = _centred(
            [replace(each, scale=each.scale / usual) for each in places], _centre(pulse)
        )
        if task.step < STEP:
            places = _evenly(places)
    pulse, _ = task.surface(places, roughness)
    places = _centred(places, _centre(pulse))
    return replace(task.surface(places, roughness)[0], varies=varies), places


def _centred(places: Sequence[_Places], centre: tuple[float, float]) -> list[_Places]:
    """Return the places from the centre of the pulse that they were had with."""
    return [
        replace(at, x=at.x + centre[0] * at.scale, y=at.y + centre[1] * at.scale)
        for at in places
    ]


def _grid(stacks: Sequence[Stack], sigma: float) -> tuple[int, float]:
    """Return how many nodes the surface has along an axis, and the step between two, px."""
    extent = max(max(lit.shape[1:]) for lit, _ in stacks)
    step = SHARP_STEP if sigma < SHARP else STEP
    half = min(math.ceil((0.5 * extent + 1.0) / step), MOST_NODES)
    if half > MOST_NODES // 2:
        half = MOST_NODES // 2
        step = (0.5 * extent + 1.0) / half
    return 2 * half + 1, step


@dataclass(frozen=True)
class _Task:
    """The windows and all that does not change while a pulse is learned from them."""

    stacks: Sequence[Stack]
    noise: SensorNoise
    saturation: float | None
    sigma: float
    nodes: int
    step: float

    def equations(self, places: Sequence[_Places]) -> tuple[Floats, Floats]:
        """Return the lower bands of the normal matrix of the surface, and the right side."""
        size = self.nodes * self.nodes
        bands, right = np.zeros((3 * self.nodes + 4, size)), np.zeros(size)
        limit = math.inf if self.saturation is None else self.saturation
        for (lit, unlit), at in zip(self.stacks, places):
            _accumulate(
                lit, lit[:0] if unlit is None else unlit, np.flatnonzero(at.used),
                np.stack([at.x, at.y, at.amplitude, at.background, at.scale]),
                1.0 / self.noise.gain, self.noise.read_noise**2 + 1.0 / 12.0, limit, self.nodes,
                self.step, UNEVEN, bands, right,
            )
        return bands, right

    def surface(
        self, places: Sequence[_Places], roughness: float
    ) -> tuple[EffectivePsf, float]:
        """Return the pulse of these places, and its roughness."""
        bands, right = self.equations(places)
        bell = self.gaussian()
        if roughness == 0.0:
            first = _solve(bands, right, bell, SMOOTHEST * _information(bands))
            roughness = _roughness(first - bell)
        pulse = _normalised(
            _solve(bands, right, bell, 1.0 / roughness), self.step, self.sigma
        )
        return pulse, roughness

    def gaussian(self) -> Floats:
        """Return the coefficients of the pixel-integrated Gaussian of the peak 1."""
        middle = self.nodes // 2
        along = np.array([
            integrated_profile(1, (middle - k) * self.step, self.sigma)[0][0]
            for k in range(self.nodes)
        ])
        along /= along[middle]
        spline_of: Floats = scipy.ndimage.spline_filter(np.outer(along, along), order=3)
        return spline_of

    def fit(self, pulse: EffectivePsf, varies: bool) -> list[Estimates]:
        """Return the places by a pulse."""
        told = pulse_of(pulse, varies)
        return [
            learned_pulse(*stack, self.noise, self.saturation, told)[0] for stack in self.stacks
        ]


def _evenly(places: Sequence[_Places]) -> list[_Places]:
    """
    Take off the places what follows the sub-pixel phase, by its first harmonic.

    Places that all err by one function of their phase make a pulse under which the windows are
    as likely: an undersampled pulse cannot tell. The phases can, which are even where the target
    moves far enough: `learn_phase_correction`. What even phases have of a harmonic by chance, a
    mean square of 4 / N, is not taken off (James and Stein, 1961).
    """
    moves = []
    for axis in 'xy':
        turn = 2.0 * np.pi * np.concatenate([getattr(at, axis)[at.used] for at in places])
        a, b = 2.0 * np.cos(turn).mean(), 2.0 * np.sin(turn).mean()
        share = max(0.0, 1.0 - SURE / (turn.size * max(a * a + b * b, 1e-12)))
        moves.append((share * a / (2.0 * np.pi), share * b / (2.0 * np.pi)))
    (ax, bx), (ay, by) = moves
    return [
        replace(
            at,
            x=at.x + ax * np.sin(2.0 * np.pi * at.x) - bx * np.cos(2.0 * np.pi * at.x),
            y=at.y + ay * np.sin(2.0 * np.pi * at.y) - by * np.cos(2.0 * np.pi * at.y),
        )
        for at in places
    ]


def _information(bands: Floats) -> float:
    """Return the median information on a node that is seen."""
    return float(np.median(bands[0][bands[0] > 0.0]))


def _roughness(coefficients: Floats) -> float:
    """Return the mean square of the third differences where there is anything, of both axes."""
    across, down = np.diff(coefficients, 3, axis=1), np.diff(coefficients, 3, axis=0)
    bright = np.abs(coefficients) > 0.05 * np.abs(coefficients).max()
    rows, columns = np.flatnonzero(bright.any(axis=1)), np.flatnonzero(bright.any(axis=0))
    inside = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    both = np.append(across[inside].ravel(), down[inside].ravel())
    return float(np.mean(both**2))


def _solve(bands: Floats, right: Floats, bell: Floats, smoothing: float) -> Floats:
    """Return the (n, n) coefficients of the fit, penalised where they depart from `bell`."""
    nodes = len(bell)
    information = _information(bands)
    smoothing = max(smoothing, EMPTY * information)
    matrix = bands.copy()
    index = np.arange(nodes * nodes).reshape(nodes, nodes)
    stencil = np.array([-1.0, 3.0, -3.0, 1.0])
    for apart, first in ((1, index[:, :-3].ravel()), (nodes, index[:-3].ravel())):
        for p in range(4):
            for q in range(p + 1):
                np.add.at(
                    matrix[(p - q) * apart], first + q * apart, smoothing * stencil[p] * stencil[q]
                )
    right = right + smoothing * _penalty(bell).ravel()
    matrix[0] += EMPTY * information
    edge = np.ones((nodes, nodes), dtype=bool)
    edge[2:-2, 2:-2] = False
    matrix[0][edge.ravel()] += PINNED * information
    solved: Floats = scipy.linalg.solveh_banded(matrix, right, lower=True, check_finite=False)
    return solved.reshape(nodes, nodes)


def _penalty(coefficients: Floats) -> Floats:
    """Return D^T D c of the third differences along both axes."""
    total = np.zeros_like(coefficients)
    for turned, out in ((coefficients, total), (coefficients.T, total.T)):
        third = np.diff(turned, 3, axis=0)
        for p, weight in enumerate((-1.0, 3.0, -3.0, 1.0)):
            out[p:len(out) - 3 + p] += weight * third
    return total


def _normalised(coefficients: Floats, step: float, sigma: float) -> EffectivePsf:
    """Return the pulse with its peak at 1."""
    # B-splines of 1 at a node and its neighbours; a parabola is not needed, the peak is a unit.
    weights = np.array([1.0, 4.0, 1.0]) / 6.0
    at_nodes = scipy.ndimage.convolve1d(
        scipy.ndimage.convolve1d(coefficients, weights, axis=0, mode='constant'), weights, axis=1,
        mode='constant',
    )
    peak = float(at_nodes.max())
    if not peak > 0.0:
        raise LocationError('the windows hold no pulse: what is common to them is no light')
    return EffectivePsf(coefficients / peak, step, sigma)


def _centre(pulse: EffectivePsf) -> tuple[float, float]:
    """
    Return the point about which the pulse is most symmetric, px.

    The c with the least sum (P(c + u) - P(c - u))^2, by Gauss-Newton from the centroid: of a
    round pulse the middle, also where it is dark, to the accuracy of a fit.
    """
    middle = pulse.coefficients.shape[0] // 2
    along = np.arange(-2 * middle, 2 * middle + 1) * (0.5 * pulse.step)
    u, v = (axis.ravel().copy() for axis in np.meshgrid(along, along))
    surface, ahead, behind = surface_of(pulse), np.empty((3, u.size)), np.empty((3, u.size))
    evaluate(surface, u, v, ahead)
    light = np.where(ahead[0] > FAINT * ahead[0].max(), ahead[0], 0.0)
    centre = np.array([light @ u, light @ v]) / light.sum()
    for _ in range(CENTRING):
        evaluate(surface, centre[0] + u, centre[1] + v, ahead)
        evaluate(surface, centre[0] - u, centre[1] - v, behind)
        slopes = ahead[1:] + behind[1:]
        step = np.linalg.solve(slopes @ slopes.T, slopes @ (behind[0] - ahead[0]))
        centre += step
        if np.hypot(*step) < CENTRED:
            break
    return float(centre[0]), float(centre[1])


def _scales_vary(task: _Task, places: Sequence[_Places], pulse: EffectivePsf) -> bool:
    """Tell whether the scales scatter more than the fits with one scale allow."""
    gain, count = [], 0
    for (lit, _), one, own in zip(task.stacks, task.fit(pulse, False), places):
        kept = own.used & one.ok
        pixels = lit.shape[1] * lit.shape[2]
        gain.append(one.chi2[kept] * (pixels - 4) - own.squares[kept] * (pixels - 5))
        count += int(kept.sum())
    # One more parameter a window takes a chi-square of one degree of freedom off.
    return float(np.concatenate(gain).sum()) > STEADY * count


def _gap(places: Sequence[_Places], axis: str) -> float:
    """Return the widest part of the pixel without a centre along an axis, px."""
    phases = np.sort(np.mod(np.concatenate([getattr(at, axis)[at.used] for at in places]), 1.0))
    return float(np.diff(phases, append=phases[0] + 1.0).max())


def _by_halves(
    task: _Task, start: Sequence[_Places], places: Sequence[_Places], pulse: EffectivePsf
) -> tuple[Floats, float]:
    """Return the covariance of the pulse's error, px^2, and its gain over the Gaussian."""
    used = [np.flatnonzero(each.used) for each in places]
    halves = []
    for half in range(2):
        mine = [index[half::2] for index in used]
        part = replace(task, stacks=[_part(*each) for each in zip(task.stacks, mine)])
        halves.append(
            _alternate(part, [_places_of(*each) for each in zip(start, mine)], pulse.varies)[0]
        )
    moved, gains = [], []
    whole = replace(task, stacks=[_part(*each) for each in zip(task.stacks, used)])
    free = 5 if pulse.varies else 4
    for (lit, unlit), first, second in zip(
        whole.stacks, *(whole.fit(half, pulse.varies) for half in halves)
    ):
        pixels = lit.shape[1] * lit.shape[2]
        ok = first.ok & second.ok
        moved.append(np.stack([first.x - second.x, first.y - second.y], axis=1)[ok])
        gaussian, _ = fit_gaussians(lit, unlit, task.noise, task.saturation)
        other = np.where(np.arange(ok.size) % 2 == 0, second.chi2, first.chi2)
        squares = np.where(gaussian.ok, gaussian.chi2, HOPELESS) * (pixels - 5)
        # The Gaussian fits its width: the parameter more takes off what it takes of noise.
        gains.append(0.5 * (squares - other * (pixels - free) + 5 - free)[ok])
    apart = np.concatenate(moved)
    # Of half the windows each: their difference has four times the variance of the whole's.
    return apart.T @ apart / (4.0 * len(apart)), float(np.median(np.concatenate(gains)))


def _part(stack: Stack, chosen: NDArray[np.int64]) -> Stack:
    lit, unlit = stack
    return lit[chosen], None if unlit is None else unlit[chosen]


def _places_of(at: _Places, chosen: NDArray[np.int64]) -> _Places:
    return _Places(
        at.x[chosen], at.y[chosen], at.amplitude[chosen], at.background[chosen],
        at.scale[chosen], at.used[chosen], at.squares[chosen],
    )


@kernel
def _accumulate(
    lit: Array, unlit: Array, chosen: NDArray[np.int64], places: Array, shot: float,
    floor: float, saturation: float, nodes: int, step: float, uneven: float, bands: Array,
    right: Array,
) -> None:
    """Add windows to the normal equations of the surface, whose lower bands are `bands`."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    wv, wu, slope = np.empty(4), np.empty((width, 4)), np.empty(4)
    left = np.empty(width, np.int64)
    reach = (nodes // 2 - 1) * step
    for n in chosen:
        x, y, amplitude, background, scale = (
            places[0, n], places[1, n], places[2, n], places[3, n], places[4, n]
        )
        for i in range(width):
            left[i] = spline((i - x) / scale, step, nodes, wu[i], slope)
        for j in range(height):
            v = (j - y) / scale
            if abs(v) >= reach:
                continue
            top = spline(v, step, nodes, wv, slope)
            for i in range(width):
                if abs(i - x) >= reach * scale or lit[n, j, i] >= saturation:
                    continue
                variance = max(lit[n, j, i], 0.0) * shot + floor
                light = lit[n, j, i] - background
                if paired:
                    if unlit[n, j, i] >= saturation:
                        continue
                    light = lit[n, j, i] - unlit[n, j, i]
                    variance += max(unlit[n, j, i], 0.0) * shot + floor
                variance += (uneven * amplitude) ** 2
                weight = amplitude / variance
                for a in range(4):
                    for b in range(4):
                        node = (top + a) * nodes + left[i] + b
                        value = weight * wv[a] * wu[i, b]
                        right[node] += value * light
                        value *= amplitude
                        for c in range(4):
                            for d in range(4):
                                other = (top + c) * nodes + left[i] + d
                                if other >= node:
                                    bands[other - node, node] += value * wv[c] * wu[i, d]

"""How a light blinks whose brightness was seen for a while: as a wave, a code, or not at all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
import math

from blob_tracker.blinking.folding import FEWEST_PERIODS, likely_periods
from blob_tracker.blinking.patterns import LONGEST_BITS
from blob_tracker.blinking.sampling import spread
from blob_tracker.kernel import Array
import numpy as np

SCATTER = 0.06  # of the full flux: scintillation, and what its envelope is off by
OUTLIER = 4.0  # standard deviations, from which on a frame counts no more
EVEN = 0.15  # of the flux: what changes by less is steady
DARK = 0.03  # of the frames of a light that blinks, at least
CANDIDATES = 24  # periods that are looked at closely
FITTED = 4  # patterns of them, the best
ENVELOPE_FRAMES = 61  # over which the full flux may drift
FULL_RANK = 90.0  # percentile of the lit frames, which are full where nothing else is known
SHORTEST_BIT = 0.9  # frame intervals: a quicker code is aliased
FREE_BIT = 1e-4  # of a bit, by which stamps are off at least
PARAMETERS = 2.0  # of a code beside its bits, of 0.5 ln n nats each; a wave has its duty too
BIT_NATS = math.log(2.0)
EXPOSURES = (0.5, 0.25, 0.8)  # of the frame interval, to begin with where nobody tells
LEAST_EXPOSURE = 0.02  # of the frame interval
MISFIT = 3.0  # chi-square per frame of a light that keeps its rate, at most
FEWEST_FRAMES = 12
RHYTHM_PART = 0.5  # of the variance that a modulated lamp's rhythm explains
# Nats by which a code in step with the frames is the likelier by itself, and bits in step at all
IN_STEP_NATS, IN_STEP = 10.0, 2e-3
SEARCHED_NATS = 8.0  # of some thousand periods that were tried
OFFSETS = 8  # a bit, of where it may begin
ALIAS_NATS = 6.0  # by which the likelihood of an alias may be less


@dataclass(frozen=True)
class Rhythm:
    """
    How a light blinks; times in frame intervals.

    Parameters
    ----------
    kind : str
        'wave' (on once a period), 'code' (several times), 'modulated' (brighter and darker, never
        dark), 'steady', 'short' (too few frames to tell) or 'irregular' (no period fits).
    period, period_sigma : float
        After which it repeats; 0 where it does not.
    duty, duty_sigma : float
        Part of the time for which it is on; 0 of a light that is never dark.
    bits : str
        Of a code, begun so that it is the greatest number.
    rise : float
        Time at which the wave, or the first bit, begins.
    exposure : float
        That was assumed or fitted.
    misfit : float
        Chi-square per frame.
    changes : int
        How often it went on or off.

    """

    kind: str
    period: float = 0.0
    period_sigma: float = 0.0
    duty: float = 0.0
    duty_sigma: float = 0.0
    bits: str = ''
    rise: float = 0.0
    exposure: float = 0.0
    misfit: float = 0.0
    changes: int = 0

    @property
    def bit(self) -> float:
        """Return the length of a bit of a code, frame intervals."""
        return self.period / len(self.bits) if self.bits else 0.0

    @property
    def bit_sigma(self) -> float:
        """Return its standard deviation."""
        return self.period_sigma / len(self.bits) if self.bits else 0.0

    @property
    def frames_per_bit(self) -> int:
        """Return the frames of a bit of a code in step with them; 0 where it runs free."""
        frames = max(round(self.bit), 1)
        known = 3.0 * self.bit_sigma or IN_STEP * self.bit
        return frames if self.bits and abs(self.bit - frames) < known + FREE_BIT else 0

    def share(self, clock: Array) -> Array:
        """Return the part of the exposures about these times for which the light is on."""
        edges, on = _edges(self.bits, self.duty)
        return _share(
            clock, np.array([self.rise]), np.array([self.period]), edges, on,
            np.array([self.exposure]),
        )[0]


@dataclass(frozen=True)
class Brightness:
    """
    What the frames show of one light.

    Parameters
    ----------
    clock : (n,) array
        Middle of the exposure of each frame, frame intervals.
    flux, sigma : (n,) arrays
        Its light and the standard deviation of it, DN px^2; 0 and any where it was not seen.
    least : float
        Flux of which half is seen, DN px^2.

    """

    clock: Array
    flux: Array
    sigma: Array
    least: float

    @property
    def seen(self) -> Array:
        """Return 1.0 for each frame that shows it."""
        return np.asarray(self.flux > 0.0, dtype=np.float64)


def recognise(light: Brightness, exposure: float, *, sigmas: bool = True) -> Rhythm:
    """
    Return how a light blinks.

    Of all the patterns on the periods that fold its brightness best it is the one of the least
    description length: half of chi-square, and the nats that its parameters and bits take.

    Parameters
    ----------
    light : Brightness
        Of one light, from its first frame to its last.
    exposure : float
        Frame intervals; 0 where nobody tells.
    sigmas : bool
        Whether the standard deviations are asked for as well: they take 0.1 s.

    """
    full = envelope(light)
    data = _data(light, full)
    level = data[1]
    on = level > 0.5
    changes = int((on[1:] != on[:-1]).sum())
    if len(level) < FEWEST_FRAMES:
        return Rhythm('short', changes=changes)
    if (level < 0.5).mean() < DARK or level.min() > 0.35:
        return replace(_modulation(light, level), changes=changes)
    starts = [
        start for period in likely_periods(light.clock, level, CANDIDATES)
        for start in (_wave(data, float(period), exposure), _code(data, float(period), exposure))
        if start is not None
    ]
    starts = sorted(starts, key=lambda each: each[0])[:FITTED]
    found = [_best_fit(data, start, exposure) for _, start in starts]
    # What it takes to write down when a light went on and off, if there is no pattern in it.
    chance = changes * (1.0 + math.log(len(level) / max(changes, 1)))
    good = [
        each for each in found if each[1].misfit < MISFIT and each[0] + SEARCHED_NATS < chance
    ]
    if not good:
        # A code of which not two periods were seen has no period that fits.
        runs = np.diff(np.flatnonzero(np.diff(on)))
        shortest = max(float(runs.min()) if len(runs) else 1.0, 1.0)
        span = float(np.ptp(light.clock))
        kind = 'short' if span < FEWEST_PERIODS * LONGEST_BITS * shortest else 'irregular'
        return Rhythm(kind, changes=changes)
    _, best = min(good, key=lambda each: each[0])
    # Now it is known which frames are full.
    full = envelope(light, best.share(light.clock))
    data = _data(light, full)
    best = replace(_best_fit(data, best, exposure)[1], changes=changes)
    if sigmas:
        best = _with_sigmas(data, best, exposure)
    return canonical(best) if best.bits else best


def aliases(light: Brightness, rhythm: Rhythm, exposure: float, highest: float) -> list[float]:
    """
    Return the other rates of a wave that the frames show as well, periods a frame interval.

    What blinks with the rate f looks like all |k +- f|; how many frames an edge runs through, or
    frames that are not evenly spaced, may tell which it is.
    """
    full = envelope(light, rhythm.share(light.clock))
    data = _data(light, full)
    own = float(_cost(data, rhythm.share(light.clock)))
    rate = 1.0 / rhythm.period
    found = []
    for turns in range(1, int(highest + rate) + 1):
        for other in (turns - rate, turns + rate):
            if other > highest:
                continue
            _, start = _wave(data, 1.0 / other, exposure)
            _, fitted = _best_fit(data, start, exposure)
            if 0.5 * fitted.misfit * len(light.clock) < own + ALIAS_NATS:
                found.append(other)
    return found


def envelope(light: Brightness, share: Array | None = None) -> Array:
    """
    Return the flux of a light that is fully lit, which may drift, DN px^2.

    Of shares s of it the flux f is f s / s^2, each summed over the frames near by.
    """
    if share is None:
        seen = np.flatnonzero(light.flux > 0.0)
        if not len(seen):
            return np.ones_like(light.flux)
        near = [seen[np.abs(seen - k) <= ENVELOPE_FRAMES // 2] for k in range(len(light.flux))]
        return np.array([
            np.percentile(light.flux[some if len(some) > 3 else seen], FULL_RANK) for some in near
        ])
    share = np.where(light.flux > 0.0, share, 0.0)
    window = np.ones(min(ENVELOPE_FRAMES, len(share)))
    top = np.convolve(light.flux * share, window, 'same')
    below = np.convolve(share**2, window, 'same')
    mean = float((light.flux * share).sum() / max(float((share**2).sum()), 1e-9))
    return np.asarray(np.where(below > 1.0, top / np.maximum(below, 1e-9), mean))


Data = tuple[Array, Array, Array, Array]
Fitted = tuple[float, Rhythm]


def _data(light: Brightness, full: Array) -> Data:
    """Return times, parts of the full flux, their standard deviations, and the least part seen."""
    sigma = np.hypot(light.sigma / full, SCATTER)
    return light.clock, light.flux / full, sigma, light.least / full


def _edges(bits: str, duty: float) -> tuple[Array, Array]:
    """Return where the light has been on for how long, from the begin of a period; in periods."""
    if not bits:
        return np.array([0.0, duty, 1.0]), np.array([0.0, duty, duty])
    on = np.array([bit == '1' for bit in bits]) / len(bits)
    return np.linspace(0.0, 1.0, len(bits) + 1), np.concatenate([[0.0], np.cumsum(on)])


def _share(
    clock: Array, rise: Array, period: Array, edges: Array, on: Array, exposure: Array
) -> Array:
    """Return the (k, n) parts of exposures for which a light is on, of k rises and periods."""
    phase = (clock - rise[:, None]) / period[:, None]
    half = 0.5 * exposure[:, None] / period[:, None]

    def until(moment: Array) -> Array:
        turns = np.floor(moment)
        return np.asarray(turns * on[-1] + np.interp(moment - turns, edges, on))

    return np.asarray((until(phase + half) - until(phase - half)) / (2.0 * half))


def _residuals(data: Data, share: Array) -> Array:
    """Return how far the frames are from these parts of the full flux, standard deviations."""
    _, level, sigma, least = data
    unseen = np.maximum(share - least, 0.0)
    return np.asarray(np.where(level > 0.0, level - share, unseen) / sigma)


def _cost(data: Data, share: Array) -> Array:
    """Return half of chi-square, of which no frame has more than its part; over the last axis."""
    squares = np.minimum(_residuals(data, share) ** 2, OUTLIER**2)
    return np.asarray(0.5 * squares.sum(axis=-1))


def _wave(data: Data, period: float, exposure: float) -> Fitted:
    """Return a wave of a period that is about right, and its description length, nats."""
    clock, level = data[0], data[1]
    phase = (clock / period) % 1.0
    mean = complex((level * np.exp(2j * np.pi * phase)).sum())
    duty = float(np.clip(level.mean(), 0.02, 0.98))
    rise = (np.angle(mean) / (2.0 * np.pi) - 0.5 * duty) * period
    return _judged(data, Rhythm(
        'wave', period, duty=duty, rise=rise, exposure=exposure or EXPOSURES[0]
    ))


def _code(data: Data, period: float, exposure: float) -> Fitted | None:
    """Return the code of a period that fits best, and its description length, nats."""
    clock, level = data[0], data[1]
    best, choice = math.inf, None
    assumed = np.array([exposure or EXPOSURES[0]])
    for length in range(3, min(int(period / SHORTEST_BIT), LONGEST_BITS) + 1):
        bit = period / length
        for offset in np.arange(OFFSETS) / OFFSETS * bit:
            which = np.floor(((clock - offset) % period) / bit).astype(int) % length
            count = np.bincount(which, minlength=length)
            if not count.all():
                continue
            mean = np.bincount(which, level, minlength=length) / count
            bits = ''.join('1' if each > 0.5 else '0' for each in mean)
            if not _is_code(bits):
                continue
            edges, on = _edges(bits, 0.0)
            share = _share(
                clock, np.array([offset]), np.array([period]), edges, on, assumed
            )[0]
            cost = float(_cost(data, share)) + _code_nats(bit, length)
            if cost < best:
                best, choice = cost, Rhythm(
                    'code', period, bits=bits, rise=float(offset), exposure=float(assumed[0])
                )
    return None if choice is None else _judged(data, _shortened(choice))


def _shortened(code: Rhythm) -> Rhythm:
    """Return a code whose bits all come in groups of so many as a code of fewer, longer ones."""
    bits = code.bits
    for group in range(len(bits) // 3, 1, -1):
        for shift in range(group) if len(bits) % group == 0 else ():
            turned = bits[shift:] + bits[:shift]
            one = turned[::group]
            if turned == ''.join(bit * group for bit in one):
                return replace(code, bits=one, rise=code.rise + shift * code.bit)
    return code


def _is_code(bits: str) -> bool:
    """Tell whether bits have two flashes or more, and do not repeat within themselves."""
    return (bits + bits[0]).count('01') > 1 and bits not in (2 * bits)[1:-1]


def _code_nats(bit: float, length: int) -> float:
    """Return the nats that so many bits take, by their length in frame intervals."""
    in_step = abs(bit / max(round(bit), 1) - 1.0) < IN_STEP
    return length * BIT_NATS - (IN_STEP_NATS if in_step else 0.0)


def _judged(data: Data, rhythm: Rhythm) -> Fitted:
    """Return a pattern with its misfit, and its description length, nats."""
    clock = data[0]
    cost = float(_cost(data, rhythm.share(clock)))
    some = 0.5 * math.log(len(clock))
    size = PARAMETERS * some
    size += _code_nats(rhythm.bit, len(rhythm.bits)) if rhythm.bits else some
    return cost + size, replace(rhythm, misfit=2.0 * cost / len(clock))


def _best_fit(data: Data, start: Rhythm, exposure: float) -> Fitted:
    """Return a pattern with its period and phase fitted, and its description length, nats."""
    import scipy  # no part of a start

    clock = data[0]
    middle = float(clock.mean())
    fits = []
    for assumed in (exposure,) if exposure else EXPOSURES:
        guess = replace(start, exposure=assumed)
        values, pattern = _packed(guess, middle, not exposure)
        low, high = _bounds(guess, values)
        values = np.clip(values, low + 1e-9, high - 1e-9)
        fit = scipy.optimize.least_squares(
            lambda some: _residuals(data, pattern(some[None])[1](clock)[0]), values,
            bounds=(low, high), loss='soft_l1', x_scale=0.1 * (high - low), diff_step=1e-4,
            max_nfev=30,
        )
        fits.append(_judged(data, pattern(fit.x[None])[0]))
    return min(fits, key=lambda each: each[0])


Shares = Callable[[Array], Array]


def _packed(
    start: Rhythm, middle: float, free: bool
) -> tuple[Array, Callable[[Array], tuple[Rhythm, Shares]]]:
    """
    Return the parameters of a pattern, and what makes a pattern of (k, m) of them.

    The phase is that in the middle of the recording: there it does not go with the period.
    """
    turns = round((middle - start.rise) / start.period)
    rise = start.rise + turns * start.period
    values = [rise, start.period, *(() if start.bits else (start.duty,))]
    values += [start.exposure] if free else []
    exposure = start.exposure

    def pattern(some: Array) -> tuple[Rhythm, Shares]:
        exposures = some[:, -1] if free else np.full(len(some), exposure)
        duties = None if start.bits else some[:, 2]

        def shares(clock: Array) -> Array:
            if duties is None:
                edges, on = _edges(start.bits, 0.0)
                return _share(clock, some[:, 0], some[:, 1], edges, on, exposures)
            return _wave_share(clock, some[:, 0], some[:, 1], duties, exposures)

        first = replace(
            start, rise=float(some[0, 0]), period=float(some[0, 1]),
            duty=0.0 if duties is None else float(duties[0]), exposure=float(exposures[0]),
        )
        return first, shares

    return np.array(values), pattern


def _wave_share(
    clock: Array, rise: Array, period: Array, duty: Array, exposure: Array
) -> Array:
    """Return what `_share` does, of k waves of k duties."""
    phase = (clock - rise[:, None]) / period[:, None]
    half = 0.5 * exposure[:, None] / period[:, None]

    def until(moment: Array) -> Array:
        turns = np.floor(moment)
        return np.asarray(
            turns * duty[:, None] + np.minimum(moment - turns, duty[:, None])
        )

    return np.asarray((until(phase + half) - until(phase - half)) / (2.0 * half))


def _bounds(start: Rhythm, values: Array) -> tuple[Array, Array]:
    """Return how far the parameters may go from where they begin."""
    low, high = values.copy(), values.copy()
    low[0] -= 0.5 * start.period
    high[0] += 0.5 * start.period
    low[1] *= 0.99
    high[1] *= 1.01
    at = 2
    if not start.bits:
        low[at], high[at] = 0.01, 0.99
        at += 1
    if len(values) > at:
        low[at], high[at] = LEAST_EXPOSURE, 1.0
    return low, high


def _with_sigmas(data: Data, best: Rhythm, exposure: float) -> Rhythm:
    """
    Return the mean and the standard deviation of what the frames allow.

    Between two frames an edge may be anywhere: the likelihood has a flat top there, of which no
    derivative tells the width. So it is sampled.
    """
    clock = data[0]
    values, pattern = _packed(best, float(clock.mean()), not exposure)
    low, high = _bounds(best, values)

    def nats(some: Array) -> Array:
        inside = ((some > low) & (some < high)).all(axis=1)
        shares = pattern(np.clip(some, low, high))[1](clock)
        return np.where(inside, -_cost(data, shares), -np.inf)

    steps = np.array([0.1, 0.1 / max(float(np.ptp(clock)), 1.0) * best.period, 0.02, 0.05])
    samples = spread(nats, np.clip(values, low, high), steps[:len(values)])
    mean, sigma = samples.mean(axis=0), samples.std(axis=0)
    found = pattern(mean[None])[0]
    found = replace(found, period_sigma=float(sigma[1]))
    return found if found.bits else replace(found, duty_sigma=float(sigma[2]))


def canonical(rhythm: Rhythm) -> Rhythm:
    """Return a code begun where it reads as the greatest number: rotations are one code."""
    bits = rhythm.bits
    shift = max(range(len(bits)), key=lambda k: bits[k:] + bits[:k])
    return replace(
        rhythm, bits=bits[shift:] + bits[:shift], rise=rhythm.rise + shift * rhythm.bit,
        duty=bits.count('1') / len(bits),
    )


def _modulation(light: Brightness, level: Array) -> Rhythm:
    """Return the rhythm in which a light that is never dark grows brighter and darker."""
    seen = light.flux > 0.0
    clock, values = light.clock[seen], level[seen] - level[seen].mean()
    if len(values) < FEWEST_FRAMES or np.ptp(np.percentile(values, [5.0, 95.0])) < EVEN:
        return Rhythm('steady')
    span = float(np.ptp(clock))
    rates = np.arange(1.0, 0.5 * span * 4.0) / (4.0 * span)
    power = np.abs(np.exp(-2j * np.pi * np.outer(rates, clock)) @ values) ** 2
    peak = int(np.argmax(power))
    # The sine of that rate has 2 |sum|^2 / n of the sum of the squares.
    if 2.0 * power[peak] / len(values) < RHYTHM_PART * float(values @ values):
        return Rhythm('irregular')
    sigma = math.sqrt(6.0 / len(values)) / (math.pi * span)
    period = 1.0 / float(rates[peak])
    return Rhythm('modulated', period, sigma * period**2)

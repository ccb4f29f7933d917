"""Learn the pulse of a light while it is tracked, and use it once it is shown to fit better."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
import math

from blob_tracker.location.coarse import WIDEST
from blob_tracker.location.effective_psf import EffectivePsf, shifted
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.hypotheses import Pair
from blob_tracker.location.learn_pulse import (
    gap_of, learn_pulse, Learned, learning, WIDEST_GAP,
)
from blob_tracker.location.learned_pulse import learned_pulse, pulse_of
from blob_tracker.location.noise import noise_of_sum
from blob_tracker.location.pair_likelihood import log_likelihood_of
from blob_tracker.location.pulse_rounds import LEAST_SNR, Slices, Stack
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

Base = Callable[[], Estimates]  # of the window, without what was learned

COLLECTED = 300  # windows: the error of the pulse is a tenth or so of one window's noise
CELLS = 10  # of a pixel along an axis: full ones make room for windows in other phases
SLICES = 2  # of learning after a flash: a millisecond
MOST_NODES = 41  # along an axis: the longest slice solves for them, in 2 to 5 ms
JUDGED = 100  # flashes that the pulse has no part in, by which it is judged
# Of a window's log-likelihood: one in which something else is seen must not decide.
MOST_GAIN = 10.0
SURE_SIGMA = 4.0  # of the mean gain, before a pulse is used
LOPSIDED_SIGMA = 3.0  # beyond which the pulse has another centre than the places had
WATCHED = 8  # flashes from one to the next that is held against the other fits while it is used
LAST = 25  # of them: they took less by it on the mean, it is not used any longer
PATIENCE = 6  # times that the wait for the next attempt doubles: 300 to 19,200 flashes


class PulseLearner:
    """
    Collect the windows of one light, learn its pulse from them, judge it, use it.

    A pulse is learned from 300 windows with their phases spread over the pixel. The next 100
    windows, which it has not seen, are placed both as they would be without it (the Gaussian and
    all alternatives to it, or the pulse of a file) and with it: it is used from there on if their
    mean gain in log-likelihood, each less half its parameters (Akaike, 1974), is 4 of its
    standard errors above 0. The centre of a lopsided light, which nobody can say, stays where the
    places had it on the median. While it is used, every eighth window is placed both ways
    too; where 25 of them gain nothing on the mean (the focus, the filter, the light has changed),
    it is used no longer, and another one is learned.

    The work is done in slices of half a millisecond, two after each flash, in `work`, and
    nowhere else: no thread takes the interpreter from the one that places lights, and the same
    windows have the same locations, however fast they come.

    Attributes
    ----------
    pulse : EffectivePsf or None
        To be used for the next window; None if there is none that is better.
    learned : Learned or None
        What that pulse was learned from.
    state : str
        What is going on, in words.

    """

    def __init__(self) -> None:
        self.pulse: EffectivePsf | None = None
        self.learned: Learned | None = None
        self.state = 'collecting windows'
        self._kept: deque[tuple[Window, tuple[float, float]]] = deque()
        self._slices: Slices[Learned] | None = None
        self._candidate: Learned | None = None
        self._gains: deque[float] = deque(maxlen=JUDGED)
        self._apart: list[tuple[float, float]] = []
        self._kind: tuple[object, ...] = ()
        self._attempts, self._wait, self._flashes = 0, 0, 0
        self._window: tuple[Window, SensorNoise, Estimates, Base] | None = None

    def take(self, window: Window, noise: SensorNoise, found: Estimates, base: Base) -> None:
        """
        Take a window that was placed; `work` looks at it.

        Parameters
        ----------
        window : Window
            Its pixels.
        noise : SensorNoise
            Of a pixel in one frame.
        found : Estimates
            Its place, with `pulse` where there is one.
        base : callable
            Returns its estimates without `pulse`.

        """
        self._window = (window, noise, found, base)

    def work(self) -> None:
        """Do the work of one flash: a millisecond of it, the place of the window being out."""
        if self._window is None:
            return
        window, noise, found, base = self._window
        self._window = None
        self._flashes += 1
        if window.sites is not None:
            self.state = 'none is learned from the samples of a colour mosaic'
            return
        if min(window.lit.shape) > WIDEST:
            self.state = f'none is learned from windows of more than {WIDEST} px'
            return
        kind = (window.binning, window.looks, window.saturation, window.unlit is None)
        if kind != self._kind:
            self._kind = kind
            self._begin('collecting windows')
            self.pulse = self.learned = None
        bright = bool(found.ok[0]) and float(found.snr[0]) > LEAST_SNR
        if self._slices is not None:
            self._learn()
        elif not bright:
            return
        elif self._candidate is not None:
            self._judge(self._candidate, window, noise, found)
        elif self.pulse is not None and self.learned is not None:
            if self._flashes % WATCHED == 0:
                self._watch(self.learned, window, noise, base())
        elif self._wait > 0:
            self._wait -= 1
        else:
            self._keep(window, found)
            if len(self._kept) == COLLECTED and self._gap() <= WIDEST_GAP:
                noise = _noise(window, noise)
                self._slices = learning(
                    stacked([kept for kept, _ in self._kept]), noise=noise,
                    saturation=window.saturation, most_nodes=MOST_NODES,
                )
                self._kept.clear()

    def _begin(self, state: str) -> None:
        """Start anew."""
        self.state = state
        self._kept.clear()
        self._gains.clear()
        self._apart.clear()
        self._slices = self._candidate = None

    def _give_up(self, reason: str) -> None:
        """Try again later, and later each time."""
        self._wait = COLLECTED * (2 ** min(self._attempts, PATIENCE) - 1)
        self._attempts += 1
        self._begin(reason)

    def _keep(self, window: Window, found: Estimates) -> None:
        """Keep a window for learning; the oldest of the fullest phase goes."""
        self._kept.append((window, (float(found.x[0]), float(found.y[0]))))
        if len(self._kept) > COLLECTED:
            places = np.array([place for _, place in self._kept])
            cell = (np.mod(places, 1.0) * CELLS).astype(int) @ np.array([1, CELLS])
            count = np.bincount(cell)
            del self._kept[int(np.flatnonzero(count[cell] == count.max())[0])]
        self.state = f'collecting windows: {len(self._kept)} of {COLLECTED}'
        if len(self._kept) == COLLECTED:
            self.state += ', but not in all sub-pixel phases: let the target move over many pixels'

    def _gap(self) -> float:
        """Return the widest part of the pixel without a place, px."""
        x, y = np.array([place for _, place in self._kept]).T
        return max(gap_of(x), gap_of(y))

    def _learn(self) -> None:
        """Go on with learning."""
        assert self._slices is not None
        self.state = 'learning the pulse'
        try:
            for _ in range(SLICES):
                next(self._slices)
        except StopIteration as done:
            self._slices, self._candidate = None, done.value
        except LocationError as error:
            self._give_up(str(error))

    def _judge(
        self, candidate: Learned, window: Window, noise: SensorNoise, found: Estimates
    ) -> None:
        """Hold a pulse against what places the light now."""
        gain, x, y = _compared(candidate.pulse, window, noise, found)
        self._gains.append(gain)
        self._apart.append((x, y))
        self.state = f'judging the pulse: {len(self._gains)} of {JUDGED} windows'
        if len(self._gains) < JUDGED:
            return
        gains = np.array(self._gains)
        mean, error = float(gains.mean()), float(gains.std()) / math.sqrt(JUDGED)
        if mean > SURE_SIGMA * error:
            pulse = _aligned(candidate.pulse, np.array(self._apart))
            self._begin(f'learned from {candidate.windows} windows, which gain {mean:.2f} each')
            self.learned, self.pulse = replace(candidate, pulse=pulse, gain=mean), pulse
            self._attempts = 0
        else:
            self._give_up(
                'the light is located as well without its own pulse: with the one that was '
                f'learned, windows gain {mean:.2f} +- {error:.2f} in log-likelihood'
            )

    def _watch(
        self, learned: Learned, window: Window, noise: SensorNoise, base: Estimates
    ) -> None:
        """Hold the pulse that is used against what would be without it."""
        if not base.ok[0]:
            return
        self._gains.append(_compared(learned.pulse, window, noise, base)[0])
        last = list(self._gains)[-LAST:]
        if len(last) == LAST and float(np.mean(last)) < 0.0:
            self.pulse = self.learned = None
            self._begin('the pulse that was learned does not fit any longer: collecting windows')


def stacked(windows: list[Window]) -> list[Stack]:
    """Return the pixels of windows, all with an unlit one or all without, by their sizes."""
    sizes: dict[tuple[int, ...], list[Window]] = {}
    for window in windows:
        sizes.setdefault((*window.lit.shape, window.unlit is None), []).append(window)
    stacks: list[Stack] = []
    for alike in sizes.values():
        unlit = [each.unlit for each in alike if each.unlit is not None]
        stacks.append((
            np.stack([each.lit for each in alike]).astype(float),
            np.stack(unlit).astype(float) if unlit else None,
        ))
    return stacks


def compile_ahead() -> None:
    """Compile what learning needs, or load it: seconds that no light should wait for."""
    random = np.random.default_rng(1)
    span = np.arange(7) - 3.0
    places = random.uniform(-0.5, 0.5, (120, 2, 1))
    across, down = np.moveaxis(np.exp(-0.5 * (span - places) ** 2), 1, 0)
    lit = 30.0 + 100.0 * down[:, :, None] * across[:, None, :] + random.normal(0, 2, (120, 7, 7))
    dark = np.full_like(lit, 30.0)
    noise = SensorNoise(gain=10.0, read_noise=1.0)
    pulse = learn_pulse([(lit, dark)], noise=noise).pulse
    means = np.stack([dark[0] + 100.0 * pulse.image((7, 7), 3.0, 3.0), dark[0]])
    log_likelihood_of(Pair(lit[0], dark[0], noise, math.inf), means)


def _noise(window: Window, noise: SensorNoise) -> SensorNoise:
    """Return the noise of a pixel of the window."""
    read_noise = math.hypot(noise.read_noise, window.added_noise)
    return noise_of_sum(replace(noise, read_noise=read_noise), window.looks)


def _compared(
    pulse: EffectivePsf, window: Window, noise: SensorNoise, base: Estimates
) -> tuple[float, float, float]:
    """Return how much likelier a pulse makes a window, and where it has it beside the base, px."""
    noise = _noise(window, noise)
    level = noise.black_level
    noise = replace(noise, black_level=0.0)
    lit = _pixels(window.lit, level)
    unlit = None if window.unlit is None else _pixels(window.unlit, level)
    limit = math.inf if window.saturation is None else window.saturation - level
    told = pulse_of(pulse)
    found, _ = learned_pulse(lit, unlit, noise, limit, told)
    if not found.ok[0]:
        return -MOST_GAIN, math.nan, math.nan
    x, y = float(found.x[0]), float(found.y[0])
    if 0 in base.other_models:
        before, parameters = base.other_models[0]
        before -= 0.5 * parameters
        pair = Pair(lit[0], None if unlit is None else unlit[0], noise, limit)
        image = pulse.image(lit[0].shape, x, y, float(found.sigma[0]) / pulse.sigma)
        means = np.full(pair.pixels.shape, float(found.background[0]))
        means[0] += found.amplitude[0] * image
        now = log_likelihood_of(pair, means) - 0.5 * told.size
    else:
        usable = lit.size - int(base.saturated[0])
        before = -0.5 * (float(base.chi2[0]) - 1.0) * (usable - 5)
        now = -0.5 * (float(found.chi2[0]) - 1.0) * (usable - told.size)
    gain = min(max(now - before, -MOST_GAIN), MOST_GAIN)
    return gain, float(base.x[0]) - x, float(base.y[0]) - y


def _aligned(pulse: EffectivePsf, apart: NDArray[np.float64]) -> EffectivePsf:
    """
    Return the pulse about the centre that the places had so far, where that is another one.

    Parameters
    ----------
    pulse : EffectivePsf
        As learned.
    apart : (N, 2) array
        Of the places so far from those with the pulse, px; NaN if there are none.

    """
    apart = apart[np.isfinite(apart).all(axis=1)]
    centre = np.median(apart, axis=0)
    # Of a median; 1.48 of the median deviation is a standard deviation.
    error = 1.2533 * 1.4826 * np.median(np.abs(apart - centre), axis=0) / math.sqrt(len(apart))
    if not (np.abs(centre) > LOPSIDED_SIGMA * error).any():
        return pulse
    moved = shifted(pulse, *centre)
    return replace(moved, covariance=pulse.covariance + np.diag(error**2))


def _pixels(pixels: NDArray[np.generic], level: float) -> NDArray[np.float64]:
    """Return a stack of one window less the black level."""
    return np.ascontiguousarray(pixels, dtype=float)[None] - level

"""A window about which something is odd: the model that explains it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
import math

from blob_tracker.location.alternatives import Alternative, ALTERNATIVES
from blob_tracker.location.alternatives.streak import streak
from blob_tracker.location.coarse import coarse, fine, WIDEST
from blob_tracker.location.doubt import misfitting, sandwich
from blob_tracker.location.estimates import Failure
from blob_tracker.location.hypotheses import (
    choose, Fit, History, Motion, Pair, SWITCHED, Way,
)
from blob_tracker.location.pair_likelihood import Floats
from blob_tracker.location.pair_model import fill_one_pulse, no_pulse, one_pulse, to_fit
from blob_tracker.location.prospects import promising
from blob_tracker.location.relit import compile_relit
from blob_tracker.location.sites import blanked, pair_of
from blob_tracker.location.suspicion import Suspicion
from blob_tracker.location.unlit_pulse import hides_no_pulse, shows_pulse
from blob_tracker.location.unlit_shape import compile_shares
from blob_tracker.types import SensorNoise
import numpy as np

# Of the misfit of a round pulse: a model that leaves more is no more true than that one.
UNEXPLAINED = 0.5
ROUND_GHOSTS = ('ghost', 'smeared')  # the models of one in the unlit window
RESTING = 8  # parameters of a light with cut rows that rests, the texture's variance among them
ODD_GHOST = 2.0  # standard deviations of chi2, beyond which a round ghost may not be all


def explain(pair: Pair, theta: Floats | None, suspicion: int) -> Fit | None:
    """
    Return the fit of the alternative that the window speaks for; None if none is better.

    Parameters
    ----------
    pair : Pair
        The window.
    theta : (5,) array or None
        x, y, amplitude, background and sigma of its fit; None if it has none.
    suspicion : int
        What is odd about it, see `Suspicion`.

    """
    pair, theta = coarse(pair, theta)
    fit = _best(pair, theta, suspicion)
    return None if fit is None else fine(fit, pair.pitch)


def is_explained(
    lit: Floats, unlit: Floats | None, noise: SensorNoise, suspicion: int
) -> bool:
    """
    Tell at once whether all that is odd about a window is a texture that both frames show.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, as of `pair_of`.
    noise : SensorNoise
        Of a pixel.
    suspicion : int
        What is odd about it. Where this is true `explain` has no other answer than None, which
        takes it much longer.

    """
    if unlit is None or suspicion & ~Suspicion.IN_UNLIT or min(lit.shape) > WIDEST:
        return False
    return hides_no_pulse(lit, unlit, noise)


def _best(pair: Pair, theta: Floats | None, suspicion: int) -> Fit | None:
    """Do so at the pair's own pitch."""
    if pair.haunted and (pair.unlit is None or not shows_pulse(pair)):
        suspicion &= ~Suspicion.IN_UNLIT  # a texture, of which the base fit takes care
    if not suspicion or (suspicion == Suspicion.LOPSIDED and pair.unlit is None):
        return None  # what leans may be behind it
    asked = [one for one, answers in ALTERNATIVES.items() if suspicion & answers]
    if suspicion == Suspicion.LOPSIDED and theta is not None and pair.usable.all():
        likely = promising(pair, theta)
        asked = [one for one in asked if one in likely]
        if not asked:
            return None  # noise makes such a lean
    base = None
    optimum = None if theta is None else one_pulse(pair, theta)
    if optimum is not None:
        base = to_fit(pair, optimum)
    if base is None:
        base = no_pulse(pair)
    limit = 1.0 + ODD_GHOST * math.sqrt(2.0 / pair.pixels.size)
    fits = _fits(pair, base, [
        each for each in asked if ALTERNATIVES[each] & Suspicion.IN_UNLIT
    ])
    if any(
        fit.model == SWITCHED and fit.chi2 < limit and fit.parameters <= RESTING for fit in fits
    ):
        pair = replace(pair, haunted=False)  # that its rows are cut makes it another shape
    fits += _fits(pair, base, [
        each for each in asked if not ALTERNATIVES[each] & Suspicion.IN_UNLIT
    ])
    chosen = choose(base, fits, pair.pixels.size, pair.history)
    if suspicion & Suspicion.UNLIT and streak not in asked and (
        chosen.model not in ROUND_GHOSTS
        or chosen.chi2 > limit
    ):
        # What is left of a light that draws a streak does not look like a round one.
        fits += _fits(pair, base, [streak])
        chosen = choose(base, fits, pair.pixels.size, pair.history)
    if chosen is not base:
        if theta is None or chosen.failure != Failure.NONE or not chosen.misfit:
            return chosen
        if pair.clipped:
            # What runs from clipped pixels has many shapes; the round one's place is the surest.
            return None if optimum is None else misfitting(pair, optimum)
        if optimum is not None and chosen.chi2 - 1.0 > UNEXPLAINED * (base.chi2 - 1.0):
            return misfitting(pair, optimum)  # neither is true, and the round one is the surest
        # Not even the best model is true: the place may be the other one's.
        apart = np.array([chosen.x - base.x, chosen.y - base.y])
        return replace(
            chosen, covariance=chosen.covariance + np.outer(apart, apart),
            warning=(f'{chosen.warning}; ' if chosen.warning else '')
            + f'misfit (chi2 {chosen.chi2:.1f}): that is not all of it',
        )
    if optimum is None or pair.unlit is None or not suspicion & Suspicion.PIXELS:
        return None
    return misfitting(pair, optimum)


def _fits(pair: Pair, base: Fit, asked: Iterable[Alternative]) -> list[Fit]:
    """Return what those that are asked have to say."""
    fits = [
        replace(fit, model=alternative.__name__)
        for alternative in asked if (fit := alternative(pair, base)) is not None
    ]
    if pair.history.even:
        # What leans now to one side and now to the other is even about its place.
        fits = [fit for fit in fits if not fit.lopsided]
    return fits


@cache  # a node asks for it with each change of its parameters
def compile_alternatives() -> None:
    """Try every alternative once, so that all their loops over pixels are compiled or loaded."""
    bell = np.exp(-((np.arange(13) - 6.0) ** 2) / 4.0)
    pulse = 100.0 * bell[:, None] * bell[None, :]
    lit = np.round(pulse + 0.4 * np.roll(pulse, 2, axis=1) + np.roll(pulse, 1, axis=0) + 10.0)
    unlit = np.round(0.3 * np.roll(pulse, 1, axis=1) + 10.0)
    noise = SensorNoise(gain=1.0, read_noise=1.0)
    last = np.array([4.0, 6.0])  # which is not where it is now: what moves may be smeared
    history = History(Motion(np.array([2.0, 0.0]), 0.2), last=last)
    way = Way(np.array([2.0, 1.0]), 0.5, np.array([0.1, 0.1]))
    for pair in (
        Pair(lit, unlit, noise, math.inf, history), Pair(lit, None, noise, math.inf, history, way)
    ):
        optimum = one_pulse(pair, np.array([6.0, 6.0, 100.0, 10.0, 1.5]))
        base = no_pulse(pair)
        if optimum is not None:
            base = to_fit(pair, optimum)
            sandwich(pair, optimum, fill_one_pulse)
            if pair.unlit is not None:
                promising(pair, optimum.theta)
        for alternative in ALTERNATIVES:
            alternative(pair, base)
    compile_shares()
    compile_relit()
    hides_no_pulse(lit, unlit, noise)
    every_other = np.indices(lit.shape).sum(axis=0) % 2 == 0
    for samples in (lit, blanked(lit, every_other)):
        shows_pulse(pair_of(samples, unlit, noise, math.inf))

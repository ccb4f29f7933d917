"""A camera that averages its frames over time, so that the last flash is still in the pair."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.location.alternatives.ghost import first_guess, lamp_is_likelier
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.pair_likelihood import climb, Floats, Model
from blob_tracker.location.pair_model import (
    AMPLITUDE, bounds, BRIGHTEST, fill_smeared_ghost, GHOST, SHIFT_X, SHIFT_Y, to_fit, X, Y,
)
from blob_tracker.location.unlit_pulse import outdoes_texture
from blob_tracker.location.unlit_shape import BRIGHTER
import numpy as np

APART = 0.45  # px from the last flash, of which it must be more to tell its ghost's age
GONE = 5  # of the parameters: amplitude of what is left of the last flash


def smeared(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a pulse and what a recursive filter in time has kept of the last one.

    With out(t) = k out(t - 1) + (1 - k) in(t), the unlit window holds the share k of the last
    lit frame's pulse, and the lit window the share k of that. Only a light that moves tells that
    from one that is left in the unlit frame: the ghost is where the light was in the last flash,
    however it has moved since.

    The filter takes (1 - k) / (1 + k) off the variance of the noise that goes in: how much of the
    noise that is known there is, the residuals tell.
    """
    last = pair.history.last
    if pair.unlit is None or last is None:
        return None
    if math.hypot(base.x - last[0], base.y - last[1]) < APART:
        return None
    guess = first_guess(pair, base)
    lower, upper = bounds(pair)
    kept = climb(
        pair, _since(last), np.append(guess[:GONE], guess[GHOST]),
        np.append(lower, 0.0), np.append(upper, BRIGHTEST),
    )
    if kept is None or not outdoes_texture(pair, kept) or lamp_is_likelier(pair, guess, kept):
        return None
    share = float(kept.theta[GONE] / max(kept.theta[AMPLITUDE], 1e-6))
    if share > BRIGHTER:
        return None
    fit = to_fit(
        pair, kept,
        'the last flash is still in this pair of frames: the camera averages over time '
        f'(temporal noise reduction, {100.0 * share:.0f} % of the last frame): switch it off',
    )
    return replace(fit, covariance=kept.chi2 * fit.covariance)


def _since(last: Floats) -> Model:
    """Return the model whose ghost is where the light was in the last flash."""
    def fill(theta: Floats, means: Floats, slopes: Floats) -> None:
        whole = np.concatenate([theta[:GONE], last - theta[[X, Y]], theta[GONE:]])
        by_each = np.empty((whole.size, *means.shape))
        fill_smeared_ghost(whole, means, by_each)
        slopes[:GONE] = by_each[:GONE]
        slopes[[X, Y]] -= by_each[[SHIFT_X, SHIFT_Y]]
        slopes[GONE] = by_each[GHOST]

    return fill

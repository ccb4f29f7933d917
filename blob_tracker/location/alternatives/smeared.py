"""A camera that averages its frames over time, so that the last flash is still in the pair."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.location.alternatives.ghost import (
    first_guess, fit_ghost, lamp_is_likelier,
)
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.pair_model import AMPLITUDE, fill_smeared_ghost, GHOST, to_fit
from blob_tracker.location.unlit_pulse import outdoes_texture
from blob_tracker.location.unlit_shape import BRIGHTER
import numpy as np

LAST_FLASH = -1.0  # of a flash's displacement: where the light was in the last lit frame
APART = 3.0  # deviations of the motion, of which a flash must be more to tell its ghost's age


def smeared(pair: Pair, base: Fit) -> Fit | None:
    """
    Fit a pulse and what a recursive filter in time has kept of the last one.

    With out(t) = k out(t - 1) + (1 - k) in(t), the unlit window holds the share k of the last
    lit frame's pulse, and the lit window the share k of that. Only a light that moves, and
    whose motion is known, tells that from a light that is left in the unlit frame: the ghost is
    where the light was a whole flash ago, not half of one.

    The filter takes (1 - k) / (1 + k) off the variance of the noise that goes in: how much of the
    noise that is known there is, the residuals tell.
    """
    if pair.unlit is None or pair.motion is None:
        return None
    if np.hypot(*pair.motion.flash) < APART * pair.motion.deviation:
        return None
    start = first_guess(pair, base)
    kept = fit_ghost(pair, fill_smeared_ghost, start, LAST_FLASH)
    if kept is None or not outdoes_texture(pair, kept) or lamp_is_likelier(pair, start, kept):
        return None
    share = float(kept.theta[GHOST] / max(kept.theta[AMPLITUDE], 1e-6))
    if share > BRIGHTER:
        return None
    fit = to_fit(
        pair, kept,
        'the last flash is still in this pair of frames: the camera averages over time '
        f'(temporal noise reduction, {100.0 * share:.0f} % of the last frame): switch it off',
    )
    return replace(fit, covariance=kept.chi2 * fit.covariance)

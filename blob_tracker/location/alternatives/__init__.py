"""
What else may be true of a window than one round pulse: a file each.

An alternative is a function of a `Pair` and the base fit's parameters that returns its `Fit`, or
None if it has nothing to say. It answers to the suspicions that stand beside it here.
"""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.location.alternatives.defocused import defocused
from blob_tracker.location.alternatives.ghost import ghost
from blob_tracker.location.alternatives.glow import glow
from blob_tracker.location.alternatives.smeared import smeared
from blob_tracker.location.alternatives.streak import streak
from blob_tracker.location.alternatives.switched import switched
from blob_tracker.location.alternatives.tailed import tailed
from blob_tracker.location.alternatives.two_lights import two_lights
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.suspicion import Suspicion

Alternative = Callable[[Pair, Fit], 'Fit | None']

ALTERNATIVES: dict[Alternative, int] = {
    ghost: Suspicion.IN_UNLIT,
    smeared: Suspicion.IN_UNLIT,
    switched: Suspicion.IN_UNLIT,
    streak: Suspicion.AXES | Suspicion.ROWS | Suspicion.PIXELS | Suspicion.LOPSIDED,
    tailed: Suspicion.AXES | Suspicion.ROWS | Suspicion.PIXELS | Suspicion.LOPSIDED,
    two_lights: Suspicion.AXES | Suspicion.ROWS | Suspicion.PIXELS | Suspicion.LOPSIDED,
    defocused: Suspicion.PIXELS,
    glow: Suspicion.PIXELS | Suspicion.LOPSIDED,
}

__all__ = ['ALTERNATIVES', 'Alternative']

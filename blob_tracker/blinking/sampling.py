"""Samples of a likelihood that has no useful derivatives."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.kernel import Array
import numpy as np

WALKERS = 32
STEPS, SETTLING = 400, 150
STRETCH = 2.0  # greatest, as its authors have it


def spread(nats: Callable[[Array], Array], start: Array, steps: Array) -> Array:
    """
    Return (k, m) samples of a probability.

    By the stretch moves of Goodman and Weare, Comm. Appl. Math. Comp. Sci. 5 (2010), which need no
    scales: each walker is moved along the line to another one. The same numbers each time.

    Parameters
    ----------
    nats : callable
        Logarithm of the probability of each of (k, m) parameters, but for a constant.
    start : (m,) array
        Where it is high.
    steps : (m,) array
        About which the walkers begin.

    """
    random = np.random.default_rng(0)
    walkers = start + steps * random.standard_normal((WALKERS, len(start)))
    walkers[0] = start
    high = nats(walkers)
    # Walkers that began nowhere near begin where the start is.
    walkers[~np.isfinite(high)] = start
    high = nats(walkers)
    half = WALKERS // 2
    kept = []
    for step in range(STEPS):
        for own, other in ((slice(0, half), slice(half, None)), (slice(half, None), slice(half))):
            scale = (1.0 + (STRETCH - 1.0) * random.uniform(size=half)) ** 2 / STRETCH
            partner = walkers[other][random.integers(half, size=half)]
            moved = partner + scale[:, None] * (walkers[own] - partner)
            there = nats(moved)
            gain = (len(start) - 1) * np.log(scale) + there - high[own]
            taken = np.log(random.uniform(size=half)) < gain
            walkers[own] = np.where(taken[:, None], moved, walkers[own])
            high[own] = np.where(taken, there, high[own])
        if step >= SETTLING:
            kept.append(walkers.copy())
    return np.concatenate(kept)

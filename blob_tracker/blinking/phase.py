"""In which phase of which pattern a light is: a probability over all cells."""

from __future__ import annotations

import math

from blob_tracker.blinking.patterns import SHARE_LEVELS, SUB_CELLS, Tables
from blob_tracker.kernel import Array, kernel, written_into_kernels
import numpy as np
from numpy.typing import NDArray

Steps = NDArray[np.int64]

# Beside the patterns there are two cells more: of a light on at random, and of one always on
OTHERS = 2
PRIOR_PATTERNS, PRIOR_RANDOM, PRIOR_STEADY = 0.9, 0.05, 0.05
SEEN = 0.97  # of the lit frames of a light in view: now and then something passes before it
SEEN_AT_RANDOM = 0.5  # of all frames, of a light of no known pattern
# Of a light's flux, by which it changes from frame to frame: until it is known, and at least
SCINTILLATION, LEAST_SCINTILLATION = 0.03, 0.005
STRANGE = 0.03  # of the hits have another flux: a second light beside it, a reflection
# To either side in a frame: of 16 cells a frame interval a clock that is off by 1 % crosses 0.16
DIFFUSION = 0.1
# Of that, what a light with a name makes use of: it is learned where the phase is known so well
STEADIEST, LEARNED, KNOWN_CELLS = 1 / 32, 0.03, 4.0
LEAST_TOLD = 1e-3  # of that variance, that a look tells at least
NEAR_CELLS = 16  # to either side of the likeliest one: a frame interval
MOST_ELSEWHERE = 0.1  # of the probability, farther away than that
MOST_SURPRISE = 10.0  # times what the weights allow for
DOUBT = 1e-3  # of the probability is dealt out afresh in each frame: a new start is possible
UNLIKELY = 1e-5  # a weight that does not count where a mean is taken
# Of share: rms of the width of a look, 1/16 of half a frame, and how far from it it speaks
NEAR_SHARE, FAR_SHARE = 0.018, 0.04
NOTHING = 1e-12  # a probability that is none
SOFTNESS = 0.3  # of the least flux that is seen: how soft that limit is


@kernel
def fill_prior(first: NDArray[np.int64], weights: Array) -> None:
    """Fill the weights of a light of which nothing is known: all patterns alike."""
    cells = first[-1]
    patterns = first.size - 1
    for p in range(patterns):
        weights[first[p]:first[p + 1]] = PRIOR_PATTERNS / patterns / (first[p + 1] - first[p])
    weights[cells] = PRIOR_RANDOM
    weights[cells + 1] = PRIOR_STEADY


@kernel
def diffuse(
    first: NDArray[np.int64], prior: Array, weights: Array, only: int, wander: float
) -> None:
    """
    Let the phases drift apart for a frame: no clock is exact.

    `only` is the pattern of a light that has its name, and -1 of others: here and below the cells
    of other patterns are left alone, so that the cost does not grow with their number. `wander` is
    the part of DIFFUSION that the light makes use of, see `learned_wander`.
    """
    for p in range(first.size - 1):
        begin, end = first[p], first[p + 1]
        if only >= 0 and p != only:
            continue
        for c in range(begin, end):
            weights[c] += DOUBT * (prior[c] - weights[c])
        start, before = weights[begin], weights[end - 1]
        for c in range(begin, end):
            here = weights[c]
            after = start if c == end - 1 else weights[c + 1]
            weights[c] = here + wander * DIFFUSION * (before + after - 2.0 * here)
            before = here
    for c in range(first[-1], weights.size):
        weights[c] += DOUBT * (prior[c] - weights[c])


@kernel
def where(
    first: NDArray[np.int64], weights: Array, pattern: int, about: int
) -> tuple[int, float, float]:
    """
    Return the likeliest cell of a pattern, and mean and variance of the phase, cells from a cell.

    That cell is `about`, or the likeliest one where it is -1. The variance is infinite where the
    phase is elsewhere.
    """
    begin, end = first[pattern], first[pattern + 1]
    if about < 0:
        about = begin + int(np.argmax(weights[begin:end]))
    total, s1, s2 = 0.0, 0.0, 0.0
    count = end - begin
    cell = (about - begin - NEAR_CELLS) % count
    for away in range(-NEAR_CELLS, NEAR_CELLS + 1):
        part = weights[begin + cell]
        total += part
        s1 += part * away
        s2 += part * away * away
        cell = cell + 1 if cell + 1 < count else 0
    whole = 0.0
    for c in range(begin, end):
        whole += weights[c]
    if total <= (1.0 - MOST_ELSEWHERE) * whole:
        return about, 0.0, math.inf
    return about, s1 / total, s2 / total - (s1 / total) ** 2


@kernel
def learned_wander(
    wander: float, mean: float, variance: float, new_mean: float, new_variance: float
) -> float:
    """
    Return the wander after a look, of which mean and variance of the phase are told before it.

    In the mean the variance falls by the square of what the mean moves by: where it moves by less
    the phase drifts by less than it was said to.
    """
    fall = variance - new_variance
    if variance > KNOWN_CELLS**2 or fall < LEAST_TOLD * variance:
        return wander
    surprise = min((new_mean - mean) ** 2 / fall, MOST_SURPRISE) - 1.0
    return min(max(wander * math.exp(LEARNED * surprise), STEADIEST), 1.0)


@kernel
def seen(share_flux: float, least_flux: float) -> float:
    """Return the probability that so much light is detected."""
    away = (share_flux - least_flux) / (SOFTNESS * least_flux)
    return SEEN / (1.0 + math.exp(-1.7 * away)) if share_flux > 0.0 else 0.0


@kernel
def fill_hit(
    flux: float, flux_sigma: float, full: Array, least: float, out: Array, near: float = NEAR_SHARE
) -> None:
    """
    Fill the likelihood of a point of this flux for each level of the share.

    It is a density over flux in units of the full one: that of clutter is 1. `near` is the rms of
    the width of a look, where an edge runs through it.
    """
    mean, spread = full[0], full[1] ** 2 + full[2]
    for level in range(SHARE_LEVELS + 1):
        expected = mean * level / SHARE_LEVELS
        variance = flux_sigma**2 + expected**2 * spread
        if level < SHARE_LEVELS:  # an edge runs through it
            variance += (near * mean) ** 2
        density = mean * math.exp(-0.5 * (flux - expected) ** 2 / variance) / math.sqrt(
            2.0 * math.pi * variance
        )
        out[level] = seen(expected, least) * ((1.0 - STRANGE) * density + STRANGE)


@kernel
def fill_miss(full: Array, least: float, out: Array) -> None:
    """Fill the probability that nothing is seen for each level of the share."""
    for level in range(SHARE_LEVELS + 1):
        out[level] = 1.0 - seen(full[0] * level / SHARE_LEVELS, least)


@written_into_kernels
def _sub_cell(begin: int, at: int, count: int) -> int:
    """Return the row of the tables `at` looks, less than twice around, from a pattern's first."""
    return SUB_CELLS * begin + (at if at < count else at - count)


@kernel
def fill_steps(tables: Tables, clocks: Array, later: float, on: Steps) -> None:
    """
    Fill how many looks each pattern has gone on since the zero of its clock.

    `clocks` tell the time of the frame's first line, `later` is that of the line, frame intervals.
    """
    for p in range(on.size):
        looks = SUB_CELLS * (tables.first[p + 1] - tables.first[p])
        on[p] = math.floor(tables.rate[p] * (clocks[p] + later) + 0.5) % looks


@kernel
def fill_outlook(
    tables: Tables, on: Steps, weights: Array, only: int, outlook: Array
) -> None:
    """
    Fill what is to be seen in a frame; `on` is how many looks each pattern has gone on by then.

    `outlook` is (4, SHARE_LEVELS + 1): for each level of the share its probability, and the same
    times tau and tau^2, frame intervals, over the patterns; then the probability of OTHERS, which
    are seen in the middle of the exposure as far as one knows.
    """
    outlook[:] = 0.0
    for p in range(tables.first.size - 1):
        if only >= 0 and p != only:
            continue
        begin, end = tables.first[p], tables.first[p + 1]
        step = on[p]
        count = SUB_CELLS * (end - begin)
        for c in range(begin, end):
            weight = weights[c] / SUB_CELLS
            if weight < NOTHING:
                continue
            at = (SUB_CELLS * (c - begin) + step) % count
            for k in range(SUB_CELLS):
                place = _sub_cell(begin, at + k, count)
                level, tau = tables.level[place], tables.tau[place]
                outlook[0, level] += weight
                outlook[1, level] += weight * tau
                outlook[2, level] += weight * tau * tau
    cells = tables.first[-1]
    outlook[3, 0], outlook[3, 1] = weights[cells], weights[cells + 1]


@kernel
def of_random(full: float) -> float:
    """Return the likelihood of a hit for a light that is on at random: half keep their flux."""
    return SEEN_AT_RANDOM * 0.5 * (full / SEEN + 1.0)


@kernel
def judge_hit(outlook: Array, likelihood: Array, moments: Array) -> float:
    """
    Return the likelihood of a hit, and what it tells.

    Parameters
    ----------
    outlook, likelihood
        As `fill_outlook` and `fill_hit` fill them.
    moments : (5,) array
        Gets mean and variance of tau, in frame intervals, mean and variance of the share over the
        patterns, and their part of the likelihood.

    """
    total, t1, t2, s1, s2 = 0.0, 0.0, 0.0, 0.0, 0.0
    for level in range(SHARE_LEVELS + 1):
        part = outlook[0, level] * likelihood[level]
        total += part
        t1 += outlook[1, level] * likelihood[level]
        t2 += outlook[2, level] * likelihood[level]
        share = level / SHARE_LEVELS
        s1 += part * share
        s2 += part * share * share
    full = likelihood[SHARE_LEVELS]
    others = outlook[3, 0] * of_random(full) + outlook[3, 1] * full
    whole = max(total + others, NOTHING)
    moments[0] = t1 / whole
    moments[1] = max(t2 / whole - moments[0] ** 2, 0.0)
    moments[2] = s1 / max(total, NOTHING)
    moments[3] = max(s2 / max(total, NOTHING) - moments[2] ** 2, 0.0)
    moments[4] = total / whole
    return whole


@kernel
def expected_share(outlook: Array) -> float:
    """Return the mean share of a frame, over the patterns and a light that is always on."""
    mean = outlook[3, 1] + SEEN_AT_RANDOM * outlook[3, 0]
    for level in range(SHARE_LEVELS + 1):
        mean += outlook[0, level] * level / SHARE_LEVELS
    return mean


@kernel
def judge_miss(outlook: Array, likelihood: Array) -> float:
    """Return the probability that nothing is seen; `likelihood` is that of `fill_miss`."""
    total = outlook[3, 0] * (1.0 - SEEN_AT_RANDOM) + outlook[3, 1] * likelihood[SHARE_LEVELS]
    for level in range(SHARE_LEVELS + 1):
        total += outlook[0, level] * likelihood[level]
    return max(total, NOTHING)


@kernel
def weigh(
    tables: Tables, on: Steps, weights: Array, only: int, likelihood: Array, random: float,
    steady: float,
) -> float:
    """Multiply the cells by the likelihood of what was seen; return its sum over all of them."""
    total = 0.0
    for p in range(tables.first.size - 1):
        if only >= 0 and p != only:
            continue
        begin, end = tables.first[p], tables.first[p + 1]
        step = on[p]
        count = SUB_CELLS * (end - begin)
        at = step % count
        for c in range(begin, end):
            part = 0.0
            for k in range(SUB_CELLS):
                place = _sub_cell(begin, at + k, count)
                part += likelihood[tables.level[place]]
            at += SUB_CELLS
            if at >= count:
                at -= count
            weights[c] *= part / SUB_CELLS
            total += weights[c]
    cells = tables.first[-1]
    weights[cells] *= random
    weights[cells + 1] *= steady
    total += weights[cells] + weights[cells + 1]
    begin, end = (0, cells) if only < 0 else (tables.first[only], tables.first[only + 1])
    if total > 0.0:
        weights[begin:end] /= total
        weights[cells:] /= total
    return total


@kernel
def weigh_hit(
    tables: Tables, on: Steps, weights: Array, only: int, likelihood: Array
) -> float:
    """Take note of a point; `likelihood` is that of `fill_hit`."""
    full = likelihood[SHARE_LEVELS]
    return weigh(tables, on, weights, only, likelihood, of_random(full), full)


@kernel
def weigh_miss(
    tables: Tables, on: Steps, weights: Array, only: int, likelihood: Array
) -> float:
    """Take note that nothing was seen; `likelihood` is that of `fill_miss`."""
    return weigh(
        tables, on, weights, only, likelihood, 1.0 - SEEN_AT_RANDOM, likelihood[SHARE_LEVELS]
    )


@kernel
def refine(
    tables: Tables, on: Steps, weights: Array, only: int, share: float, share_sigma: float,
    moments: Array,
) -> None:
    """
    Correct the moments of tau and share by the share that was measured: it is finer than a cell.

    Where a light was switched within the exposure tau = +-(1 - s) E / 2, on its way from one look
    to the next a straight line in s: tau_i + (d tau / d s)_i (s - s_i). The sign is that of the
    phase; where it is not known both are in the variance. `weights` know of the hit already.
    """
    total, t1, t2, noise, s1, s2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    longest = 0.0
    for p in range(tables.first.size - 1):
        if only >= 0 and p != only:
            continue
        begin, end = tables.first[p], tables.first[p + 1]
        step = on[p]
        count = SUB_CELLS * (end - begin)
        for c in range(begin, end):
            if weights[c] < UNLIKELY:
                continue
            at = (SUB_CELLS * (c - begin) + step) % count
            for k in range(SUB_CELLS):
                place = _sub_cell(begin, at + k, count)
                slope = tables.slope[place]
                away = share - tables.share[place]
                near = share_sigma**2 + (NEAR_SHARE**2 if slope != 0.0 else 0.0)
                weight = weights[c] * math.exp(-0.5 * away * away / near) / math.sqrt(near)
                away = min(max(away, -FAR_SHARE), FAR_SHARE)
                tau = tables.tau[place] + slope * away
                longest = max(longest, abs(tables.tau[place]))
                total += weight
                t1 += weight * tau
                t2 += weight * tau * tau
                noise += weight * slope * slope * share_sigma**2 * NEAR_SHARE**2 / near
                s1 += weight * tables.share[place]
                s2 += weight * (
                    tables.share[place] ** 2 + (NEAR_SHARE**2 if slope != 0.0 else 0.0)
                )
    if total > UNLIKELY:
        moments[0] = t1 / total
        moments[1] = max(t2 / total - moments[0] ** 2, 0.0) + noise / total
        moments[2] = s1 / total
        moments[3] = max(s2 / total - moments[2] ** 2, 0.0)
    else:  # a flux that no phase explains: it was seen at any time
        moments[0] = 0.0
        moments[1] = longest * longest
        moments[4] = 0.0

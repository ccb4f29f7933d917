"""The rows of the tracker: what is thought of each light that may be there."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.blinking.motion import (
    begin, correct, learned_agility, mahalanobis, predict, project, STATE,
)
from blob_tracker.blinking.patterns import SHARE_LEVELS, Tables
from blob_tracker.blinking.phase import (
    fill_hit, fill_miss, learned_wander, LEAST_SCINTILLATION, OTHERS, refine, SCINTILLATION, Steps,
    weigh_hit, weigh_miss, where,
)
from blob_tracker.blinking.turns import counted_turns, fill_bend, LEAST_TURNS
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

KEPT = 3  # last points of a row: what shares two of them is one light
UNNAMED = -1
FIRST_SPREAD = 1.0  # of the flux: the first point may have been a small share of the full one
PHASE_KNOWN = 0.5  # probability of the patterns from which on their share tells the full flux
FLUX_DRIFT = 0.003  # of the full flux in a hit: 1 m/s nearer at 10 m, 60 Hz
WHOLE = 0.97  # of the exposure: from there on a change of the flux is the light's own
MISSED = 0.5  # a nat by which a miss is less likely than one in e: a growth of the agility
FLUX_FRAMES = 20.0  # over which that is averaged
DOUBTFUL = 0.15  # of the full flux, to which it is known after a surprise
BRIGHTER, BELIEVED = 1.15, 4.0  # times the full flux, and hits in a row that are: a surprise
FAINTER = 8  # hits in a row, none near the full flux, after which that was not the light's own
ALIKE = 0.1  # of the full flux, by which two that are the same differ at most
SURPRISE = 1.3  # of the full flux: what is brighter was taken for full while it was partly lit
# A child's kind
MISS, SMOOTH, TURN = 0, 1, 2
TURN_SPEED = 0.75  # of the speed, along each axis after a turn to anywhere
TURN_LEAST = 1.0  # px a frame interval: of a light that stood still
TURN_PLACE = 0.25  # of speed times gap: the turn was anywhere in it
# Columns of a point
X, Y, XX, XY, YY, FLUX, FLUX_SIGMA = range(7)


class Tracks(NamedTuple):
    """
    Rows of equal standing; several may be thoughts on one light.

    Parameters
    ----------
    state, covariance : (n, 6) and (n, 6, 6) arrays
        See `motion`: px, frame intervals.
    agility : (n,) array
        Part of the variance of its manoeuvres that a light makes use of, see `motion`.
    turns : (n,) array
        How many a light with a name makes in a frame interval, see `turns`.
    weights : (n, cells + OTHERS) array
        See `phase`.
    wander : (n,) array
        Part of DIFFUSION that a light makes use of, see `phase`.
    full : (n, 6) array
        Flux of the light in a whole exposure, its standard deviation over it, the variance over
        its square by which the flux changes from frame to frame, how many of the last hits
        were brighter; and while its phase is not known how many of them were fainter, and the
        brightest of those.
    score : (n,) array
        Log likelihood ratio over clutter.
    deficit : (n,) array
        Part of it since the last hit: what was due and not seen.
    name : (n,) int array
        Index of the pattern that it is published as, or UNNAMED.
    hits : (n,) int array
        Points that it has.
    points : (n, KEPT) int array
        Numbers of the last ones, the newest first; -1 if there is none.
    hit : (n, 6) array
        Of the last one: time, x, y and the variances xx, xy, yy of the filtered place.
    now : (n, 9) array
        Of this frame: index of its point or -1, tau and its variance, share and its variance,
        log likelihood ratio of the point over clutter, and what a turn may have added to the
        place: xx, xy, yy.

    """

    state: Array
    covariance: Array
    agility: Array
    turns: Array
    weights: Array
    wander: Array
    full: Array
    score: Array
    deficit: Array
    name: NDArray[np.int64]
    hits: NDArray[np.int64]
    points: NDArray[np.int64]
    hit: Array
    now: Array


def empty_tracks(count: int, cells: int) -> Tracks:
    """Return so many rows for patterns of so many cells."""
    return Tracks(
        np.zeros((count, STATE)), np.zeros((count, STATE, STATE)), np.ones(count),
        np.full(count, LEAST_TURNS), np.zeros((count, cells + OTHERS)), np.ones(count),
        np.zeros((count, 6)), np.zeros(count), np.zeros(count), np.full(count, UNNAMED),
        np.zeros(count, np.int64), np.full((count, KEPT), -1), np.zeros((count, 6)),
        np.zeros((count, 9)),
    )


@kernel
def copy_row(old: Tracks, row: int, new: Tracks, to: int) -> None:
    """Copy a row."""
    new.state[to] = old.state[row]
    new.covariance[to] = old.covariance[row]
    new.agility[to] = old.agility[row]
    new.turns[to] = old.turns[row]
    new.weights[to] = old.weights[row]
    new.wander[to] = old.wander[row]
    new.full[to] = old.full[row]
    new.score[to] = old.score[row]
    new.deficit[to] = old.deficit[row]
    new.name[to] = old.name[row]
    new.hits[to] = old.hits[row]
    new.points[to] = old.points[row]
    new.hit[to] = old.hit[row]
    new.now[to] = old.now[row]


@kernel
def start_row(
    new: Tracks, to: int, point: Array, index: int, number: int, score: float, speed: float,
    tables: Tables, prior: Array, on: Steps, clock: float, least: float, likelihood: Array,
) -> None:
    """Begin a row with a point of which nothing else is known."""
    begin(
        new.state[to], new.covariance[to], point[X], point[Y], point[XX], point[XY], point[YY],
        speed,
    )
    new.agility[to] = new.wander[to] = 1.0
    new.turns[to] = LEAST_TURNS
    new.full[to, 0], new.full[to, 1] = point[FLUX], FIRST_SPREAD
    new.full[to, 2], new.full[to, 3:] = SCINTILLATION**2, 0.0
    new.weights[to] = prior
    fill_hit(point[FLUX], point[FLUX_SIGMA], new.full[to], least, likelihood)
    weigh_hit(tables, on, new.weights[to], UNNAMED, likelihood)
    new.score[to] = score
    new.deficit[to] = 0.0
    new.name[to] = UNNAMED
    new.hits[to] = 1
    new.points[to] = -1
    new.now[to] = 0.0
    _note(new, to, index, number, clock)


@kernel
def miss_row(
    new: Tracks, to: int, gain: float, share: float, tables: Tables, on: Steps, least: float,
    likelihood: Array,
) -> None:
    """Take note in a row that it was not seen, where so much of the exposure was expected."""
    fill_miss(new.full[to], least, likelihood)
    name = new.name[to]
    about, mean, variance = _where(tables, new, to, -1)
    weigh_miss(tables, on, new.weights[to], name, likelihood)
    _learn_wander(tables, new, to, about, mean, variance)
    new.deficit[to] += gain
    # A light that is missing when it is due may have started to manoeuvre.
    new.agility[to] = min(new.agility[to] * np.exp(MISSED * max(-gain - 1.0, 0.0)), 1.0)
    new.now[to] = 0.0
    new.now[to, 0], new.now[to, 3] = -1.0, share


@kernel
def hit_row(
    new: Tracks, to: int, point: Array, index: int, number: int, alone: bool, kind: int,
    gain: float, moments: Array, tables: Tables, prior: Array, on: Steps, clock: float,
    least: float, exposure: float, likelihood: Array, work: Array,
) -> None:
    """
    Take note in a row of its point.

    `moments` are those of `judge_hit` for it, and get the finer tau. If it turned, its motion
    restarts at the last point. If it may not be `alone`, the point's flux is not its own.
    """
    state, covariance = new.state[to], new.covariance[to]
    vx, vy = state[2], state[3]
    gap, speed = clock - new.hit[to, 0], np.sqrt(vx * vx + vy * vy)
    # The position without a turn; tau is known better below.
    straight = project(state, covariance, moments[0])
    if kind == TURN:
        anywhere = (TURN_PLACE * speed * gap) ** 2
        begin(
            state, covariance, new.hit[to, 1], new.hit[to, 2], new.hit[to, 3] + anywhere,
            new.hit[to, 4], new.hit[to, 5] + anywhere, TURN_SPEED * speed + TURN_LEAST,
        )
        predict(state, covariance, gap, new.agility[to], work)
    fill_hit(point[FLUX], point[FLUX_SIGMA], new.full[to], least, likelihood)
    about, mean, variance = _where(tables, new, to, -1)
    weigh_hit(tables, on, new.weights[to], new.name[to], likelihood)
    _learn_wander(tables, new, to, about, mean, variance)
    full = new.full[to]
    share = min(point[FLUX] / full[0], 1.0)
    share_sigma = np.sqrt(
        (point[FLUX_SIGMA] / full[0]) ** 2 + share * share * (full[1] ** 2 + full[2])
    )
    if not alone:
        share_sigma = 1.0
    refine(tables, on, new.weights[to], new.name[to], share, share_sigma, moments)
    if alone and _weigh_flux(full, point, moments) and new.name[to] == UNNAMED:
        new.weights[to] = prior
    tau, spread = moments[0], moments[1]
    x, y, xx, xy, yy = project(state, covariance, tau)
    sxx, sxy = point[XX] + vx * vx * spread, point[XY] + vx * vy * spread
    syy = point[YY] + vy * vy * spread
    bend = new.now[to, 6:]
    bend[:] = 0.0
    if new.name[to] != UNNAMED:
        turned = fill_bend(
            point[X] - straight[0], point[Y] - straight[1],
            0.5 * (straight[2] + straight[4] + sxx + syy), speed, 0.5 * exposure * moments[2],
            gap, new.turns[to], bend,
        )
        new.turns[to] = counted_turns(new.turns[to], 1.0 if kind == TURN else turned, gap)
    dx, dy = point[X] - x, point[Y] - y
    sxx, sxy, syy = sxx + xx + bend[0], sxy + xy + bend[1], syy + yy + bend[2]
    new.agility[to] = learned_agility(
        new.agility[to], mahalanobis(dx, dy, sxx, sxy, syy)[0], (xx + yy) / (sxx + syy)
    )
    correct(state, covariance, tau, dx, dy, sxx, sxy, syy, work)
    new.deficit[to] = 0.0
    new.hits[to] += 1
    new.now[to, 1], new.now[to, 2] = tau, spread
    new.now[to, 3], new.now[to, 4], new.now[to, 5] = moments[2], moments[3], gain
    _note(new, to, index, number, clock)


@kernel
def _where(tables: Tables, new: Tracks, to: int, about: int) -> tuple[int, float, float]:
    """Return what `where` does, of a light that has its name."""
    if new.name[to] == UNNAMED:
        return -1, 0.0, 0.0
    return where(tables.first, new.weights[to], new.name[to], about)


@kernel
def _learn_wander(
    tables: Tables, new: Tracks, to: int, about: int, mean: float, variance: float
) -> None:
    """Take note of how far the phase of a light with a name moved in a look."""
    if about >= 0:
        _, new_mean, new_variance = _where(tables, new, to, about)
        new.wander[to] = learned_wander(
            new.wander[to], mean, variance, new_mean, new_variance
        )


@kernel
def _note(new: Tracks, to: int, index: int, number: int, clock: float) -> None:
    for k in range(KEPT - 1, 0, -1):
        new.points[to, k] = new.points[to, k - 1]
    new.points[to, 0] = number
    new.now[to, 0] = index
    new.hit[to, 0] = clock
    new.hit[to, 1], new.hit[to, 2] = new.state[to, 0], new.state[to, 1]
    new.hit[to, 3], new.hit[to, 4] = new.covariance[to, 0, 0], new.covariance[to, 0, 1]
    new.hit[to, 5] = new.covariance[to, 1, 1]


@kernel
def _weigh_flux(full: Array, point: Array, moments: Array) -> bool:
    """
    Correct the full flux; return whether it is another one, by which nothing was judged rightly.

    While the phase is not known it is the most that was seen, and uncertain until as much is seen
    again: shares are of any size, and two that are alike are whole. What is not seen again was
    more than the light, two that were one point, or the camera's gain has changed. Once the phase
    is known it is the mean of a Kalman filter that knows the share.
    """
    flux = point[FLUX]
    if flux > BRIGHTER * full[0] and moments[4] >= PHASE_KNOWN and full[1] < DOUBTFUL:
        full[3] += 1.0
        if full[3] < BELIEVED:
            return False  # something beside it
        full[1] = DOUBTFUL
    full[3] = 0.0
    if moments[4] < PHASE_KNOWN or flux > SURPRISE * full[0]:
        if BRIGHTER * flux < full[0]:
            full[4] += 1.0
            full[5] = max(full[5], flux)
            if full[4] >= FAINTER:
                full[0], full[1] = full[5], 0.5 * FIRST_SPREAD
                full[4:] = 0.0
                return True
            return False
        full[4:] = 0.0
        if abs(flux - full[0]) < ALIKE * full[0]:
            full[1] = max(0.5 * full[1], DOUBTFUL)
        elif flux > full[0]:
            full[1] = max(full[1], 0.5 * FIRST_SPREAD)
        full[0] = max(flux, full[0])
        return False
    full[4:] = 0.0
    share, spread = moments[2], moments[3]
    variance = (full[0] * full[1]) ** 2 + (FLUX_DRIFT * full[0]) ** 2
    noise = point[FLUX_SIGMA] ** 2 + full[0] ** 2 * (spread + full[2])
    expected = share * share * variance + noise
    gain = share * variance / expected
    mean = full[0] + gain * (flux - share * full[0])
    full[0] = max(mean, 0.5 * flux)
    full[1] = np.sqrt(max(variance * (1.0 - gain * share), 0.0)) / full[0]
    if share > WHOLE and spread < (1.0 - WHOLE) ** 2:
        changed = (flux / full[0] - 1.0) ** 2 - (point[FLUX_SIGMA] / full[0]) ** 2
        full[2] = max(full[2] + (changed - full[2]) / FLUX_FRAMES, LEAST_SCINTILLATION**2)
    return False


LEVELS = SHARE_LEVELS + 1

"""
How a gyro's rates go with what a still light does in the picture.

While the base turns by the small vector t (its own axes), the direction d of a light at rest moves
by -t x d. Across d, along e, that is

    e . (d1 - d0) = -(d x e)' A t + c dt

with t the integral of the gyro's rates over the interval, A what takes them to the true ones, and
c what the light itself and the gyro's bias do, the same all the time. A is the identity where all
is right; the others that are common are tried beside it.
"""

from __future__ import annotations

from itertools import permutations, product
from math import ceil, degrees, radians
from typing import NamedTuple

from blob_tracker.tracking.rotation import from_vector
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LONGEST_OFFSET_S = 0.2  # of the stamps: what `PlatformRates` holds
STEP_S = 0.01
FEWEST = 30  # intervals
LEAST_DEGREES = 3.0  # of axes that are off: worth a word beside another fault
TURNED_RAD = 1e-3  # rms of an interval, 10 mrad/s: less is no turning
FITS = 0.2  # of what moves in the picture: what may be left where the rates explain it
WORTH = 0.006  # of it, as by axes that are off by 4.5 degrees: less is no fault
HALVED = 2.0  # the remainder is so many times that of the better one, at least
# A more complicated fault must explain so much more, of what moves, than a simple one.
PENALTY = 0.003
REFINED = 12  # of the candidates that fit best: axes that are off make a wrong one seem better
WILD = 8.0  # times the median: a light that is another one, for once
STRAY = 6.0  # times the median of what is left: the same
LEAST_KEPT = 0.75  # of the moves: strays are few
ROUNDS = 6  # of the refinement of the turn
RIDGE = 1e-3  # of the normal matrix: turns that the motion does not tell stay 0


class Moves(NamedTuple):
    """
    How lights moved across the picture.

    Parameters
    ----------
    begin, end : (n,) arrays
        s.
    across : (n, 2, 3) array
        -(d x e) for two directions e across that of the light.
    moved : (n, 2) array
        e . (d1 - d0), rad.

    """

    begin: Array
    end: Array
    across: Array
    moved: Array


class GyroFault(NamedTuple):
    """
    What is wrong with a gyro's rates.

    Parameters
    ----------
    turn : (3, 3) array or None
        Takes the rates, scaled, to the true ones; of determinant -1 where its hand is wrong. None
        where no such explanation fits.
    scale : float
        By which the rates are to be multiplied.
    offset : float
        How late its stamps are, s; 0 where that is no fault.
    words : str
        The same in words.

    Examples
    --------
    A gyro that counts degrees, and a rate of it as it should be:

    >>> fault = GyroFault(
    ...     np.eye(3), scale=np.pi / 180.0, offset=0.0, words='its rates are in degrees/s'
    ... )
    >>> (fault.scale * fault.turn @ [90.0, 0.0, 0.0]).round(2).tolist()  # rad/s
    [1.57, 0.0, 0.0]

    """

    turn: Array | None
    scale: float
    offset: float
    words: str


class Fit(NamedTuple):
    """Whether the turning was enough to tell, and what is wrong; None if nothing is."""

    told: bool
    fault: GyroFault | None


def moves_of(times: Array, directions: Array, shortest: float, longest: float) -> Moves:
    """
    Return how a light moved.

    Parameters
    ----------
    times : (n,) array
        s, rising.
    directions : (n, 3) array
        Of the light in the base, of length 1.
    shortest, longest : float
        Of an interval, s.

    """
    begin, end = intervals_of(times, shortest, longest)
    before, after = directions[begin], directions[end]
    middle = before + after
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    least = np.eye(3)[np.abs(middle).argmin(axis=1)]
    first_axis = np.cross(middle, least)
    first_axis /= np.linalg.norm(first_axis, axis=1)[:, None]
    axes = np.stack([first_axis, np.cross(middle, first_axis)], axis=1)
    return Moves(
        times[begin], times[end],
        -np.cross(middle[:, None], axes),
        np.einsum('nki,ni->nk', axes, after - before),
    )


def intervals_of(
    times: Array, shortest: float, longest: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """
    Return the first and the last instant of intervals, each as short as may be.

    Parameters
    ----------
    times : (n,) array
        s, rising.
    shortest, longest : float
        Of an interval, s.

    """
    first, pairs = 0, []
    for last in range(1, len(times)):
        passed = times[last] - times[first]
        if passed >= shortest:
            if passed <= longest:
                pairs.append((first, last))
            first = last
    begin, end = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    return begin, end


def fit_gyro(moves: Moves, times: Array, rates: Array) -> Fit:
    """
    Compare a gyro with the picture.

    Parameters
    ----------
    moves : Moves
        Of lights.
    times : (m,) array
        Of the gyro's samples, s, rising.
    rates : (m, 3) array
        In the base's axes, rad/s, as they are taken for.

    """
    moves = _sound(moves, times)
    steps = 0.5 * (rates[1:] + rates[:-1]) * np.diff(times)[:, None]
    angles = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    fewest = max(FEWEST, ceil(LEAST_KEPT * len(moves.begin)))
    found, kept = Fit(False, None), moves
    while not found.told and len(kept.begin) >= fewest:
        found, left = _fit(kept, times, angles)
        # A light that is another one for once hides from the size of its move, not from the fit.
        good = left <= STRAY * np.median(left)
        if good.all():
            break
        kept = Moves(*(each[good] for each in kept))
    return found


def _fit(moves: Moves, times: Array, angles: Array) -> tuple[Fit, Array]:
    """Return the fit to moves, and what the best explanation leaves of each, rad."""
    offsets = np.arange(-round(LONGEST_OFFSET_S / STEP_S), round(LONGEST_OFFSET_S / STEP_S) + 1)
    regressions = [_regression(moves, times, angles, STEP_S * each) for each in offsets]
    moments = [_moments(*each) for each in regressions]
    left = np.array([
        each.square + ((CANDIDATES @ each.normal - 2.0 * each.shared) * CANDIDATES).sum(axis=1)
        for each in moments
    ])
    now = offsets.tolist().index(0)
    without, right = moments[now].square, left[now, 0]
    if not without > 0.0:
        return Fit(False, None), np.zeros(len(moves.begin))
    penalised = left + PENALTY * without * (COMPLICATED + (offsets != 0)[:, None])
    places, tried = penalised.argmin(axis=0), []
    for candidate in penalised.min(axis=0).argsort()[:REFINED]:
        place, chosen = int(places[candidate]), CANDIDATES[candidate]
        turn = _refined(moments[place], chosen)
        best = _left(moments[place], (turn @ chosen.reshape(3, 3)).ravel())
        extra = penalised[place, candidate] - left[place, candidate]
        tried.append((best + extra, candidate, place, turn, best))
    _, candidate, place, turn, best = min(tried, key=lambda each: each[0])
    at, chosen = moments[place], CANDIDATES[candidate]
    regressors, moved = regressions[place]
    of_each = np.hypot(*(moved - regressors @ (turn @ chosen.reshape(3, 3)).ravel()).T)
    felt = at.square - best
    if best <= FITS * without and felt >= len(moves.begin) * TURNED_RAD**2:
        if right < best + WORTH * without or right < HALVED * best:
            return Fit(True, None), of_each
        offset = _between(STEP_S * offsets.astype(float), left[:, candidate], place)
        return Fit(True, _fault(turn, chosen, offset)), of_each
    # Nothing goes with it, and it would be better not to have it.
    claimed = CANDIDATES[0] @ moments[now].normal @ CANDIDATES[0]
    if right > HALVED * without and claimed >= len(moves.begin) * TURNED_RAD**2:
        words = 'what it says has nothing to do with how the picture moves'
        return Fit(True, GyroFault(None, 1.0, 0.0, words)), of_each
    return Fit(False, None), of_each


class _Moments(NamedTuple):
    """Of the regression, without the part that is the same all the time."""

    normal: Array
    shared: Array
    square: float


def _sound(moves: Moves, times: Array) -> Moves:
    """Return the moves that the gyro covers, at any offset, and that are not wild."""
    size = np.hypot(*moves.moved.T)
    good = (moves.begin >= times[0] + LONGEST_OFFSET_S) if len(times) else np.zeros(0, bool)
    if not good.any():
        return Moves(*(each[:0] for each in moves))
    good &= moves.end <= times[-1] - LONGEST_OFFSET_S
    good &= size <= WILD * np.median(size)
    return Moves(*(each[good] for each in moves))


def _regression(
    moves: Moves, times: Array, angles: Array, offset: float
) -> tuple[Array, Array]:
    """Return (n, 2, 9) and (n, 2) for stamps of the gyro that are late by so much, s."""
    turned = np.stack([
        np.interp(moves.end + offset, times, each) - np.interp(moves.begin + offset, times, each)
        for each in angles.T
    ], axis=1)
    regressors = (moves.across[..., None] * turned[:, None, None, :]).reshape(len(turned), 2, 9)
    passed = moves.end - moves.begin
    passed = passed / np.linalg.norm(passed)
    regressors = regressors - passed[:, None, None] * np.tensordot(passed, regressors, 1)
    return regressors, moves.moved - passed[:, None] * (passed @ moves.moved)


def _moments(regressors: Array, moved: Array) -> _Moments:
    """Return the moments of a regression."""
    rows = regressors.reshape(-1, 9)
    return _Moments(rows.T @ rows, rows.T @ moved.ravel(), float((moved**2).sum()))


def _left(moments: _Moments, a: Array) -> float:
    """Return the sum of squares that is left by A, its rows one after the other."""
    return float(moments.square - 2.0 * a @ moments.shared + a @ moments.normal @ a)


def _refined(moments: _Moments, candidate: Array) -> Array:
    """Return the turn that is to follow a candidate, by Gauss-Newton."""
    matrix, turn = candidate.reshape(3, 3), np.eye(3)
    for _ in range(ROUNDS):
        a = turn @ matrix
        jacobian = np.stack([np.cross(axis, a.T).T.ravel() for axis in np.eye(3)], axis=1)
        normal = jacobian.T @ moments.normal @ jacobian
        gradient = jacobian.T @ (moments.shared - moments.normal @ a.ravel())
        ridge = RIDGE * np.trace(normal) * np.eye(3)
        step = np.linalg.solve(normal + ridge, gradient)
        turn = from_vector(*np.clip(step, -0.5, 0.5).tolist()) @ turn
    return turn


def _between(offsets: Array, left: Array, place: int) -> float:
    """Return the offset of the least, by a parabola through its neighbours, s."""
    if not 0 < place < len(offsets) - 1:
        return float(offsets[place])
    before, least, after = left[place - 1:place + 2]
    bend = before - 2.0 * least + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(offsets[place] + STEP_S * np.clip(shift, -0.5, 0.5))


def _fault(turn: Array, candidate: Array, offset: float) -> GyroFault:
    """Return a fault with its words."""
    scale = float(np.linalg.norm(candidate) / np.sqrt(3.0))
    axes = candidate.reshape(3, 3) / scale
    words = []
    if scale != 1.0:
        words.append('its rates are in degrees/s')
    if (axes == -np.eye(3)).all():
        words.append('its rates have the wrong sign')
    elif (axes != np.eye(3)).any():
        rows = [
            f'{name} is {"-" if row.min() < 0.0 else ""}{"xyz"[int(np.abs(row).argmax())]}'
            for name, row in zip('xyz', axes)
        ]
        words.append(
            f"its axes are others: of the camera's, as they are taken for, {', '.join(rows)}"
        )
    angle = degrees(np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)))
    if angle >= LEAST_DEGREES:
        words.append(f'its axes are off by {angle:.0f} degrees')
    if abs(offset) >= 0.5 * STEP_S:
        late = 'late' if offset > 0.0 else 'early'
        words.append(f'its stamps are {1e3 * abs(offset):.0f} ms {late}')
    return GyroFault(
        turn @ axes, scale, offset if abs(offset) >= 0.5 * STEP_S else 0.0, ' and '.join(words)
    )


def _candidates() -> tuple[Array, Array]:
    """Return what rates are taken for by mistake, (k, 9), and how complicated each is."""
    found = []
    for scale, order, signs in product(
        (1.0, radians(1.0)), permutations(range(3)), product((1.0, -1.0), repeat=3)
    ):
        matrix = scale * np.diag(signs)[:, order]
        sorted_ = order == (0, 1, 2)
        complicated = 0.0 if sorted_ and len(set(signs)) == 1 else 2.0 if sorted_ else 3.0
        if sorted_ and set(signs) == {-1.0}:
            complicated = 1.0
        found.append((complicated + (scale != 1.0), matrix.ravel()))
    found.sort(key=lambda each: each[0])
    return np.array([each for _, each in found]), np.array([each for each, _ in found])


CANDIDATES, COMPLICATED = _candidates()

"""Which point is which light's: children of each row, claims of the named ones, and the best."""

from __future__ import annotations

from blob_tracker.blinking.children import bear, Children, explain, Room, Settings
from blob_tracker.blinking.motion import predict
from blob_tracker.blinking.patterns import Tables
from blob_tracker.blinking.phase import diffuse, fill_steps
from blob_tracker.blinking.tracks import (
    copy_row, hit_row, miss_row, SMOOTH, start_row, Tracks, UNNAMED, Y,
)
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

FIRST_SCORE = -3.0  # of a point: few are the first of a light
LOWEST_SCORE, HIGHEST_SCORE = -9.0, 40.0  # nats; the latter of a light with a name
SETTLED = 0.9  # probability that a light is always on: it explains its point
FAR_BEHIND = 10.0  # nats behind the best thought on a light
THOUGHTS = 4  # on a light that is named


@kernel
def step(
    old: Tracks, count: int, new: Tracks, points: Array, number: int, tables: Tables, prior: Array,
    clocks: Array, line: float, clock: float, dt: float, settings: Settings, children: Children,
    room: Room, most: int,
) -> tuple[int, int]:
    """
    Take the points of the next frame.

    Parameters
    ----------
    old : Tracks
        The rows; they are moved on to the frame.
    count : int
        How many there are.
    new : Tracks
        Gets the rows after it.
    points : (n, 7) array
        See `POINT`.
    number : int
        Of the first point.
    tables, prior
        The patterns, and the weights of a light of which nothing is known.
    clocks : (p,) array
        Time of each pattern, frame intervals.
    line : float
        From the exposure of a line to that of the next, frame intervals.
    clock, dt : float
        Time, and time since the last frame, frame intervals; as `clocks` of the first line.
    settings : Settings
        What the association is told.
    children, room
        Working space.
    most : int
        Rows without a name, at most.

    Returns
    -------
    int, int
        Rows of `new`, and points that no named light has claimed.

    """
    for row in range(count):
        predict(old.state[row], old.covariance[row], dt, old.agility[row], room.matrix)
        diffuse(tables.first, prior, old.weights[row], old.name[row], old.wander[row])
    names = tables.first.size - 1
    owner = np.full(points.shape[0], UNNAMED)
    explained = np.zeros(points.shape[0], np.bool_)
    for row in range(count):
        if old.name[row] == UNNAMED and old.weights[row, tables.first[-1] + 1] > SETTLED:
            explain(old, row, points, explained)
    born = 0
    for row in range(count):
        if old.name[row] != UNNAMED:
            born = bear(
                old, row, points, owner, explained, tables, clocks, line, clock, settings,
                children, born, room,
            )
    _claim(old, children, born, names, owner)
    alone = _alone(old, children, born, points.shape[0])
    named = born
    for row in range(count):
        if old.name[row] == UNNAMED:
            born = bear(
                old, row, points, owner, explained, tables, clocks, line, clock, settings,
                children, born, room,
            )
    filled, unclaimed = 0, 0
    best = np.full(names, -np.inf)
    for part in range(2):
        begin, end = (0, named) if part == 0 else (named, born)
        limit = new.score.size if part == 0 else min(filled + most, new.score.size)
        for child in begin + np.argsort(-children.score[begin:end]):
            if filled < limit and _is_worth(old, new, filled, children, child, owner, number, best,
                                            clock, settings):
                name = old.name[children.parent[child]]
                if name != UNNAMED:
                    children.score[child] -= max(best[name] - HIGHEST_SCORE, 0.0)
                _grow(old, new, filled, children, child, points, number, alone, tables, prior,
                      clocks, line, clock, settings, room)
                filled += 1
    for each in range(points.shape[0]):
        if owner[each] != UNNAMED:
            continue
        unclaimed += 1
        if not explained[each] and filled < new.score.size:
            fill_steps(tables, clocks, line * points[each, Y], room.on)
            start_row(
                new, filled, points[each], each, number + each, FIRST_SCORE, settings.speed,
                tables, prior, room.on, clock, settings.least, room.likelihood,
            )
            filled += 1
    return filled, unclaimed


@kernel
def _claim(
    old: Tracks, children: Children, born: int, names: int, owner: NDArray[np.int64]
) -> None:
    """Give each named light the point of its best child; first to whom it is worth the most."""
    unseen = np.full(names, -np.inf)
    for child in range(born):
        if children.point[child] < 0:
            name = old.name[children.parent[child]]
            unseen[name] = max(unseen[name], children.score[child])
    done = np.zeros(names, np.bool_)
    best, which = np.empty(names), np.empty(names, np.int64)
    for _ in range(names):
        best[:], which[:] = -np.inf, -1
        for child in range(born):
            point = children.point[child]
            if point >= 0 and owner[point] == UNNAMED:
                name = old.name[children.parent[child]]
                if children.score[child] > best[name]:
                    best[name], which[name] = children.score[child], child
        most, whose = -np.inf, -1
        for name in range(names):
            if not done[name] and which[name] >= 0 and best[name] > unseen[name]:
                if best[name] - unseen[name] > most:
                    most, whose = best[name] - unseen[name], name
        if whose < 0:
            return
        owner[children.point[which[whose]]] = whose
        done[whose] = True


@kernel
def _alone(
    old: Tracks, children: Children, born: int, points: int
) -> NDArray[np.bool_]:
    """Tell of which points no two named lights may be: two that meet are one point."""
    alone, whose = np.ones(points, np.bool_), np.full(points, UNNAMED)
    for child in range(born):
        point, name = children.point[child], old.name[children.parent[child]]
        if point >= 0 and children.kind[child] == SMOOTH:
            alone[point] &= whose[point] == UNNAMED or whose[point] == name
            whose[point] = name
    return alone


@kernel
def _is_worth(
    old: Tracks, new: Tracks, filled: int, children: Children, child: int,
    owner: NDArray[np.int64], number: int, best: Array, clock: float, settings: Settings,
) -> bool:
    """Tell whether a child is a row of its own; they come in the order of their scores."""
    row, point = children.parent[child], children.point[child]
    name, score = old.name[row], children.score[child]
    if point >= 0 and owner[point] != name:
        return False
    if point < 0:
        unseen = clock - old.hit[row, 0]
        if unseen > (settings.longest if name == UNNAMED else settings.lost):
            return False
    if score < (LOWEST_SCORE if name == UNNAMED else max(0.0, best[name] - FAR_BEHIND)):
        return False
    last = old.points[row, 0] if point < 0 else number + point
    before = old.points[row, 1] if point < 0 else old.points[row, 0]
    further = old.points[row, 2] if point < 0 else old.points[row, 1]
    thoughts = 0
    for each in range(filled):
        if new.name[each] != name:
            continue
        thoughts += 1
        first, second, third = new.points[each]
        if first == last and second == before:
            return False
        # A better thought on the same light.
        if name == UNNAMED and score < new.score[each] - FAR_BEHIND and (
            last in (first, second, third) or (before >= 0 and before in (first, second, third))
            or (further >= 0 and further in (first, second, third))
        ):
            return False
    if name != UNNAMED:
        if thoughts == THOUGHTS:
            return False
        best[name] = max(best[name], score)
    return True


@kernel
def _grow(
    old: Tracks, new: Tracks, to: int, children: Children, child: int, points: Array, number: int,
    alone: NDArray[np.bool_], tables: Tables, prior: Array, clocks: Array, line: float,
    clock: float, settings: Settings, room: Room,
) -> None:
    """Make a child a row."""
    row, point, gain = children.parent[child], children.point[child], children.gain[child]
    y = old.state[row, 1] if point < 0 else points[point, Y]
    fill_steps(tables, clocks, line * y, room.on)
    copy_row(old, row, new, to)
    new.score[to] = children.score[child]
    if point < 0:
        miss_row(
            new, to, gain, children.moments[child, 2], tables, room.on, settings.least,
            room.likelihood,
        )
    else:
        hit_row(
            new, to, points[point], point, number + point, alone[point], children.kind[child],
            gain, children.moments[child], tables, prior, room.on, clock, settings.least,
            settings.exposure, room.likelihood, room.matrix,
        )

"""What may become of each row: unseen, or seen in a point in its reach."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.blinking.motion import mahalanobis, project
from blob_tracker.blinking.patterns import Tables
from blob_tracker.blinking.phase import (
    expected_share, fill_hit, fill_miss, fill_outlook, fill_steps, judge_hit, judge_miss, Steps,
)
from blob_tracker.blinking.tracks import (
    FLUX, FLUX_SIGMA, MISS, SMOOTH, Tracks, TURN, TURN_LEAST, TURN_SPEED, UNNAMED, X, XX, XY, Y,
    YY,
)
from blob_tracker.blinking.turns import TURNS
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

GATE = 18.4  # chi-square of two degrees of freedom that one in 10,000 exceeds
TURN_GATE = 9.0  # the same of a turn: the spread is that of all directions
COARSE = 5.0  # standard deviations in a look at the distance alone
TURN_HITS = 3  # a row has before it may turn: before it has no velocity
OWNED = 6.0  # nats that a point is the less likely a turn's where a settled light explains it


class Settings(NamedTuple):
    """
    What the association is told.

    Parameters
    ----------
    density : float
        Clutter, points a px^2.
    least : float
        Flux at which half of the points are seen.
    speed : float
        Of a light of which nothing is known, along each axis, px a frame interval.
    longest : float
        For which a light without a name may be dark, frame intervals.
    lost : float
        For which one with a name may be unseen, frame intervals.
    exposure : float
        Of a frame, frame intervals.

    """

    density: float
    least: float
    speed: float
    longest: float
    lost: float
    exposure: float


class Children(NamedTuple):
    """What each row may become: parent, point (-1: none), kind, score, gain and `moments`."""

    parent: NDArray[np.int64]
    point: NDArray[np.int64]
    kind: NDArray[np.int64]
    score: Array
    gain: Array
    moments: Array


class Room(NamedTuple):
    """Working space of the kernels: matrix, outlook, likelihood, moments, on."""

    matrix: Array
    outlook: Array
    likelihood: Array
    moments: Array
    on: Steps


@kernel
def explain(old: Tracks, row: int, points: Array, explained: NDArray[np.bool_]) -> None:
    """Mark the point that a settled light without a name has: a lamp, a light of another code."""
    x, y, xx, xy, yy = project(old.state[row], old.covariance[row], 0.0)
    nearest, which = GATE, -1
    for each in range(points.shape[0]):
        point = points[each]
        distance, _ = mahalanobis(
            point[X] - x, point[Y] - y, xx + point[XX], xy + point[XY], yy + point[YY]
        )
        if distance < nearest:
            nearest, which = distance, each
    if which >= 0:
        explained[which] = True


@kernel
def bear(
    old: Tracks, row: int, points: Array, owner: NDArray[np.int64], explained: NDArray[np.bool_],
    tables: Tables, clocks: Array, line: float, clock: float, settings: Settings,
    children: Children, born: int, room: Room,
) -> int:
    """Write down what may become of a row: unseen, or seen in one of the points in its reach."""
    outlook, likelihood, moments, on = room.outlook, room.likelihood, room.moments, room.on
    fill_steps(tables, clocks, line * old.state[row, 1], on)
    fill_outlook(tables, on, old.weights[row], old.name[row], outlook)
    fill_miss(old.full[row], settings.least, likelihood)
    moments[:] = 0.0
    moments[2] = expected_share(outlook)
    born = _add(children, born, row, -1, MISS, old, math.log(judge_miss(outlook, likelihood)),
                moments)
    state, covariance, last = old.state[row], old.covariance[row], old.hit[row]
    vx, vy = state[2], state[3]
    speed = math.sqrt(vx * vx + vy * vy)
    # A turn: from the last point to all sides.
    gap = clock - last[0]
    way = (TURN_SPEED * speed + TURN_LEAST) * gap
    reach = COARSE * math.sqrt(covariance[0, 0] + covariance[1, 1]) + 0.5 * speed
    for each in range(points.shape[0]):
        if owner[each] != UNNAMED:
            continue
        point = points[each]
        own = 3.0 * math.sqrt(point[XX] + point[YY])
        dx, dy = point[X] - state[0], point[Y] - state[1]
        near = math.sqrt(dx * dx + dy * dy) < reach + own
        tx, ty = point[X] - last[1], point[Y] - last[2]
        turns = old.hits[row] >= TURN_HITS and math.sqrt(tx * tx + ty * ty) < 3.0 * way + own
        if not (near or turns):
            continue
        fill_hit(point[FLUX], point[FLUX_SIGMA], old.full[row], settings.least, likelihood)
        seen = math.log(judge_hit(outlook, likelihood, moments) / settings.density)
        if near:
            x, y, xx, xy, yy = project(state, covariance, moments[0])
            distance, determinant = mahalanobis(
                point[X] - x, point[Y] - y, xx + point[XX] + vx * vx * moments[1],
                xy + point[XY] + vx * vy * moments[1], yy + point[YY] + vy * vy * moments[1],
            )
            if distance < GATE:
                gain = seen + math.log(1.0 - TURNS) - 0.5 * distance - math.log(
                    2.0 * math.pi * math.sqrt(determinant)
                )
                born = _add(children, born, row, each, SMOOTH, old, gain, moments)
                continue
        if turns:
            distance, determinant = mahalanobis(
                tx, ty, way * way + last[3] + point[XX], last[4] + point[XY],
                way * way + last[5] + point[YY],
            )
            if distance < TURN_GATE:
                gain = seen + math.log(TURNS) - 0.5 * distance - math.log(
                    2.0 * math.pi * math.sqrt(determinant)
                ) - (OWNED if explained[each] else 0.0)
                born = _add(children, born, row, each, TURN, old, gain, moments)
    return born


@kernel
def _add(
    children: Children, born: int, row: int, point: int, kind: int, old: Tracks, gain: float,
    moments: Array,
) -> int:
    """Write down a child where there is room; return how many there are."""
    if born == children.score.size:
        return born
    children.parent[born], children.point[born], children.kind[born] = row, point, kind
    children.score[born] = old.score[row] + gain
    children.gain[born] = gain
    children.moments[born] = moments
    return born + 1

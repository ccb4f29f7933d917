"""Who is who: one track a name, and a name for none that is not sure."""

from __future__ import annotations

from blob_tracker.blinking.tracks import Tracks, UNNAMED
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

CONFIRMING_SCORE = 8.0  # nats over clutter
CONFIRMING_HITS = 3
SURE = 0.97  # probability of a pattern from which on a light has its name
STRANGE = 0.9  # probability from which on a light blinks at random
DOUBTED = 0.3  # probability of it below which it loses it
COASTING = 3.0  # nats that a light has missed: another one may have its name
CLEAR = 3.0  # nats between the best thought on a light and the next one of another place


@kernel
def probability(first: NDArray[np.int64], weights: Array, pattern: int) -> float:
    """Return the probability of a pattern in any phase."""
    return float(weights[first[pattern]:first[pattern + 1]].sum())


@kernel
def give_names(
    first: NDArray[np.int64], prior: Array, tracks: Tracks, count: int, keep: NDArray[np.bool_]
) -> None:
    """
    Name the rows that are sure of their pattern, and unname those that are no longer.

    `keep` gets which rows go on: what shares its last point with a light that got its name was a
    thought on the same light.
    """
    keep[:count] = True
    names, cells = first.size - 1, first[-1]
    strangers = 0
    for row in range(count):
        strangers += (
            tracks.name[row] == UNNAMED and tracks.score[row] > CONFIRMING_SCORE
            and tracks.weights[row, cells] > STRANGE
        )
    # Of many that blink at random one looks like a light by chance.
    sure = 1.0 - (1.0 - SURE) / (1.0 + strangers) ** 2
    for row in range(count):
        name = tracks.name[row]
        if name != UNNAMED and probability(first, tracks.weights[row], name) < DOUBTED:
            tracks.name[row] = UNNAMED
            tracks.weights[row] = prior
    for row in np.argsort(-tracks.score[:count]):
        if (
            not keep[row] or tracks.name[row] != UNNAMED or tracks.hits[row] < CONFIRMING_HITS
            or tracks.score[row] < CONFIRMING_SCORE
        ):
            continue
        for name in range(names):
            if probability(first, tracks.weights[row], name) > sure:
                _take_name(first, tracks, count, row, name, keep)
                break


@kernel
def _take_name(
    first: NDArray[np.int64], tracks: Tracks, count: int, row: int, name: int,
    keep: NDArray[np.bool_],
) -> None:
    """Name a row, unless another light that was seen when it was due has that name."""
    best = -1
    for other in range(count):
        if keep[other] and tracks.name[other] == name and (
            best < 0 or tracks.score[other] > tracks.score[best]
        ):
            best = other
    if best >= 0 and tracks.deficit[best] > -COASTING:
        return
    for other in range(count):
        if other == row:
            continue
        if tracks.name[other] == name or (
            tracks.name[other] == UNNAMED and tracks.points[other, 0] == tracks.points[row, 0]
        ):
            keep[other] = False
    tracks.name[row] = name
    # What is left to other patterns is left to chance: see `diffuse`.
    weights, cells = tracks.weights[row], first[-1]
    own = weights[first[name]:first[name + 1]].copy()
    weights[:cells] = 0.0
    weights[first[name]:first[name + 1]] = own
    weights[cells] = 1.0 - own.sum() - weights[cells + 1]


@kernel
def best_rows(
    first: NDArray[np.int64], tracks: Tracks, count: int, rows: NDArray[np.int64], lead: Array
) -> None:
    """
    Fill the best row of each name, -1 if there is none, and its lead over the next, nats.

    One that is not sure of its pattern any more has none.
    """
    rows[:] = -1
    lead[:] = np.inf
    for row in range(count):
        name = tracks.name[row]
        if name != UNNAMED and (rows[name] < 0 or tracks.score[row] > tracks.score[rows[name]]):
            rows[name] = row
    for row in range(count):
        name = tracks.name[row]
        if name != UNNAMED and tracks.now[row, 0] != tracks.now[rows[name], 0]:
            lead[name] = min(lead[name], tracks.score[rows[name]] - tracks.score[row])
    for name in range(rows.size):
        row = rows[name]
        if row >= 0 and probability(first, tracks.weights[row], name) < SURE:
            lead[name] = 0.0

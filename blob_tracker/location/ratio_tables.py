"""Tables of the place and the width that two ratios of weighted sums stand for."""

from __future__ import annotations

from functools import cache
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.likelihood import fill_profile
import numpy as np
from numpy.typing import NDArray

NODES = 33  # of a table along each ratio: the look-up is then true to some 3e-4 px
DENSE = 65  # places, and widths, from which a table is inverted
SCALES = 7  # of the weights in a support of one length, evenly in the logarithm:
SLIMMEST, WIDEST = 1.0 / 7.5, 1.0 / 2.5  # of the support's length, the first and the last
EVERY_PX = 16  # shorter supports have tables each, of the longer ones pairs 1/8 apart
NARROWEST_PX = 0.35  # a narrower pulse leaves its place in the pixel open
ERF_STEPS, ERF_REACH = 128, 6  # nodes to 1, and the last: between them it is true to 8e-6
FALLEN = 0.5  # of e's peak: where e has fallen to it a table ends, since R is a ratio over e
V, D, E, U = 0, 1, 2, 3  # rows of the weights
_HALF_WAY = (WIDEST / SLIMMEST) ** (0.5 / (SCALES - 1))  # from one w to the next
_SQRT2, _SQRT_HALF_PI = math.sqrt(2.0), math.sqrt(math.pi / 2.0)


class Tables(NamedTuple):
    """
    The weights and the tables of all supports up to one length.

    Parameters
    ----------
    of_length : (limit + 1,) int array
        The first table of the longest support that fits into so many pixels, with their parity.
    length : (T,) int array
        Of the support, px.
    scale : (T,) array
        Width of the weights, px.
    weights : (T, 4, limit) array
        v, d, e and u of `locale_table`.
    whole : (T,) array
        Sum of v.
    furthest : (T,) array
        The largest |x| that the table holds, px.
    least : (T, 2) array
        The smallest |R| and Q that the table holds.
    step : (T, 2) array
        From node to node.
    erf : (E,) array
        The error function, ERF_STEPS to 1.
    value : (T, NODES, NODES, 4) array
        By |R| and Q: x from the support's middle, px; sigma, px; and what the weights v and e
        make of the unit pulse.

    """

    of_length: NDArray[np.int64]
    length: NDArray[np.int64]
    scale: Array
    weights: Array
    whole: Array
    furthest: Array
    least: Array
    step: Array
    erf: Array
    value: Array


@cache
def tables_up_to(limit: int) -> Tables:
    """
    Return the tables of all supports of 3 to `limit` px, made at the first call.

    Those up to 16 px take 0.1 s and 3 MB, those up to 256 px 2 s and 20 MB.
    """
    import scipy  # no part of a start

    lengths = list(range(3, min(limit, EVERY_PX) + 1))
    longer = EVERY_PX + EVERY_PX // 8
    while longer < limit:
        lengths += [longer, longer + 1]
        longer += longer // 8
    of_length = np.zeros(limit + 1, dtype=np.int64)
    for place, length in enumerate(lengths):
        of_length[length::2] = place * SCALES
    length_of = np.repeat(np.array(lengths), SCALES)
    scale = length_of * np.tile(np.geomspace(SLIMMEST, WIDEST, SCALES), len(lengths))
    weights = np.zeros((scale.size, 4, limit))
    for place, length in enumerate(length_of):
        offset = np.arange(length) - (length - 1) / 2.0
        bell = np.exp(-0.5 * (offset / scale[place]) ** 2)
        weights[place, :, :length] = (
            bell, offset * bell, bell - bell.mean(), (offset / scale[place]) ** 2 * bell
        )
    mean = weights[:, V].sum(axis=1) / length_of
    tables = Tables(
        of_length,
        length_of,
        scale,
        weights,
        weights[:, V].sum(axis=1),
        scale * np.sqrt(-2.0 * np.log(mean + FALLEN * (1.0 - mean))),
        np.zeros((scale.size, 2)),
        np.zeros((scale.size, 2)),
        scipy.special.erf(np.arange(ERF_STEPS * ERF_REACH + 1) / ERF_STEPS),
        np.zeros((scale.size, NODES, NODES, 4)),
    )
    _invert_all(tables)
    return tables


@kernel
def _invert_all(tables: Tables) -> None:
    """Fill the tables: from x and sigma to the ratios on a dense grid, and back on the nodes."""
    profile = np.empty((3, tables.weights.shape[2]))
    seen = np.empty((DENSE, DENSE, 5))  # by x and sigma: R, sigma, v, e, Q
    crossed = np.empty((DENSE, 4))  # the first four where Q is that of a node
    for t in range(tables.length.size):
        length, scale = tables.length[t], tables.scale[t]
        weights = tables.weights[t]
        furthest = tables.furthest[t]
        slim, wide = max(0.25 * scale, 0.5 * NARROWEST_PX), 2.5 * scale
        for a in range(DENSE):
            for b in range(DENSE):
                sigma = slim * (wide / slim) ** (b / (DENSE - 1.0))
                centre = 0.5 * (length - 1) + furthest * a / (DENSE - 1.0)
                fill_profile(centre, sigma, profile[:, :length])
                v, d, e, u = 0.0, 0.0, 0.0, 0.0
                for i in range(length):
                    v += weights[V, i] * profile[0, i]
                    d += weights[D, i] * profile[0, i]
                    e += weights[E, i] * profile[0, i]
                    u += weights[U, i] * profile[0, i]
                seen[a, b, 0] = d / e
                seen[a, b, 1] = sigma
                seen[a, b, 2] = v
                seen[a, b, 3] = e
                seen[a, b, 4] = u / v
        low, high = seen[0, 0, 4], seen[0, DENSE - 1, 4]
        most = 0.0
        for b in range(DENSE):
            most = max(most, seen[DENSE - 1, b, 0])
        tables.least[t, 1] = low
        tables.step[t, 0], tables.step[t, 1] = most / (NODES - 1), (high - low) / (NODES - 1)
        for q in range(NODES):
            wanted = low + q * tables.step[t, 1]
            for a in range(DENSE):
                b = 1
                while b < DENSE - 1 and seen[a, b, 4] < wanted:
                    b += 1
                share = (wanted - seen[a, b - 1, 4]) / (seen[a, b, 4] - seen[a, b - 1, 4])
                share = min(max(share, 0.0), 1.0)
                for p in range(4):
                    crossed[a, p] = (1.0 - share) * seen[a, b - 1, p] + share * seen[a, b, p]
            a = 1
            for r in range(NODES):
                wanted = r * tables.step[t, 0]
                while a < DENSE - 1 and crossed[a, 0] < wanted:
                    a += 1
                share = (wanted - crossed[a - 1, 0]) / (crossed[a, 0] - crossed[a - 1, 0])
                share = min(max(share, 0.0), 1.0)
                tables.value[t, r, q, 0] = furthest * (a - 1 + share) / (DENSE - 1.0)
                for p in range(1, 4):
                    tables.value[t, r, q, p] = (
                        (1.0 - share) * crossed[a - 1, p] + share * crossed[a, p]
                    )


class Reading(NamedTuple):
    """
    What a table says along one axis.

    x from the support's middle and sigma, px; v and e of the unit pulse; the slopes of x by R
    and by Q, px.
    """

    x: float
    sigma: float
    v: float
    e: float
    by_r: float
    by_q: float


@kernel
def read(tables: Tables, t: int, ratio: float, moment: float) -> Reading:
    """Read a table bilinearly; beyond its nodes the outermost count."""
    value = tables.value[t]
    right = abs(ratio) / tables.step[t, 0]
    up = (moment - tables.least[t, 1]) / tables.step[t, 1]
    right = min(max(right, 0.0), NODES - 1.0)
    up = min(max(up, 0.0), NODES - 1.0)
    r, q = min(int(right), NODES - 2), min(int(up), NODES - 2)
    fr, fq = right - r, up - q
    a, b, c, d = (1.0 - fr) * (1.0 - fq), fr * (1.0 - fq), (1.0 - fr) * fq, fr * fq
    v00, v10, v01, v11 = value[r, q], value[r + 1, q], value[r, q + 1], value[r + 1, q + 1]
    x = a * v00[0] + b * v10[0] + c * v01[0] + d * v11[0]
    by_r = ((1.0 - fq) * (v10[0] - v00[0]) + fq * (v11[0] - v01[0])) / tables.step[t, 0]
    by_q = ((1.0 - fr) * (v01[0] - v00[0]) + fr * (v11[0] - v10[0])) / tables.step[t, 1]
    sign = 1.0 if ratio >= 0.0 else -1.0
    return Reading(
        sign * x,
        a * v00[1] + b * v10[1] + c * v01[1] + d * v11[1],
        a * v00[2] + b * v10[2] + c * v01[2] + d * v11[2],
        a * v00[3] + b * v10[3] + c * v01[3] + d * v11[3],
        by_r,
        sign * by_q,
    )


@kernel
def table_for(tables: Tables, twice: int, extent: int, width: float) -> int:
    """Return the table for weights of a width about a middle, which is given in half pixels."""
    length = min(twice + 1, 2 * extent - 1 - twice)
    most = max(int(math.ceil(width / SLIMMEST)), 4)
    if length > most:
        length = most - (most - length) % 2
    first = tables.of_length[length]
    last = first + SCALES - 1
    while first < last and width > _HALF_WAY * tables.scale[first]:
        first += 1
    return int(first)


@kernel
def profile_by_table(erf: Array, centre: float, sigma: float, out: Array, size: int) -> float:
    """Fill out with `integrated_profile` by looking erf up; return its sum."""
    inverse = ERF_STEPS / (_SQRT2 * sigma)
    height = _SQRT_HALF_PI * sigma
    area, total = 0.0, 0.0
    for k in range(-1, size):
        edge = (k + 0.5 - centre) * inverse
        far = min(abs(edge), ERF_STEPS * ERF_REACH - 1.0)
        node = int(far)
        next_area = math.copysign(erf[node] + (far - node) * (erf[node + 1] - erf[node]), edge)
        if k >= 0:
            out[k] = height * (next_area - area)
            total += out[k]
        area = next_area
    return total

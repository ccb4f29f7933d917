"""A look-up: ratios of six weighted sums of the pixels, and tables of the place they stand for."""

from __future__ import annotations

from functools import cache
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Estimates, Failure
from blob_tracker.location.likelihood import fill_profile
from blob_tracker.location.scoring import (
    COVARIANCE_INFLATION, FAINTEST_SIGMA, MISFIT_SIGMA,
)
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads special, 20 MB, when it is first used

NODES = 33  # of a table along each ratio: the look-up is then true to some 3e-4 px
DENSE = 65  # places, and widths, from which a table is inverted
SCALES = 7  # of the weights in a support of one length, evenly in the logarithm:
ERF_STEPS, ERF_REACH = 128, 6  # nodes to 1, and the last: between them it is true to 8e-6
SLIMMEST, WIDEST = 1.0 / 7.5, 1.0 / 2.5  # of the support's length, the first and the last
EVERY = 16  # px: shorter supports have tables each, of the longer ones pairs 1/8 apart
NARROWEST = 0.35  # px: a narrower pulse leaves its place in the pixel open
LEAST = 0.7  # px: of w; narrower weights see one pixel, and no width
LOOKS_UP = 8  # looks at most until support and weights fit the pulse; it takes two or three
NEAR, ALIKE = 0.3, 1.15  # px from the support's middle, ratio of w: another look gains nothing
ASTRAY = 0.5  # px from a middle that the window's edge holds back: the pulse is cut through
ENDS = 0.98  # of the table's reach: beyond it the place is not known to lie in it
FALLEN = 0.5  # of e's peak: where e has fallen to it a table ends, since R is a ratio over e
# The best width of the weights over the pulse's: 1 in even noise, 1 + BROADER ln(1 + q) where the
# shot noise of the peak is q times the other, measured for q up to 130.
BROADER, BROADEST = 0.25, 2.2

_NONE, _NO_SIGNAL, _OUTSIDE = int(Failure.NONE), int(Failure.NO_SIGNAL), int(Failure.OUTSIDE)
_NARROW, _WIDE = int(Failure.TOO_NARROW), int(Failure.TOO_WIDE)
_DIVERGED, _CLIPPED = int(Failure.NOT_CONVERGED), int(Failure.CLIPPED)
_V, _D, _E, _U = 0, 1, 2, 3  # rows of the weights
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


def locale_table(
    lit: NDArray[np.float64],
    unlit: NDArray[np.float64] | None,
    noise: SensorNoise,
    saturation: float | None,
) -> Estimates:
    r"""
    Locate N blobs by looking up ratios of weighted sums in a table.

    The thesis proposes (section 6.1) to map every quantised picture of the target to its locale,
    the positions that all give that picture (Havelock, IEEE PAMI 11 (1989) 1065;
    `locale_extent`), and to look the position up. Such a map holds for one amplitude, width and
    background, and noise leads out of it. This one does not map the pictures but four ratios
    that amplitude and background leave alone, so that a pulse of any width is found, noise moves
    the answer no more than it must, and the tables of all pulses take a few megabytes.

    About a pixel, or the edge between two, lies a support of L pixels along each axis. With the
    distance i from its middle, v_i = exp(-i^2 / 2 w^2), d_i = i v_i, e_i = v_i less its mean
    and u_i = (i / w)^2 v_i, and s the light of lit - unlit or of lit,

        R = sum d_i v_j s_ij / sum e_i v_j s_ij,    Q = sum u_i e_j s_ij / sum v_i e_j s_ij

    Of d and e the sums are zero, so no background is left; the pulse is a product of a factor
    along x and one along y, of which the second cancels with the amplitude. R and Q depend on
    the place and width along x alone, R nearly on the place and Q on the width, and so along y.
    Tables of x(|R|, Q) and sigma(|R|, Q), made by inverting the pixel-integrated Gaussian
    (`integrated_profile`), one for each L and w / L, are read bilinearly. The place and width
    that they give choose the support and the weights for the next look; two or three settle it.

    In even noise w = sigma is best, as for any matched filter, and the more of the noise is the
    peak's own shot noise the wider (the plain centroid is the limit). With sigma from 0.7 px to a
    quarter of the window the rms error is 1.00 to 1.04 times the Cramer-Rao bound, at a third of
    it up to 1.1 times where the peak's shot noise prevails; the bias is below 5e-4 sigma. It is
    1.1 times the bound at 0.5 px, where at an SNR of 50 every seventh window is refused, and the
    nodes show at a peak SNR above 5000. With an unlit window it comes to the bound of lit minus
    unlit, which `maximum_likelihood` undercuts where little texture lies behind the target.

    Speed is what it is for: a stack of windows takes a quarter of the time of
    `maximum_likelihood`, less than the centroid. A single window gains next to nothing, since
    there the call takes longer than either.

    The covariance is that of the pixels, v_k of `pixel_variance` at the pulse that was found,
    carried through both ratios and the slopes of the table; as in `maximum_likelihood` it grows
    by 1 + 12 / S^2 and, where the pulse is no such Gaussian, by chi2. It does not hold the bias
    of another shape: pulses that are no product of two Gaussians (tilted, with skirts) are
    looked up as the Gaussian with the same ratios.

    Parameters
    ----------
    lit, unlit : (N, h, w) arrays
        DN; unlit may be None. Contiguous float64.
    noise : SensorNoise
        Gain and read noise.
    saturation : float or None
        DN of a clipped pixel.

    Returns
    -------
    Estimates
        Failure CLIPPED where a clipped pixel lies in the support: a sum cannot leave it out.
        NO_SIGNAL where the support's middle is no brighter than the rest, or the amplitude below
        five of its standard deviations; OUTSIDE where the pulse is within half a pixel of the
        middles of the outermost pixels, or beyond; TOO_NARROW and TOO_WIDE where sigma is below
        0.35 px or above half the window; NOT_CONVERGED where the looks contradict one another.
        chi2 is that of the support.

    """
    count, height, width = lit.shape
    table = np.zeros((7, count))  # x, y, amplitude, background, sigma, SNR, chi2
    covariance = np.zeros((count, 2, 2))
    clipped = np.zeros(count, dtype=np.int64)
    failure = np.zeros(count, dtype=np.uint8)
    _look_up_all(
        lit,
        lit[:0] if unlit is None else unlit,
        1.0 / noise.gain,
        noise.read_noise**2 + 1.0 / 12.0,
        math.inf if saturation is None else float(saturation),
        # Sizes share their tables: those of the next power of two.
        tables_up_to(1 << (max(height, width, EVERY) - 1).bit_length()),
        table,
        covariance,
        clipped,
        failure,
    )
    return Estimates.from_table(table, covariance, clipped, failure)


@cache
def tables_up_to(limit: int) -> Tables:
    """
    Return the tables of all supports of 3 to `limit` px, made at the first call.

    Those up to 16 px take 0.1 s and 3 MB, those up to 256 px 2 s and 20 MB.
    """
    lengths = list(range(3, min(limit, EVERY) + 1))
    longer = EVERY + EVERY // 8
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
    mean = weights[:, _V].sum(axis=1) / length_of
    tables = Tables(
        of_length,
        length_of,
        scale,
        weights,
        weights[:, _V].sum(axis=1),
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
        slim, wide = max(0.25 * scale, 0.5 * NARROWEST), 2.5 * scale
        for a in range(DENSE):
            for b in range(DENSE):
                sigma = slim * (wide / slim) ** (b / (DENSE - 1.0))
                centre = 0.5 * (length - 1) + furthest * a / (DENSE - 1.0)
                fill_profile(centre, sigma, profile[:, :length])
                v, d, e, u = 0.0, 0.0, 0.0, 0.0
                for i in range(length):
                    v += weights[_V, i] * profile[0, i]
                    d += weights[_D, i] * profile[0, i]
                    e += weights[_E, i] * profile[0, i]
                    u += weights[_U, i] * profile[0, i]
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
def _read(tables: Tables, t: int, ratio: float, moment: float) -> Reading:
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
def _table_for(tables: Tables, twice: int, extent: int, width: float) -> int:
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
def _middle(place: float, extent: int) -> int:
    """Return the nearest middle that a support of 3 px or more can have, in half pixels."""
    return int(min(max(round(2.0 * place), 2), 2 * extent - 4))


@kernel
def _profile(erf: Array, centre: float, sigma: float, out: Array, size: int) -> float:
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


@kernel
def _brightest(profile: Array) -> int:
    """Return the pixel about which three hold the most light."""
    best, place = -math.inf, 1
    for k in range(1, profile.size - 1):
        total = profile[k - 1] + profile[k] + profile[k + 1]
        if total > best:
            best, place = total, k
    return place


class Sums(NamedTuple):
    """
    Weighted sums of the light in a support.

    The first letter is the row of weights along x, the second along y.
    """

    vv: float
    dv: float
    ev: float
    ue: float
    vd: float
    ve: float
    eu: float


@kernel
def _sums(light: Array, across: Array, down: Array, left: int, top: int,
          size_x: int, size_y: int) -> Sums:
    """Return the sums of the light in the support that begins at left, top."""
    vv, dv, ev, ue, vd, ve, eu = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(size_y):
        v, d, e, u = 0.0, 0.0, 0.0, 0.0
        for i in range(size_x):
            s = light[top + j, left + i]
            v += across[_V, i] * s
            d += across[_D, i] * s
            e += across[_E, i] * s
            u += across[_U, i] * s
        vv += down[_V, j] * v
        dv += down[_V, j] * d
        ev += down[_V, j] * e
        ue += down[_E, j] * u
        vd += down[_D, j] * v
        ve += down[_E, j] * v
        eu += down[_U, j] * e
    return Sums(vv, dv, ev, ue, vd, ve, eu)


@kernel
def _look_up_all(
    lit: Array,
    unlit: Array,
    shot: float,
    floor: float,
    saturation: float,
    tables: Tables,
    table: Array,
    covariance: Array,
    clipped: NDArray[np.int64],
    failure: NDArray[np.uint8],
) -> None:
    """Look each window up; `shot` is 1 / gain, `floor` the variance of a dark pixel, DN^2."""
    count, height, width = lit.shape
    paired = unlit.shape[0] > 0
    light = np.empty((height, width))
    across, down = np.empty(width), np.empty(height)
    for n in range(count):
        across[:] = 0.0
        down[:] = 0.0
        behind = 0.0
        for j in range(height):
            for i in range(width):
                value = lit[n, j, i]
                if value >= saturation:
                    clipped[n] += 1
                if paired:
                    value -= unlit[n, j, i]
                    behind += unlit[n, j, i]
                light[j, i] = value
                across[i] += value
                down[j] += value
        behind /= height * width
        cx, cy = 2 * _brightest(across), 2 * _brightest(down)
        broad = min(height, width) / 6.0
        tx, ty = _table_for(tables, cx, width, broad), _table_for(tables, cy, height, broad)
        size_x, size_y, left, top = 0, 0, 0, 0
        sums = Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        on_x = Reading(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        on_y = on_x
        amplitude, sigma = 0.0, 0.0
        failure[n] = _DIVERGED
        for look in range(LOOKS_UP):
            size_x, size_y = tables.length[tx], tables.length[ty]
            left, top = (cx - size_x + 1) // 2, (cy - size_y + 1) // 2
            sums = _sums(light, tables.weights[tx], tables.weights[ty], left, top, size_x, size_y)
            if not (sums.ev > 0.0 and sums.ve > 0.0):
                failure[n] = _NO_SIGNAL
                break
            on_x = _read(tables, tx, sums.dv / sums.ev, sums.ue / sums.ve)
            on_y = _read(tables, ty, sums.vd / sums.ve, sums.eu / sums.ev)
            sigma = math.sqrt(on_x.sigma * on_y.sigma)
            amplitude = sums.ev / (on_x.e * on_y.v)
            if paired:
                dark = 2.0 * (max(behind, 0.0) * shot + floor)
            else:
                level = sums.vv - amplitude * on_x.v * on_y.v
                level /= tables.whole[tx] * tables.whole[ty]
                dark = max(level, 0.0) * shot + floor
            best = sigma * min(1.0 + BROADER * math.log(1.0 + amplitude * shot / dark), BROADEST)
            best = max(best, LEAST)
            now = math.sqrt(tables.scale[tx] * tables.scale[ty])
            to_x = _middle(0.5 * cx + on_x.x, width)
            to_y = _middle(0.5 * cy + on_y.x, height)
            next_x = _table_for(tables, to_x, width, best)
            next_y = _table_for(tables, to_y, height, best)
            same = to_x == cx and to_y == cy and next_x == tx and next_y == ty
            near = max(abs(on_x.x), abs(on_y.x)) < NEAR
            # Weights that are not the best ones make a true look-up too: at last any will do.
            alike = look == LOOKS_UP - 1 or (now < best * ALIKE and best < now * ALIKE)
            if same or (near and alike):
                failure[n] = _NONE
                break
            cx, cy, tx, ty = to_x, to_y, next_x, next_y
        if failure[n] != _NONE:
            continue
        x, y = 0.5 * cx + on_x.x, 0.5 * cy + on_y.x
        failure[n] = _judge(tables, tx, ty, on_x, on_y, max(height, width))
        if failure[n] != _NONE:
            continue
        # The level that leaves nothing over in the support.
        level = -amplitude * _profile(tables.erf, x - left, on_x.sigma, across, size_x)
        level *= _profile(tables.erf, y - top, on_y.sigma, down, size_y)
        for j in range(size_y):
            for i in range(size_x):
                level += light[top + j, left + i]
                if lit[n, top + j, left + i] >= saturation:
                    failure[n] = _CLIPPED
                if paired and unlit[n, top + j, left + i] >= saturation:
                    failure[n] = _CLIPPED
        if failure[n] != _NONE:
            continue
        level /= size_x * size_y
        # How a pixel moves x: ax_i v_j through R, bx_i e_j through Q; and so y.
        ratio_x, moment_x = sums.dv / sums.ev, sums.ue / sums.ve
        ratio_y, moment_y = sums.vd / sums.ve, sums.eu / sums.ev
        wx, wy = tables.weights[tx], tables.weights[ty]
        xx, xy, yy, ss, squares = 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(size_y):
            ay = on_y.by_r / sums.ve * (wy[_D, j] - ratio_y * wy[_E, j])
            by = on_y.by_q / sums.ev * (wy[_U, j] - moment_y * wy[_V, j])
            for i in range(size_x):
                ax = on_x.by_r / sums.ev * (wx[_D, i] - ratio_x * wx[_E, i])
                bx = on_x.by_q / sums.ve * (wx[_U, i] - moment_x * wx[_V, i])
                moves_x = ax * wy[_V, j] + bx * wy[_E, j]
                moves_y = ay * wx[_V, i] + by * wx[_E, i]
                pulse = amplitude * down[j] * across[i]
                if paired:
                    variance = max(pulse + unlit[n, top + j, left + i], 0.0) * shot + floor
                    variance += max(unlit[n, top + j, left + i], 0.0) * shot + floor
                else:
                    variance = max(pulse + level, 0.0) * shot + floor
                residual = light[top + j, left + i] - pulse - level
                xx += moves_x * moves_x * variance
                xy += moves_x * moves_y * variance
                yy += moves_y * moves_y * variance
                ss += (wx[_E, i] * wy[_V, j]) ** 2 * variance
                squares += residual * residual / variance
        detection = sums.ev * sums.ev / ss
        if not detection > FAINTEST_SIGMA**2:
            failure[n] = _NO_SIGNAL
            continue
        left_over = max(size_x * size_y - 6, 1)
        chi2 = squares / left_over
        scale = 1.0 + COVARIANCE_INFLATION / detection
        if chi2 > 1.0 + MISFIT_SIGMA * math.sqrt(2.0 / left_over):
            scale *= chi2
        covariance[n, 0, 0] = scale * xx
        covariance[n, 0, 1] = scale * xy
        covariance[n, 1, 0] = scale * xy
        covariance[n, 1, 1] = scale * yy
        below = behind if paired else level
        peak = max(amplitude + below, 0.0) * shot + floor
        if paired:
            peak += max(below, 0.0) * shot + floor
        table[0, n] = x
        table[1, n] = y
        table[2, n] = amplitude
        table[3, n] = below
        table[4, n] = sigma
        table[5, n] = amplitude / math.sqrt(peak)
        table[6, n] = chi2


@kernel
def _judge(
    tables: Tables, tx: int, ty: int, on_x: Reading, on_y: Reading, extent: int
) -> int:
    """Return the failure of a look that is settled, or none."""
    if min(on_x.sigma, on_y.sigma) < NARROWEST:
        return _NARROW
    if max(on_x.sigma, on_y.sigma) > 0.5 * extent:
        return _WIDE
    if abs(on_x.x) > min(ASTRAY, ENDS * tables.furthest[tx]):
        return _OUTSIDE
    if abs(on_y.x) > min(ASTRAY, ENDS * tables.furthest[ty]):
        return _OUTSIDE
    return _NONE

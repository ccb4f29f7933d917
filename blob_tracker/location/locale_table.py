"""A look-up: ratios of six weighted sums of the pixels, and tables of the place they stand for."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel, written_into_kernels
from blob_tracker.location.estimates import Estimates, Failure
from blob_tracker.location.ratio_tables import (
    D, E, EVERY_PX, NARROWEST_PX, profile_by_table, read, Reading, table_for, Tables,
    tables_up_to, U, V,
)
from blob_tracker.location.scoring import covariance_growth, FAINTEST_SIGMA
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

LEAST_PX = 0.7  # of w; narrower weights see one pixel, and no width
LOOKS_UP = 8  # looks at most until support and weights fit the pulse; it takes two or three
NEAR_PX, ALIKE = 0.3, 1.15  # from the support's middle, ratio of w: another look gains nothing
ASTRAY_PX = 0.5  # from a middle that the window's edge holds back: the pulse is cut through
ENDS = 0.98  # of the table's reach: beyond it the place is not known to lie in it
# The best width of the weights over the pulse's: 1 in even noise, 1 + BROADER ln(1 + q) where the
# shot noise of the peak is q times the other, measured for q up to 130.
BROADER, BROADEST = 0.25, 2.2

_NONE, _NO_SIGNAL, _OUTSIDE = int(Failure.NONE), int(Failure.NO_SIGNAL), int(Failure.OUTSIDE)
_NARROW, _WIDE = int(Failure.TOO_NARROW), int(Failure.TOO_WIDE)
_DIVERGED, _CLIPPED = int(Failure.NOT_CONVERGED), int(Failure.CLIPPED)


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
        tables_up_to(1 << (max(height, width, EVERY_PX) - 1).bit_length()),
        table,
        covariance,
        clipped,
        failure,
    )
    return Estimates.from_table(table, covariance, clipped, failure)


@kernel
def _middle(place: float, extent: int) -> int:
    """Return the nearest middle that a support of 3 px or more can have, in half pixels."""
    return int(min(max(round(2.0 * place), 2), 2 * extent - 4))


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
            v += across[V, i] * s
            d += across[D, i] * s
            e += across[E, i] * s
            u += across[U, i] * s
        vv += down[V, j] * v
        dv += down[V, j] * d
        ev += down[V, j] * e
        ue += down[E, j] * u
        vd += down[D, j] * v
        ve += down[E, j] * v
        eu += down[U, j] * e
    return Sums(vv, dv, ev, ue, vd, ve, eu)


@written_into_kernels
def _take(
    n: int, lit: Array, unlit: Array, paired: bool, saturation: float, light: Array,
    across: Array, down: Array, clipped: NDArray[np.int64],
) -> float:
    """Fill the light, its sums by columns and rows, and the count; return the mean of `unlit`."""
    height, width = light.shape
    across[:] = 0.0
    down[:] = 0.0
    behind = 0.0
    for j in range(height):
        for i in range(width):
            value = lit[j, i]
            if value >= saturation:
                clipped[n] += 1
            if paired:
                value -= unlit[j, i]
                behind += unlit[j, i]
            light[j, i] = value
            across[i] += value
            down[j] += value
    return behind / (height * width)


class Moved(NamedTuple):
    """
    Sums over the support, of the variances of its pixels.

    By how each pixel moves x and y, squared, px^2; by its weight in the amplitude, squared; and of
    the squared residuals over the variances.
    """

    xx: float
    xy: float
    yy: float
    ss: float
    squares: float


@written_into_kernels
def _moved(
    sums: Sums, on_x: Reading, on_y: Reading, amplitude: float, level: float, wx: Array,
    wy: Array, light: Array, unlit: Array, paired: bool, across: Array, down: Array, left: int,
    top: int, size_x: int, size_y: int, shot: float, floor: float,
) -> Moved:
    """Carry the noise of the pixels; `across` and `down` are the profiles of the unit pulse."""
    # How a pixel moves x: ax_i v_j through R, bx_i e_j through Q; and so y.
    ratio_x, moment_x = sums.dv / sums.ev, sums.ue / sums.ve
    ratio_y, moment_y = sums.vd / sums.ve, sums.eu / sums.ev
    xx, xy, yy, ss, squares = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(size_y):
        ay = on_y.by_r / sums.ve * (wy[D, j] - ratio_y * wy[E, j])
        by = on_y.by_q / sums.ev * (wy[U, j] - moment_y * wy[V, j])
        for i in range(size_x):
            ax = on_x.by_r / sums.ev * (wx[D, i] - ratio_x * wx[E, i])
            bx = on_x.by_q / sums.ve * (wx[U, i] - moment_x * wx[V, i])
            moves_x = ax * wy[V, j] + bx * wy[E, j]
            moves_y = ay * wx[V, i] + by * wx[E, i]
            pulse = amplitude * down[j] * across[i]
            if paired:
                variance = max(pulse + unlit[top + j, left + i], 0.0) * shot + floor
                variance += max(unlit[top + j, left + i], 0.0) * shot + floor
            else:
                variance = max(pulse + level, 0.0) * shot + floor
            residual = light[top + j, left + i] - pulse - level
            xx += moves_x * moves_x * variance
            xy += moves_x * moves_y * variance
            yy += moves_y * moves_y * variance
            ss += (wx[E, i] * wy[V, j]) ** 2 * variance
            squares += residual * residual / variance
    return Moved(xx, xy, yy, ss, squares)


@written_into_kernels
def _write(
    n: int, x: float, y: float, amplitude: float, below: float, sigma: float, chi2: float,
    paired: bool, shot: float, floor: float, table: Array,
) -> None:
    """Write what was found into a column of the table."""
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


@written_into_kernels
def _spread(n: int, scale: float, xx: float, xy: float, yy: float, covariance: Array) -> None:
    """Write the covariance of the place."""
    covariance[n, 0, 0] = scale * xx
    covariance[n, 0, 1] = scale * xy
    covariance[n, 1, 0] = scale * xy
    covariance[n, 1, 1] = scale * yy


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
        behind = _take(
            n, lit[n], unlit[n] if paired else lit[n], paired, saturation, light, across, down,
            clipped,
        )
        cx, cy = 2 * _brightest(across), 2 * _brightest(down)
        broad = min(height, width) / 6.0
        tx, ty = table_for(tables, cx, width, broad), table_for(tables, cy, height, broad)
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
            on_x = read(tables, tx, sums.dv / sums.ev, sums.ue / sums.ve)
            on_y = read(tables, ty, sums.vd / sums.ve, sums.eu / sums.ev)
            sigma = math.sqrt(on_x.sigma * on_y.sigma)
            amplitude = sums.ev / (on_x.e * on_y.v)
            if paired:
                dark = 2.0 * (max(behind, 0.0) * shot + floor)
            else:
                level = sums.vv - amplitude * on_x.v * on_y.v
                level /= tables.whole[tx] * tables.whole[ty]
                dark = max(level, 0.0) * shot + floor
            best = sigma * min(1.0 + BROADER * math.log(1.0 + amplitude * shot / dark), BROADEST)
            best = max(best, LEAST_PX)
            now = math.sqrt(tables.scale[tx] * tables.scale[ty])
            to_x = _middle(0.5 * cx + on_x.x, width)
            to_y = _middle(0.5 * cy + on_y.x, height)
            next_x = table_for(tables, to_x, width, best)
            next_y = table_for(tables, to_y, height, best)
            same = to_x == cx and to_y == cy and next_x == tx and next_y == ty
            near = max(abs(on_x.x), abs(on_y.x)) < NEAR_PX
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
        level = -amplitude * profile_by_table(tables.erf, x - left, on_x.sigma, across, size_x)
        level *= profile_by_table(tables.erf, y - top, on_y.sigma, down, size_y)
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
        xx, xy, yy, ss, squares = _moved(
            sums, on_x, on_y, amplitude, level, tables.weights[tx], tables.weights[ty], light,
            unlit[n] if paired else light, paired, across, down, left, top, size_x, size_y, shot,
            floor,
        )
        detection = sums.ev * sums.ev / ss
        if not detection > FAINTEST_SIGMA**2:
            failure[n] = _NO_SIGNAL
            continue
        left_over = max(size_x * size_y - 6, 1)
        chi2 = squares / left_over
        scale = covariance_growth(chi2, left_over, detection)
        _spread(n, scale, xx, xy, yy, covariance)
        _write(
            n, x, y, amplitude, behind if paired else level, sigma, chi2, paired, shot, floor,
            table,
        )


@kernel
def _judge(
    tables: Tables, tx: int, ty: int, on_x: Reading, on_y: Reading, extent: int
) -> int:
    """Return the failure of a look that is settled, or none."""
    if min(on_x.sigma, on_y.sigma) < NARROWEST_PX:
        return _NARROW
    if max(on_x.sigma, on_y.sigma) > 0.5 * extent:
        return _WIDE
    if abs(on_x.x) > min(ASTRAY_PX, ENDS * tables.furthest[tx]):
        return _OUTSIDE
    if abs(on_y.x) > min(ASTRAY_PX, ENDS * tables.furthest[ty]):
        return _OUTSIDE
    return _NONE

"""How much of the unlit window's texture to take off the lit one, and the noise of doing so."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.likelihood import (
    add_row,
    fill_profile,
    join_widths,
    Observation,
    Profiles,
    RowSums,
)
from blob_tracker.location.normal_equations import column_of_inverse, NormalEquations, solve

SHRINKAGE = 1.2  # of `texture_share`; 1.1 to 1.4 keep the worst case below 1.09
# Of the pulse's peak: a texture of this rms is half taken off whatever it shifts
STRONG_TEXTURE = 0.25
RESIDUAL_TEXTURE = 1.2  # times its noise: the texture that a small shift leaves probable


class Unlit(NamedTuple):
    """
    The unlit window, split into its mean and its texture.

    Parameters
    ----------
    texture : (h, w) array
        Departure from the mean, DN.
    mean : float
        DN.
    white : float
        Variance of the texture over that of the noise.

    """

    texture: Array
    mean: float
    white: float


@kernel
def split_unlit(
    texture: Array, extra: Array, mean: float, shot: float, floor: float,
    usable: int,
) -> float:
    """Make `texture` the departure from the mean; return its variance over that of the noise."""
    variance = max(mean, 0.0) * shot + floor
    height, width = texture.shape
    total = 0.0
    for j in range(height):
        for i in range(width):
            texture[j, i] -= mean
            total += texture[j, i] ** 2 if extra[j, i] < math.inf else 0.0
    return max(total / ((usable - 1) * variance) - 1.0, 0.0)


@kernel
def residual_variance(share: float, white: float) -> float:
    """Return the variance that the unlit window adds, over that of its noise."""
    # The noise of the share that was taken off, and the texture of the share that was not.
    return max(share**2 + (1.0 - share) ** 2 * min(white, RESIDUAL_TEXTURE), share)


@kernel
def blend(lit: Array, unlit: Unlit, share: float, seen: Observation) -> None:
    """
    Take a share of the unlit texture off the lit pixels.

    `extra` becomes the variance of a pixel less its (A g_x g_y + b) shot, and `prior` the level
    b that the unlit window's mean gives, with the inverse of its variance.
    """
    texture, mean, white = unlit
    pixels, extra, prior, shot, floor = seen
    height, width = texture.shape
    added = residual_variance(share, white)
    # What the texture is but for its noise, in the mean.
    clean = white / (1.0 + white)
    usable = 0
    for j in range(height):
        for i in range(width):
            pixels[j, i] = lit[j, i] - share * texture[j, i]
            behind = clean * texture[j, i]
            level = max(mean + behind, 0.0) * shot
            used = extra[j, i] < math.inf
            # Written whether used or not: a loop without a branch is what the compiler widens.
            noise = floor + behind * shot + added * (level + floor)
            extra[j, i] = noise if used else math.inf
            usable += 1 if used else 0
    # At share 1 the mean cancels; the hundredth keeps its weight finite.
    prior[0] = mean
    prior[1] = usable / ((1.01 - share) * (max(mean, 0.0) * shot + floor))


@kernel
def texture_share(
    unlit: Unlit, seen: Observation, theta: Array, profiles: Profiles, equations: NormalEquations
) -> tuple[float, float, float]:
    """
    Return the share of the unlit texture to take off, 0 none, 1 all of it; E; and a chi2.

    The shift d that the texture lends to the position is a linear fit of the pulse's own
    derivatives to it; under noise alone E = d^T C^-1 d / 2 has the mean 1, and with texture of
    r times the noise 1 + r. The share r / (1 + r) is estimated by 1 - SHRINKAGE / E. The
    chi2 is what the same fit takes off the texture's squares where it finds a bright pulse.
    """
    texture, mean, white = unlit.texture, unlit.mean, unlit.white
    extra, shot, floor = seen.extra, seen.shot, seen.floor
    across, down = profiles
    fisher, score = equations.matrix, equations.right
    height, width = texture.shape
    fill_profile(theta[0], theta[4], across)
    fill_profile(theta[1], theta[5], down)
    amplitude = theta[2]
    fisher[:] = 0.0
    score[:] = 0.0
    variance = max(mean, 0.0) * shot + floor
    for j in range(height):
        s1, sg, sh, sq = 0.0, 0.0, 0.0, 0.0
        sgg, sgh, sgq, shh, shq, sqq = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        r1, rg, rh, rq = 0.0, 0.0, 0.0, 0.0
        for i in range(width):
            used = 1.0 if extra[j, i] < math.inf else 0.0
            g, h, q = used * across[0, i], used * across[1, i], used * across[2, i]
            behind = texture[j, i]
            s1 += used
            sg += g
            sh += h
            sq += q
            sgg += g * g
            sgh += g * h
            sgq += g * q
            shh += h * h
            shq += h * q
            sqq += q * q
            r1 += used * behind
            rg += g * behind
            rh += h * behind
            rq += q * behind
        sums = RowSums(
            s1, sg, sh, sq, sgg, sgh, sgq, shh, shq, sqq, r1, rg, rh, rq
        )
        add_row(equations, amplitude, down[0, j], down[1, j], down[2, j], sums)
    join_widths(equations)
    return share_of(equations, white, variance, amplitude)


@kernel
def share_of(
    equations: NormalEquations, white: float, variance: float, amplitude: float
) -> tuple[float, float, float]:
    """
    Return share, E and chi2 of `texture_share` from the equations of the linear fit.

    Their first three parameters are x, y and amplitude, and there are five; `white` is the
    variance of the texture over that of the noise, which is `variance`, DN^2.
    """
    score, step, size = equations.right, equations.solution, 5
    if not solve(equations, size, 0.0):
        return 1.0, 0.0, 0.0
    shift_x, shift_y = step[0], step[1]
    pulse = 0.0
    if step[2] > 0.0:
        for p in range(size):
            pulse += score[p] * step[p] / variance
    column_of_inverse(equations, size, 0)
    xx, xy = step[0], step[1]
    column_of_inverse(equations, size, 1)
    yy = step[1]
    square = yy * shift_x**2 - 2.0 * xy * shift_x * shift_y + xx * shift_y**2
    evidence = 0.5 * square / ((xx * yy - xy * xy) * variance)
    # The fit is linear in a texture that is weak beside the pulse; the rest is taken off.
    strong = white * variance / (white * variance + (STRONG_TEXTURE * amplitude) ** 2)
    share = max(strong, 1.0 - SHRINKAGE / max(evidence, SHRINKAGE))
    return share, evidence, pulse

"""What an alternative to one round pulse can gain at most, told without fitting it."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.alternatives import Alternative
from blob_tracker.location.alternatives.glow import glow, RARER as RARE_GLOW
from blob_tracker.location.alternatives.tailed import RARER as RARE_TAIL, tailed
from blob_tracker.location.alternatives.two_lights import RARER as RARE_LIGHT, two_lights
from blob_tracker.location.hypotheses import least_gain, Pair
from blob_tracker.location.pair_likelihood import Floats, likeliest_texture, TEXTURES
from blob_tracker.location.pair_model import BACKGROUND, fill_one_pulse, SIGMA, X, Y
import numpy as np
from numpy.typing import NDArray

# Of the gain from which on a model is heard: the score finds all of it but for one in 40 of the
# fits that are heard, and 0.88 of it at the least of 1100.
PROMISING = 0.75
TEXTURE = 1  # parameters: its variance, which the pulse may have and the other model not
PULSE, EVEN, BENT = 5, 8, 11  # columns: the pulse's parameters, then an even glow's, a bent one's
DIRECTIONS = 16  # in which lights and tails are tried
STEP_SIGMA = 0.5  # sigma from one place to the next
NEAREST_STEPS, FARTHEST_STEPS = 2, 14  # steps from the pulse
OUTSIDE_SIGMA = 1.5  # sigma beyond the window's border, to which they go
LEAST_OWN = 1e-3  # of its squares, that the pulse's own columns leave of a pattern


class Gains(NamedTuple):
    """
    Twice the log-likelihood that a model would gain on one round pulse.

    Parameters
    ----------
    light, tail : float
        The greatest, of a second light and of a tail.
    even, bent : float
        Of a glow about the light that is a plane, or a bent surface.

    """

    light: float
    tail: float
    even: float
    bent: float


def promising(pair: Pair, theta: Floats) -> set[Alternative]:
    """Return which of a second light, a tail and a glow can be heard beside one round pulse."""
    told = gains(pair, theta)
    return {
        alternative for alternative, gain, more, rarity in (
            (two_lights, told.light, 3, RARE_LIGHT), (tailed, told.tail, 3, RARE_TAIL),
            (glow, told.even, 3, RARE_GLOW), (glow, told.bent, 6, RARE_GLOW),
        )
        if gain > PROMISING * least_gain(more - TEXTURE, rarity)
    }


def gains(pair: Pair, theta: Floats) -> Gains:
    r"""
    Return what the score says that models with more in the lit window would gain.

    With c the whitened pattern that a model adds, r the whitened residuals and q_k an orthonormal
    basis of the pulse's own slopes, an amplitude of c gains (Rao, 1948)

        G = (c . r)^2 / (c . c - sum_k (q_k . c)^2)

    where c . r > 0. Of several patterns whose amplitudes are free, as a plane's, it is the sum of
    such squares, each pattern less those before it. The lit pixels are whitened given the unlit
    ones, which hold the same texture; the unlit window by itself tells of the background alone.

    Parameters
    ----------
    pair : Pair
        Lit and unlit.
    theta : (5,) array
        The one round pulse that fits best, or nearly: what its parameters can still gain is left
        out.

    """
    noise = pair.noise
    return Gains(*_gains(
        pair.pixels, pair.usable, theta, 1.0 / noise.gain, noise.read_noise**2 + 1.0 / 12.0,
        TEXTURES,
    ))


@kernel
def _gains(
    pixels: Array, usable: NDArray[np.bool_], theta: Array, shot: float, floor: float,
    textures: Array,
) -> tuple[float, float, float, float]:
    """Return the fields of `Gains`."""
    _, height, width = pixels.shape
    means, slopes = np.empty_like(pixels), np.empty((PULSE, 2, height, width))
    fill_one_pulse(theta, means, slopes)
    texture = likeliest_texture(pixels, means, usable, shot, floor, textures)
    # The last one stands for what the unlit window tells of the background.
    count = height * width + 1
    root, residual = np.zeros(count), np.zeros(count)
    columns = np.zeros((BENT, count))
    known = told = 0.0
    for j in range(height):
        v = 2.0 * j / (height - 1.0) - 1.0
        for i in range(width):
            share = over = 0.0
            if usable[1, j, i]:
                weight = 1.0 / (max(means[1, j, i], 0.0) * shot + floor + texture)
                share = texture * weight
                over = pixels[1, j, i] - means[1, j, i]
                known += weight
                told += weight * over
            if not usable[0, j, i]:
                continue
            n = j * width + i
            variance = max(means[0, j, i], 0.0) * shot + floor + (1.0 - share) * texture
            white = 1.0 / math.sqrt(variance)
            root[n] = white
            residual[n] = white * (pixels[0, j, i] - means[0, j, i] - share * over)
            for p in range(PULSE):
                columns[p, n] = white * (slopes[p, 0, j, i] - share * slopes[p, 1, j, i])
            u = 2.0 * i / (width - 1.0) - 1.0
            for c, surface in enumerate((1.0, u, v, u * u, u * v, v * v)):
                columns[PULSE + c, n] = white * surface
    columns[BACKGROUND, count - 1] = math.sqrt(known)
    residual[count - 1] = told / math.sqrt(known) if known > 0.0 else 0.0
    even, bent = 0.0, 0.0
    for c in range(BENT):
        part = _orthonormal(columns, c, residual)
        if c < PULSE:
            residual -= part * columns[c]
        else:
            bent += part * part
            even += part * part if c < EVEN else 0.0
    light, tail = _along_rays(columns[:PULSE], residual, root, theta, height, width)
    return light, tail, even, bent


@kernel
def _orthonormal(columns: Array, c: int, residual: Array) -> float:
    """Make a column a unit vector across those before it; return what it has of the residual."""
    whole = (columns[c] ** 2).sum()
    for before in range(c):
        columns[c] -= (columns[c] * columns[before]).sum() * columns[before]
    own = (columns[c] ** 2).sum()
    if not own > 1e-10 * whole:
        columns[c] = 0.0
        return 0.0
    columns[c] /= math.sqrt(own)
    return float((columns[c] * residual).sum())


@kernel
def _along_rays(
    basis: Array, residual: Array, root: Array, theta: Array, height: int, width: int
) -> tuple[float, float]:
    """Return the greatest gain of a light on a ray from the pulse, and of a tail along one."""
    # As wide as the pulse is in pixels.
    scale = -0.5 / (theta[SIGMA] * theta[SIGMA] + 1.0 / 12.0)
    light, tail = np.zeros(root.size), np.zeros(root.size)
    across, down = np.empty(width), np.empty(height)
    step = STEP_SIGMA * theta[SIGMA]
    margin = OUTSIDE_SIGMA * theta[SIGMA]
    of_light, of_tail = 0.0, 0.0
    for k in range(DIRECTIONS):
        angle = 2.0 * math.pi * k / DIRECTIONS
        tail[:] = 0.0
        for far in range(FARTHEST_STEPS + 1):
            x = theta[X] + far * step * math.cos(angle)
            y = theta[Y] + far * step * math.sin(angle)
            if not (-margin <= x <= width - 1 + margin and -margin <= y <= height - 1 + margin):
                break
            for i in range(width):
                across[i] = math.exp(scale * (i - x) * (i - x))
            for j in range(height):
                down[j] = math.exp(scale * (j - y) * (j - y))
            for j in range(height):
                for i in range(width):
                    light[j * width + i] = root[j * width + i] * down[j] * across[i]
            tail += light
            if far >= NEAREST_STEPS:
                of_light = max(of_light, _gain(light, residual, basis))
                of_tail = max(of_tail, _gain(tail, residual, basis))
    return of_light, of_tail


@kernel
def _gain(pattern: Array, residual: Array, basis: Array) -> float:
    """Return what a pattern of positive amplitude gains; 0 where the basis has all of it."""
    along, whole = 0.0, 0.0
    for n in range(pattern.size):
        along += pattern[n] * residual[n]
        whole += pattern[n] * pattern[n]
    own = whole
    for k in range(basis.shape[0]):
        part = 0.0
        for n in range(pattern.size):
            part += pattern[n] * basis[k, n]
        own -= part * part
    return along * along / own if along > 0.0 and own > LEAST_OWN * whole else 0.0

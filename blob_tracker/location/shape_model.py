"""The means of a lit window and their slopes, for lights that are no round pulse."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.likelihood import fill_profile
from blob_tracker.location.pair_model import (
    add_pulse, AMPLITUDE, BACKGROUND, fill_one_pulse, GHOST, SHIFT_X, SHIFT_Y, SIGMA, X, Y,
)
import numpy as np

# From the middle of a streak to its end, or from the head of a tail to its tip: where the
# parameters of the pulse's way are, in the place of the ghost's.
WAY_X, WAY_Y = SHIFT_X, SHIFT_Y
PART = 7  # of the light, that is in a tail
RADIUS, HOLE = 5, 6  # of a ring
# Of a glow in the lit window, DN: its level in the middle, what it gains from there to the right
# and lower edge, and, where it is bent, its squares and product.
GLOW, GLOW_X, GLOW_Y, GLOW_XX, GLOW_XY, GLOW_YY = 5, 6, 7, 8, 9, 10
# Gauss and Legendre's nodes and weights, exact for ways of 10 and of 30 sigma to 1e-3
FEW_NODES, FEW_WEIGHTS = np.polynomial.legendre.leggauss(10)
MANY_NODES, MANY_WEIGHTS = np.polynomial.legendre.leggauss(32)
LONG = 8.0  # sigmas of a way, from which on there are many
_SQRT2, _SQRT_TWO_PI = math.sqrt(2.0), math.sqrt(2.0 * math.pi)


@kernel
def fill_streak(theta: Array, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a lit pulse that is dragged along a line.

        lit = b + A / 2 integral_-1^1 P(x + t w) dt

    The way w is from the streak's middle to its end; A is the peak of the pulse at rest.
    """
    means[:] = theta[BACKGROUND]
    slopes[:] = 0.0
    slopes[BACKGROUND] = 1.0
    way = 2.0 * math.hypot(theta[WAY_X], theta[WAY_Y])
    long = way > LONG * theta[SIGMA]
    nodes, weights = (MANY_NODES, MANY_WEIGHTS) if long else (FEW_NODES, FEW_WEIGHTS)
    for k in range(nodes.size):
        _add_part(means[0], slopes[:, 0], theta, nodes[k], 0.5 * weights[k], 0.0)


@kernel
def fill_bent(theta: Array, bend_x: float, bend_y: float, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a lit pulse that is dragged along a line that bends.

        lit = b + A / 2 integral_-1^1 P(x + t w + (t^2 - 1/3) c) dt

    The place x is the middle of its light, c the bend, which is known.
    """
    means[:] = theta[BACKGROUND]
    slopes[:] = 0.0
    slopes[BACKGROUND] = 1.0
    way = 2.0 * math.hypot(theta[WAY_X], theta[WAY_Y])
    long = way > LONG * theta[SIGMA]
    nodes, weights = (MANY_NODES, MANY_WEIGHTS) if long else (FEW_NODES, FEW_WEIGHTS)
    place = theta.copy()
    for k in range(nodes.size):
        off = nodes[k] * nodes[k] - 1.0 / 3.0
        place[X], place[Y] = theta[X] + off * bend_x, theta[Y] + off * bend_y
        _add_part(means[0], slopes[:, 0], place, nodes[k], 0.5 * weights[k], 0.0)


@kernel
def fill_tailed(theta: Array, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a lit pulse with a tail.

        lit = b + A (1 - p) P(x) + A p integral_0^1 P(x + t w) dt
    """
    means[:] = theta[BACKGROUND]
    slopes[:] = 0.0
    slopes[BACKGROUND] = 1.0
    part = theta[PART]
    _add_part(means[0], slopes[:, 0], theta, 0.0, 1.0 - part, -1.0)
    way = math.hypot(theta[WAY_X], theta[WAY_Y])
    long = way > LONG * theta[SIGMA]
    nodes, weights = (MANY_NODES, MANY_WEIGHTS) if long else (FEW_NODES, FEW_WEIGHTS)
    for k in range(nodes.size):
        weight = 0.5 * weights[k]
        _add_part(
            means[0], slopes[:, 0], theta, 0.5 * (1.0 + nodes[k]), part * weight, weight
        )


@kernel
def _add_part(
    means: Array, slopes: Array, theta: Array, along: float, share: float, by_part: float
) -> None:
    """Add the share of a pulse that is so far along its way; `by_part` is its slope by PART."""
    height, width = means.shape
    across = np.empty((3, width))
    down = np.empty((3, height))
    fill_profile(theta[X] + along * theta[WAY_X], theta[SIGMA], across)
    fill_profile(theta[Y] + along * theta[WAY_Y], theta[SIGMA], down)
    light = share * theta[AMPLITUDE]
    for j in range(height):
        g, h, q = down[0, j], down[1, j], down[2, j]
        for i in range(width):
            pulse = g * across[0, i]
            by_x = light * g * across[1, i]
            by_y = light * h * across[0, i]
            means[j, i] += light * pulse
            slopes[X, j, i] += by_x
            slopes[Y, j, i] += by_y
            slopes[AMPLITUDE, j, i] += share * pulse
            slopes[SIGMA, j, i] += light * (q * across[0, i] + g * across[2, i])
            slopes[WAY_X, j, i] += along * by_x
            slopes[WAY_Y, j, i] += along * by_y
            if by_part != 0.0:
                slopes[PART, j, i] += by_part * theta[AMPLITUDE] * pulse


@kernel
def fill_two_lights(theta: Array, means: Array, slopes: Array) -> None:
    """Fill the means and slopes of two lit pulses of one width, so far from each other."""
    fill_one_pulse(theta, means, slopes)
    before_x = slopes[X].copy()
    before_y = slopes[Y].copy()
    slopes[X] = 0.0
    slopes[Y] = 0.0
    add_pulse(
        means[0], slopes[:, 0], theta[X] + theta[SHIFT_X], theta[Y] + theta[SHIFT_Y],
        theta[GHOST], theta[SIGMA], (X, Y, GHOST),
    )
    slopes[SHIFT_X] = slopes[X]
    slopes[SHIFT_Y] = slopes[Y]
    slopes[X] += before_x
    slopes[Y] += before_y


@kernel
def fill_glow(theta: Array, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a lit pulse on a glow that is in the lit window alone.

        lit = b + A P(x) + g + g_x u + g_y v (+ g_xx u^2 + g_xy u v + g_yy v^2)

    u and v run from -1 to 1 over the window. The bent glow has 11 parameters, the even one 8.
    """
    fill_one_pulse(theta, means, slopes)
    height, width = means.shape[1:]
    bent = theta.size > GLOW_XX
    for j in range(height):
        v = (2.0 * j - height + 1.0) / (height - 1.0)
        for i in range(width):
            u = (2.0 * i - width + 1.0) / (width - 1.0)
            slopes[GLOW, 0, j, i] = 1.0
            slopes[GLOW_X, 0, j, i] = u
            slopes[GLOW_Y, 0, j, i] = v
            means[0, j, i] += theta[GLOW] + theta[GLOW_X] * u + theta[GLOW_Y] * v
            if bent:
                slopes[GLOW_XX, 0, j, i] = u * u
                slopes[GLOW_XY, 0, j, i] = u * v
                slopes[GLOW_YY, 0, j, i] = v * v
                means[0, j, i] += (
                    theta[GLOW_XX] * u * u + theta[GLOW_XY] * u * v + theta[GLOW_YY] * v * v
                )


@kernel
def fill_disc(theta: Array, means: Array, slopes: Array) -> None:
    """
    Fill the means and slopes of a lit disc of the level A with soft edges.

        lit = b + A / 2 erfc((r - R) / sqrt2 s)

    The pixel's own width is in the softness s: (s^2 + 1/12) in the place of s^2.
    """
    means[:] = theta[BACKGROUND]
    slopes[:] = 0.0
    slopes[BACKGROUND] = 1.0
    _add_edge(means[0], slopes[:, 0], theta, RADIUS, 1.0)


@kernel
def fill_ring(theta: Array, means: Array, slopes: Array) -> None:
    """Fill the means and slopes of a lit ring: a disc less a smaller one."""
    fill_disc(theta, means, slopes)
    _add_edge(means[0], slopes[:, 0], theta, HOLE, -1.0)


@kernel
def _add_edge(means: Array, slopes: Array, theta: Array, place: int, sign: float) -> None:
    """Add a disc, or take it away; `place` is that of its radius."""
    height, width = means.shape
    soft = math.sqrt(theta[SIGMA] ** 2 + 1.0 / 12.0)
    for j in range(height):
        down = j - theta[Y]
        for i in range(width):
            across = i - theta[X]
            distance = math.sqrt(across * across + down * down)
            beyond = (distance - theta[place]) / soft
            if beyond > 6.0:
                continue
            level = 0.5 * sign * math.erfc(beyond / _SQRT2)
            means[j, i] += theta[AMPLITUDE] * level
            slopes[AMPLITUDE, j, i] += level
            steep = (
                sign * theta[AMPLITUDE] * math.exp(-0.5 * beyond * beyond) / (_SQRT_TWO_PI * soft)
            )
            slopes[place, j, i] += steep
            slopes[SIGMA, j, i] += steep * beyond * theta[SIGMA] / soft
            if distance > 0.0:
                slopes[X, j, i] += steep * across / distance
                slopes[Y, j, i] += steep * down / distance

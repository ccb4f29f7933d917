"""A scene that is lit differently in the two frames, by lamps, exposure or the flash itself."""

from __future__ import annotations

from dataclasses import replace
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.likelihood import fill_profile
from blob_tracker.location.noise import variance_at
from blob_tracker.types import SensorNoise
import numpy as np

REACH = 2.5  # sigma about the light, that are left out
FARTHEST = 0.35  # of the window's side: a light that seems larger seems so before another scene
Light = tuple[float, float, float, float]  # x and y, px; amplitude, DN; sigma, px
FEWEST_PX = 24  # about the light, that tell a gain or a correlation
STRONG = 1.0  # variance of a texture over that of its noise: of a weaker one no gain is known
SIGMAS = 4.5  # standard deviations of the gain, beyond which it is not 1
LOWEST, HIGHEST = 0.3, 3.0  # what is beyond is another texture
MOVED = 0.3  # of the gain from 1, that the correlation of the two may lack: else the texture moves


class Relit(NamedTuple):
    """
    The unlit window as the scene of the lit frame would look without the light.

    Parameters
    ----------
    unlit, other : (h, w) arrays
        DN; the other one if the gain is by its standard deviation more.
    noise : SensorNoise
        So that it is right in lit less unlit.
    warning : str
        What the user should know and do.

    """

    unlit: Array
    other: Array
    noise: SensorNoise
    warning: str


def relit(
    lit: Array, unlit: Array, noise: SensorNoise, limit: float, light: Light
) -> Relit | None:
    """
    Return the unlit window with gain and offset of the pixels about the light; None if unknown.

        unlit' = c + r unlit

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.
    noise : SensorNoise
        Of a pixel, its black level taken off already.
    limit : float
        DN of a clipped pixel.
    light : Light
        As it was fitted.

    """
    seen = unlit[unlit < limit]
    variance = variance_at(float(seen.sum()) / seen.size, noise)
    gain, deviation, level, before = texture_gain(lit, unlit, limit, light, variance)
    if math.isinf(deviation):
        return None
    behind, other = (level + each * (unlit - before) for each in (gain, gain + deviation))
    added = gain**2 * variance - variance_at(level, noise)
    read_noise = math.sqrt(max(noise.read_noise**2 + 0.5 * added, 0.0))
    change = 100.0 * (gain - 1.0)
    return Relit(behind, other, replace(noise, read_noise=read_noise), (
        f'the scene behind the light is {abs(change):.0f} % '
        f"{'brighter' if change > 0.0 else 'darker'} in the lit frame, by lamps on the mains, "
        'auto-exposure or the flash itself: it is taken off; expose for whole periods (10 ms at '
        '50 Hz, 8.3 ms at 60 Hz), switch auto-exposure off, or shade the scene from the light'
    ))


@kernel
def is_relit(
    lit: Array, unlit: Array, limit: float, theta: Array, white: float, variance: float
) -> bool:
    """
    Tell whether the texture behind a light is brighter or darker in one of the frames.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.
    limit : float
        DN of a clipped pixel.
    theta : (6,) array
        The fit: x, y, amplitude, background and the widths.
    white, variance : float
        Variance of the unlit texture over that of its noise, and that, DN^2.

    """
    if white <= STRONG:
        return False
    light = theta[0], theta[1], theta[2], math.sqrt(theta[4] * theta[5])
    gain, deviation, _, _ = texture_gain(lit, unlit, limit, light, variance)
    return LOWEST < gain < HIGHEST and abs(gain - 1.0) > SIGMAS * deviation


@kernel
def texture_gain(
    lit: Array, unlit: Array, limit: float, light: Light, variance: float
) -> tuple[float, float, float, float]:
    """
    Return the gain of the lit pixels over the unlit ones, its deviation, and both levels, DN.

    With S_lu the products of the two without their means, and n V the squares of the noise, the
    texture has the gain S_lu / (S_uu - n V). If one light shines on the scene it is that of the
    levels, which are known better: of its distance t from there, in standard deviations, the
    part 1 - 1 / t^2 is kept (James and Stein, 1961).

    The gain is 1 where too few pixels or too little texture are about the light, and where the
    two have less in common than their gain makes of it, as of a texture that moves.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.
    limit : float
        DN of a clipped pixel.
    light : Light
        As it was fitted; its wings are taken off.
    variance : float
        V, of an unlit pixel, DN^2.

    """
    height, width = lit.shape
    x, y, amplitude, sigma = light
    across, down = np.empty((3, width)), np.empty((3, height))
    fill_profile(x, sigma, across)
    fill_profile(y, sigma, down)
    radius = REACH * sigma
    if radius > FARTHEST * min(height, width):
        radius, amplitude = FARTHEST * min(height, width), 0.0  # nor are its wings its own
    one, other, lit_square, unlit_square, product, count = 0.0, 0.0, 0.0, 0.0, 0.0, 0
    for j in range(height):
        away = (j - y) ** 2
        for i in range(width):
            a, b = lit[j, i], unlit[j, i]
            if a < limit and b < limit and (i - x) ** 2 + away > radius * radius:
                a -= amplitude * down[0, j] * across[0, i]
                one += a
                other += b
                lit_square += a * a
                unlit_square += b * b
                product += a * b
                count += 1
    if count < FEWEST_PX:
        return 1.0, math.inf, 0.0, 0.0
    one /= count
    other /= count
    product -= count * one * other
    noise = count * variance
    behind = unlit_square - count * other * other - noise
    before = lit_square - count * one * one - noise
    if not behind > STRONG * noise or not before > 0.0 or not product > 0.0:
        return 1.0, math.inf, one, other
    gain = product / behind
    lacks = 1.0 - product / math.sqrt(behind * before)
    if lacks > MOVED * abs(gain - 1.0):
        return 1.0, math.inf, one, other
    square = (1.0 + gain * gain) * variance / behind
    if other > 0.0 and one > 0.0:
        of_levels = one / other
        kept = max(1.0 - square / max((gain - of_levels) ** 2, 1e-12), 0.0)
        gain = of_levels + kept * (gain - of_levels)
        square = kept * square + (1.0 + gain * gain) * variance / (count * other * other)
    return gain, math.sqrt(square), one, other


def compile_relit() -> None:
    """Compile what looks at the texture, or load it."""
    picture = np.arange(49.0).reshape(7, 7)
    relit(picture, picture, SensorNoise(1.0, 1.0), math.inf, (3.0, 3.0, 1.0, 1.0))

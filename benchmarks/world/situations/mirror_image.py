"""5: a mirror image that flashes with the light and is merged with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from benchmarks.world.light import flashing, gaussians
from benchmarks.world.situation import (
    BACKGROUND, Floats, Model, PEAK, SHAPE, Shot, SIGMA, Situation,
)
import numpy as np

ANGLE = 0.5  # rad, of the line from the light to its image


def frames(
    count: int, random: np.random.Generator, distance: float, part: float
) -> Iterator[Shot]:
    """Yield a light with an image of a part of its brightness; one as bright is as right."""
    across, down = distance * np.cos(ANGLE), distance * np.sin(ANGLE)

    def light(x: float, y: float) -> Model:
        return Model(
            both, np.array([x, y, PEAK, SIGMA, BACKGROUND, x + across, y + down, part * PEAK])
        )

    for shot in flashing(count, random, light):
        if shot.on and part == 1.0:
            shot = replace(shot, also=(shot.x + across, shot.y + down))
        yield shot


def both(parameters: Floats) -> Floats:
    """Return the frame: x, y, peak, sigma, background, and the image's x, y, peak."""
    x, y, peak, sigma, background, image_x, image_y, image = parameters
    return gaussians(SHAPE, [x, image_x], [y, image_y], sigma, [peak, image]) + background


SITUATIONS = [
    Situation(
        5, 'mirror image in step, merged', f'{distance:g} px, {part:g} as bright',
        partial(frames, distance=distance, part=part),
        r'two (lights|blobs|peaks)|second (light|blob|peak)|mirror|reflection|merged|misfit',
    )
    for distance, part in ((3.0, 1.0), (4.5, 0.5), (6.0, 0.5))
]

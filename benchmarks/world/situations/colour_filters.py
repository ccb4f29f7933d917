"""16: a red light behind the colour filters of a Bayer sensor."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.world.light import digitised, flashing, gaussians
from benchmarks.world.situation import BACKGROUND, Floats, Model, PEAK, SHAPE, Shot, Situation
from blob_tracker.types import Pixels
import cv2
import numpy as np

GREEN, BLUE = 0.08, 0.02  # of red, at 625 nm
RESPONSE = np.tile([[1.0, GREEN], [GREEN, BLUE]], (SHAPE[0] // 2, SHAPE[1] // 2))  # RGGB


def frames(
    count: int, random: np.random.Generator, sigma: float, peak: float, luma: bool
) -> Iterator[Shot]:
    """Yield a red light as the raw mosaic, or as the grey of its demosaiced colours."""

    def light(x: float, y: float) -> Model:
        return Model(mosaic, np.array([x, y, peak, sigma, BACKGROUND]))

    return flashing(count, random, light, develop=grey if luma else digitised)


def mosaic(parameters: Floats) -> Floats:
    """Return the raw frame: x, y, peak in red, sigma, background."""
    x, y, peak, sigma, background = parameters
    return np.asarray(RESPONSE * gaussians(SHAPE, x, y, sigma, peak) + background)


def grey(mean: Floats, random: np.random.Generator) -> Pixels:
    """Return what a camera that sends grey pictures makes of its mosaic."""
    # OpenCV names a pattern by the second row's second and third pixel: BG is RGGB.
    colours = cv2.cvtColor(digitised(mean, random), cv2.COLOR_BAYER_BG2BGR)
    return np.asarray(cv2.cvtColor(colours, cv2.COLOR_BGR2GRAY))


SITUATIONS = [
    Situation(
        16, 'red light, ' + ('demosaiced luma' if luma else 'raw RGGB mosaic'),
        f'sigma {sigma:g} px, {peak:g} DN',
        partial(frames, sigma=sigma, peak=peak, luma=luma),
        r'bayer|mosaic|colou?r|channel', layout='grey' if luma else 'rggb',
    )
    for luma in (False, True)
    for sigma, peak in ((0.7, PEAK), (1.2, PEAK), (2.0, PEAK), (1.5, 40.0))
]

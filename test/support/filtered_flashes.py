"""A light that flashes in every other frame, behind filters or a codec, with its truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from blob_tracker.location import locate
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.segmentation import Segmenter
from blob_tracker.types import Frame, LocationError, Pixels, SensorNoise
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SHAPE = (72, 96)
NOISE = SensorNoise(gain=10.0, read_noise=1.0)
BACKGROUND = 30.0  # DN
FIRST = 20  # frames that do not count: the light is confirmed by then
STEP_NS = 16_666_667


def gaussian(x: float, y: float, sigma: float) -> Floats:
    """Return a pixel-integrated pulse of unit peak."""
    across = integrated_profile(SHAPE[1], x, sigma)[0]
    return np.outer(integrated_profile(SHAPE[0], y, sigma)[0], across)


def digitised(mean: Floats, random: np.random.Generator) -> Pixels:
    """Return the pixels of 8 bits that a sensor makes of their mean, DN."""
    electrons = random.poisson(mean * NOISE.gain) / NOISE.gain
    noisy = electrons + NOISE.read_noise * random.standard_normal(mean.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def flashes(
    count: int, sigma: float, peak: float, develop: Callable[[Floats, np.random.Generator], Frame],
    seed: int,
) -> Iterator[tuple[Frame, Floats | None]]:
    """
    Yield frames, and where the light is in those that are lit.

    `develop` makes a frame of the light's mean, DN without a background; its stamp does not
    matter.
    """
    random = np.random.default_rng(seed)
    for index in range(count):
        x, y = 44.0 + 6.0 * np.sin(0.011 * index), 34.0 + 5.0 * np.cos(0.017 * index)
        lit = index % 2 == 0
        light = peak * gaussian(x, y, sigma) if lit else np.zeros(SHAPE)
        yield develop(light, random), np.array([x, y]) if lit else None


def judge(
    segmenter: Segmenter, frames: Iterator[tuple[Frame, Floats | None]],
    noise: SensorNoise = NOISE,
) -> tuple[float, float, Floats]:
    """Return the share of flashes that were found, their NEES, and the mean error, px."""
    lit, squares, errors = 0, [], []
    for index, (frame, place) in enumerate(frames):
        window = segmenter.update(replace(frame, stamp_ns=10**18 + index * STEP_NS))
        if index < FIRST:
            continue
        lit += place is not None
        try:
            found = None if window is None else locate(window, noise=noise)
        except LocationError:
            found = None
        if found is not None:
            assert place is not None, 'found in an unlit frame'
            error = np.array([found.x, found.y]) - place
            errors.append(error)
            squares.append(error @ np.linalg.solve(found.covariance, error))
    return len(squares) / lit, float(np.mean(squares)), np.mean(errors, axis=0)

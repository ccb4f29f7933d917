"""Frames of lights that blink and move: true streaks, exposure by exposure."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.blink.lights import EXPOSURE, Floats, HEIGHT, Light, WIDTH
from benchmarks.blink.points import NOISE, PEAK, SIGMA
import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

BACKGROUND = 20.0  # DN
SAMPLES = 64  # of an exposure: a third of a px at 20 px a frame
REACH = 5.0  # sigma
FULL_SCALE = 255


def frame(
    lights: Sequence[Light], hidden: Sequence[bool], time: float, random: np.random.Generator,
    extra: NDArray[np.float32] | None = None,
) -> NDArray[np.uint8]:
    """Return the picture of an exposure about a time, with extra light in it, DN."""
    image = BACKGROUND + NOISE * random.standard_normal((HEIGHT, WIDTH), dtype=np.float32)
    if extra is not None:
        image += extra
    offsets = ((np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5) * EXPOSURE
    for light, away in zip(lights, hidden):
        on = light.on(time + offsets)
        if away or not on.any():
            continue
        places = light.path.at(time + offsets[on])
        add(image, places, PEAK / SAMPLES)
    return np.clip(np.rint(image), 0, FULL_SCALE).astype(np.uint8)


def add(image: NDArray[np.float32], places: Floats, peak: float) -> None:
    """Add a Gaussian of this peak, integrated over each pixel, at each of the places."""
    low = np.maximum(np.floor(places.min(axis=0) - REACH * SIGMA).astype(int), 0)
    high = np.minimum(np.ceil(places.max(axis=0) + REACH * SIGMA).astype(int) + 1, (WIDTH, HEIGHT))
    if (high <= low).any():
        return
    across, down = (_profiles(places[:, k], low[k], high[k]) for k in range(2))
    image[low[1]:high[1], low[0]:high[0]] += peak * 2 * np.pi * SIGMA**2 * (down.T @ across)


def _profiles(centres: Floats, low: int, high: int) -> Floats:
    """Return (n, pixels) of a unit Gaussian about each centre, integrated over the pixels."""
    edges = np.arange(low, high + 1) - 0.5
    steps = 0.5 * erf((edges - centres[:, None]) / (np.sqrt(2.0) * SIGMA))
    return np.asarray(np.diff(steps, axis=1))

"""How well the blob is placed from a camera that moves, beside one that stands still."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from benchmarks.accuracy import compare
from benchmarks.clutter import HEIGHT, RATE, WIDTH, with_target
from benchmarks.detection import contains, FIRST, MAX_PAIR_INTERVAL
from blob_tracker.location import locate
from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.simulation import Drifting, Scene
from blob_tracker.types import Frame, LocationError
import numpy as np
from numpy.typing import NDArray

Tick = Callable[[str], None]

SPEED = 5.0  # px a frame
SIGMA = 2.0  # px
SNRS = (10.0, 20.0, 50.0)
WALL = Scene(width=WIDTH, height=HEIGHT, rate=RATE, background=60.0, texture=15.0)
# The direction of a circle changes from frame to frame, its speed does not.
CAMERAS = {
    'translation': Drifting(SPEED, radius=30.0),
    'affine': Drifting(SPEED, radius=30.0, turn=1.0),
}


@dataclass(frozen=True)
class Row:
    """
    One registration at one SNR.

    Parameters
    ----------
    registration : str
        Of the moving camera's frames; those of the still one need none.
    snr : float
        Peak SNR of the target.
    still, moving : float
        rms error of x and y together on the frames that both have placed, px.
    ratio, spread : float
        moving over still, and the standard error of its logarithm.
    lit : int
        Lit frames.
    found_still, found_moving : int
        How many of them were placed.

    """

    registration: str
    snr: float
    still: float
    moving: float
    ratio: float
    spread: float
    lit: int
    found_still: int
    found_moving: int


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(CAMERAS) * len(SNRS)


def run(count: int, tick: Tick) -> list[Row]:
    """Return the rows from `count` frames each: the same wall, light and path in the scene."""
    rows = []
    for snr in SNRS:
        scene = with_target(WALL, snr, SIGMA)
        still = errors(scene, 'none', count)
        for registration, camera in CAMERAS.items():
            tick(f'motion {registration}, SNR {snr:g}')
            moving = errors(replace(scene, camera=camera), registration, count)
            rows.append(_row(registration, snr, still, moving))
    return rows


def errors(scene: Scene, registration: str, count: int) -> NDArray[np.float64]:
    """
    Return (N, 2) px, located less true in each lit frame; NaN where the target was not placed.

    A window of something else is none of the target: `detection` counts those.
    """
    segmenter = Segmenter(
        flash=flash_by_name(
            'alternate',
            max_pair_interval=MAX_PAIR_INTERVAL,
            registration=registration,
        )
    )
    found = []
    for index in range(count):
        frame = Frame(scene.frame(index), scene.stamp_ns(index), scene.sensor.saturation)
        window = segmenter.update(frame)
        truth = scene.truth(index)
        if index < FIRST or not truth.lit:
            continue
        error = (np.nan, np.nan)
        if window is not None and contains(window, truth):
            try:
                location = locate(window, method='maximum_likelihood', noise=scene.sensor.noise)
                error = (location.x - truth.x, location.y - truth.y)
            except LocationError:
                pass  # not found
        found.append(error)
    return np.array(found)


def _row(
    registration: str, snr: float, still: NDArray[np.float64], moving: NDArray[np.float64]
) -> Row:
    placed = [np.isfinite(each[:, 0]) for each in (still, moving)]
    both = placed[0] & placed[1]
    ratio, spread = compare(moving[both], still[both])
    rms = [
        float(np.sqrt((each[both] ** 2).mean())) if both.any() else float('nan')
        for each in (still, moving)
    ]
    return Row(
        registration, snr, rms[0], rms[1], ratio, spread, len(still),
        int(placed[0].sum()), int(placed[1].sum()),
    )

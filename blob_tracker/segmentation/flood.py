"""A whole scene that lights up with the flash, and what in it may be a light all the same."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
import numpy as np

SAMPLES = 48  # pixels along either axis that are looked at
LEAST_SHARE = 0.75  # of them, that rise: a glow covers less
LEAST_NOISES = 3.0  # standard deviations of one pixel that each of these rises by
# Times what the scene rose by, that a light rises by: a wall is at most a few times as bright as
# another, and a light or a retro-reflector far more.
LIGHT_RATIO = 5.0


def flood_rise(contrast: Contrast, region: Box) -> float:
    """
    Return by how much the whole scene rose, DN; 0 where only a part of it did, or nothing.

    The noise is that of the unlit frame: what the light draws on the walls is none.

    Parameters
    ----------
    contrast : Contrast
        Lit and unlit pixels.
    region : Box
        Where to look.

    """
    rows, columns = (
        slice(start, end, max((end - start) // SAMPLES, 1))
        for start, end in ((region.y0, region.y1), (region.x0, region.x1))
    )
    before = contrast.unlit[rows, columns].astype(np.int32)
    rise = contrast.lit[rows, columns] - before
    beside = contrast.unlit[rows, columns.start + 1:columns.stop:columns.step]
    width = min(before.shape[1], beside.shape[1])
    # Of two neighbours, so that the scene has little part in it.
    apart = np.abs(before[:, :width] - beside[:, :width])
    noise = max(float(np.sqrt(0.5 * np.mean(np.square(apart)))), contrast.floor)
    level = float(np.median(rise))
    if np.count_nonzero(rise > LEAST_NOISES * noise) < LEAST_SHARE * rise.size:
        return 0.0
    return level


def without_flooded(
    candidates: Sequence[Candidate], rise: float
) -> tuple[Candidate, ...]:
    """
    Return the candidates with those rejected that are no brighter than a flooded scene has things.

    Parameters
    ----------
    candidates : sequence of Candidate
        What lit up.
    rise : float
        Of the whole scene, DN.

    """
    return tuple(
        each if each.rejected or each.amplitude >= LIGHT_RATIO * rise else each._replace(
            rejected=f'a rise of {each.amplitude:.0f} DN where {whole_scene(rise)}'
        )
        for each in candidates
    )


def whole_scene(rise: float) -> str:
    """Say what happens to the scene."""
    return (
        f'the whole scene flashes, by {rise:.0f} DN: a flood light in step with the frames, and '
        f'nothing {LIGHT_RATIO:g} times as bright in it'
    )

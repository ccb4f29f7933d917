"""Lit and unlit pixels, and what lit up in them, for the tests of the segmentation."""

from __future__ import annotations

from typing import Any

from blob_tracker.segmentation.box import Box, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.search import search, SearchResult
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise
import numpy as np

READ_NOISE = SensorNoise(gain=np.inf, read_noise=1.0)
DEVIATION = float(np.sqrt(2 * (1.0 + 1 / 12)))  # of a difference pixel: two of read noise 1 DN


def contrast_of(
    lit: np.ndarray, unlit: np.ndarray | None = None, saturation: int | None = None
) -> Contrast:
    """Return what is compared; nothing is subtracted where there is no unlit frame."""
    full = int(np.iinfo(lit.dtype).max) if saturation is None else saturation
    unlit_frames = () if unlit is None else (unlit,)
    if unlit is None:
        unlit = np.zeros_like(lit)
    return Contrast(lit, unlit, full, Frame(lit, 0, full), (lit,), unlit_frames)


def candidate_at(column: int, row: int, **changes: Any) -> Candidate:
    """Return a clean blob of 2 px and 100 DN with its peak in this pixel."""
    fields: dict[str, Any] = dict.fromkeys(Candidate._fields, 0.0)
    fields |= {'x': float(column), 'y': float(row), 'column': float(column), 'row': float(row)}
    fields |= dict.fromkeys(['sigma_x', 'sigma_y', 'sigma_major', 'sigma_minor'], 2.0)
    fields |= {'snr': 100.0, 'height': 100.0, 'amplitude': 100.0, 'noise': 1.0}
    fields |= {'neighbour_ratio': 0.9}
    return Candidate(**{**fields, 'rejected': '', 'glimpse': None, 'unlit': None, **changes})


def noisy_blob(
    shape: tuple[int, int],
    x: float,
    y: float,
    sigma: float,
    amplitude: float,
    *,
    level: float = 40.0,
    seed: int = 1,
    sigma_y: float | None = None,
    saturation: int = 255,
) -> Contrast:
    """Return a blob of this peak on an even level, with read noise of 1 DN."""
    random = np.random.default_rng(seed)
    unlit = np.full(shape, level)
    lit = unlit + amplitude * pixel_integrated_gaussian(shape, x, y, sigma, sigma_y)
    seen, before = (
        expose(mean, READ_NOISE, random, saturation=saturation) for mean in (lit, unlit)
    )
    return contrast_of(seen, before, saturation)


def searched(contrast: Contrast, region: Box | None = None, **options: Any) -> SearchResult:
    """Return what lit up, in the whole frame where no region is given."""
    return search(contrast, region or whole(contrast.shape), **{'min_snr': 7.0, **options})
